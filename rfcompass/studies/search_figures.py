"""Studies after Fig. 9 of [Boroushaki2023], by complexity, number and places of tags."""

from collections.abc import Mapping, Sequence

import numpy as np

from rfcompass.evaluation.records import MetricValue
from rfcompass.studies.searches import DIFFERS, KNOWN, TAGS, TUNED_BELOW, Arm, metrics_of, row_of
from rfcompass.studies.study import Cell, PaperValue, Study

LEVELS = ("covered_2p20", "covered_3p25", "covered_3p42")
BY_LEVEL: Mapping[str, Arm] = {
    "fusebot_8": Arm("fusebot", TAGS),
    "xray": Arm("xray"),
    "xray_views": Arm("xray_views"),
    "ours_8": Arm("ours", TAGS),
    KNOWN: Arm(KNOWN),
}
LEVEL_PAIRS: Sequence[tuple[str, str]] = (
    ("fusebot_8", "xray"),
    ("ours_8", "fusebot_8"),
    ("ours_8", "xray"),
    ("ours_8", "xray_views"),
    (KNOWN, "ours_8"),
)
PLACEMENTS = ("touching", "opposite", "other_pile")
# Fig. 9b has 0 to 9 tags, Fig. 9c a few of them touching the target, opposite, or in other piles.
BY_TAGS: Mapping[str, Arm] = {
    **{f"{way}_{count}": Arm(way, count) for way in ("fusebot", "ours") for count in (0, 3, 6, 9)},
    **{f"fusebot_{placement}": Arm("fusebot", 3, placement) for placement in PLACEMENTS},
    "xray": Arm("xray"),
}
TAG_PAIRS: Sequence[tuple[str, str]] = (
    *((f"{way}_{count}", f"{way}_0") for way in ("fusebot", "ours") for count in (3, 6, 9)),
    ("fusebot_touching", "fusebot_other_pile"),
    ("fusebot_opposite", "fusebot_other_pile"),
    *((f"fusebot_{which}", "xray") for which in (0, 9, *PLACEMENTS)),
    *((f"ours_{count}", "xray") for count in (0, 9)),
)
_NOTE = (
    "As in the study `searches`: hidden targets, executed grasps, masks from depth. Only some items can carry a tag; "
    "where a pile has none of them at the place that is asked for, the trial has no value for that arm."
)


def levels_trial(cell: Cell, seed: int, rng: np.random.Generator) -> Mapping[str, MetricValue]:  # noqa: ARG001
    """Search one pile of a level by each method."""
    return row_of(str(cell["family"]), seed, BY_LEVEL, LEVEL_PAIRS)


def tags_trial(cell: Cell, seed: int, rng: np.random.Generator) -> Mapping[str, MetricValue]:  # noqa: ARG001
    """Search one pile with different tags."""
    return row_of(str(cell["family"]), seed, BY_TAGS, TAG_PAIRS)


def _printed(arm: str, median: float, figure: str) -> PaperValue:
    return PaperValue(f"actions_{arm}", "median", median, f"[Boroushaki2023] Fig. {figure}", DIFFERS)


SEARCH_LEVELS = Study(
    name="search-levels",
    title="Searching piles of growing complexity",
    kind="simulated",
    factors={"family": LEVELS},
    seeds=range(1000, 1034),
    tuning_seeds=range(TUNED_BELOW),
    trial=levels_trial,
    metrics=metrics_of(BY_LEVEL, LEVEL_PAIRS),
    note=_NOTE,
)
SEARCH_TAGS = Study(
    name="search-tags",
    title="Searching piles by how many tags there are, and where",
    kind="simulated",
    factors={"family": ("covered_3p25",)},
    seeds=range(1000, 1100),
    tuning_seeds=range(TUNED_BELOW),
    trial=tags_trial,
    metrics=metrics_of(BY_TAGS, TAG_PAIRS),
    paper=(
        _printed("fusebot_0", 4.0, "9b"),
        _printed("fusebot_6", 2.0, "9b"),
        _printed("fusebot_9", 2.0, "9b"),
        _printed("fusebot_other_pile", 2.0, "9c"),
        _printed("fusebot_opposite", 3.0, "9c"),
        _printed("fusebot_touching", 3.0, "9c"),
    ),
    note=_NOTE,
)
