"""Study: what `searches` suggests, asked again of 402 other piles.

A claim of half an action wants some 400 piles, and `searches` has 102 and two dozen intervals. Here the methods that
matter most are compared on seeds that no other study has, with all constants as they were.
"""

from collections.abc import Mapping, Sequence

import numpy as np

from rfcompass.evaluation.records import MetricValue
from rfcompass.studies.pile_scenes import FAMILIES
from rfcompass.studies.searches import ARMS, TUNED_BELOW, Arm, metrics_of, row_of
from rfcompass.studies.study import Cell, Study

CONFIRM_ARMS: Mapping[str, Arm] = {
    name: ARMS[name] for name in ("fusebot_0", "fusebot_8", "xray_views", "ours_0", "ours_8")
}
# The first four are the claims; the others say what tags do, and where the paper's method stands.
CONFIRM_PAIRS: Sequence[tuple[str, str]] = (
    ("ours_0", "fusebot_0"),
    ("ours_8", "fusebot_8"),
    ("ours_0", "xray_views"),
    ("ours_8", "xray_views"),
    ("ours_8", "ours_0"),
    ("fusebot_8", "fusebot_0"),
    ("fusebot_0", "xray_views"),
    ("fusebot_8", "xray_views"),
)


def confirm_trial(cell: Cell, seed: int, rng: np.random.Generator) -> Mapping[str, MetricValue]:  # noqa: ARG001
    """Search one pile by each of these methods."""
    return row_of(str(cell["family"]), seed, CONFIRM_ARMS, CONFIRM_PAIRS)


SEARCH_CONFIRM = Study(
    name="search-confirm",
    title="Ours, FuseBot and the stronger X-Ray on 402 other piles",
    kind="simulated",
    factors={"family": FAMILIES},
    seeds=range(1100, 1234),
    tuning_seeds=range(TUNED_BELOW),
    trial=confirm_trial,
    metrics=metrics_of(CONFIRM_ARMS, CONFIRM_PAIRS),
    note=(
        "As in the study `searches`, on piles that no other study has. Methods and pairs were named before the "
        "first of these piles was searched."
    ),
)
