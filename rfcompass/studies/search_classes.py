"""Study: searches by how much of the target is in sight, after the three settings of [Boroushaki2023], section 3.

Where a view of the scan shows enough of the target, its colour says where it is, and every method goes for it alike: it
grasps it, or what lies beside it where no grasp on it promises anything. Then methods differ only in what they grasp
from, and in what happens after a grasp that failed.
"""

from collections.abc import Mapping, Sequence

import numpy as np

from rfcompass.evaluation.records import MetricValue
from rfcompass.simulation.piles import TARGET_CLASSES
from rfcompass.studies.pile_scenes import FAMILIES
from rfcompass.studies.searches import ARMS, TUNED_BELOW, Arm, metrics_of, row_of
from rfcompass.studies.study import Cell, Study

BY_CLASS: Mapping[str, Arm] = {name: ARMS[name] for name in ("fusebot_8", "xray", "ours_8")}
CLASS_PAIRS: Sequence[tuple[str, str]] = (("fusebot_8", "xray"), ("ours_8", "fusebot_8"), ("ours_8", "xray"))


def classes_trial(cell: Cell, seed: int, rng: np.random.Generator) -> Mapping[str, MetricValue]:  # noqa: ARG001
    """Search one pile with a target of one class by each method."""
    return row_of(str(cell["family"]), seed, BY_CLASS, CLASS_PAIRS, str(cell["target_class"]))


SEARCH_CLASSES = Study(
    name="search-classes",
    title="Searching piles for a thing that is hidden, partly covered or in the open",
    kind="simulated",
    factors={"family": FAMILIES, "target_class": TARGET_CLASSES},
    seeds=range(1000, 1012),
    tuning_seeds=range(TUNED_BELOW),
    trial=classes_trial,
    metrics=metrics_of(BY_CLASS, CLASS_PAIRS),
    note=(
        "As in the study `searches`, and piles of equal seed but another class are other piles. Hidden: no view of the "
        "scan has a pixel of the target. Partly: the view that sees most of it sees 30 to 70 %. Open: 95 % or more. A "
        "target in sight is found by its colour, and every method alike grasps it, or first a neighbour where no grasp "
        "on what is seen of it promises anything: a target that is partly covered takes several actions as a rule."
    ),
)
