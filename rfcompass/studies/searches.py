"""Study: the whole search, method beside method on the same piles [Boroushaki2023], Tables 1 to 3.

One trial is one pile, searched by every method, each from the start: differences are paired, and the noise of a motion
is the same for methods that have done the same so far.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from planners.search_beliefs import Belief
from rfcompass.errors import PileError
from rfcompass.evaluation.records import MetricValue
from rfcompass.simulation.piles import PileScene, TaggedItems
from rfcompass.studies.metric import SHARE, Metric
from rfcompass.studies.pile_robot import SimulatedPileRobot
from rfcompass.studies.pile_scenes import FAMILIES, HIDDEN, pile_scene
from rfcompass.studies.search_bounds import TrueOthers, TruePlace
from rfcompass.studies.search_methods import search_method
from rfcompass.studies.searching import SearchRun, SearchTask, tagged_items_of
from rfcompass.studies.study import Cell, PaperValue, Study
from rfcompass.types import SearchResult
from rfcompass.types.search import ARM_STOPPED

TAGS = 8
TUNED_BELOW = 45  # seeds on which constants of policies and grasps were chosen
LOST = 16.0  # actions that a search counts which did not find its target; one more than are allowed
# Bounds, told by the simulator: the target's place is known, or where and how all other things lie.
KNOWN, OTHERS_KNOWN = "known", "others_known"


class Arm(NamedTuple):
    """One way of searching, on piles with tags.

    Attributes:
        way: Name in `search_methods.METHODS`, or in `BOUNDS`.
        tags: Number of tagged distractors, as far as there are items for them.
        placement: Where the tagged ones are, as in `tag_items`.
        only_soft: Whether only things that give way are tagged.
        share: Of all distractors, how many are tagged beside those.
    """

    way: str
    tags: int = 0
    placement: str = "any"
    only_soft: bool = False
    share: float = 0.0


ARMS: Mapping[str, Arm] = {
    "fusebot_0": Arm("fusebot"),
    "fusebot_quarter": Arm("fusebot", share=0.25),
    "fusebot_8": Arm("fusebot", TAGS),
    "fusebot_own": Arm("fusebot", 0, "target"),
    "fusebot_equal": Arm("fusebot_equal"),
    "fusebot_posterior": Arm("fusebot_posterior"),
    "fusebot_no_gate": Arm("fusebot_no_gate"),
    "xray": Arm("xray"),
    "xray_equal": Arm("xray_equal"),
    "xray_views": Arm("xray_views"),
    "naive": Arm("naive"),
    "random_gate": Arm("random_gate"),
    "ours_plain": Arm("ours_plain"),
    "ours_0": Arm("ours"),
    "ours_8": Arm("ours", TAGS),
    OTHERS_KNOWN: Arm(OTHERS_KNOWN),
    KNOWN: Arm(KNOWN),
}
# What the methods above lack to have each baseline with the gate of Eq. 5 and without.
GATE_ARMS: Mapping[str, Arm] = {
    "fusebot_own_no_gate": Arm("fusebot_no_gate", 0, "target"),
    "xray_gate": Arm("xray_gate"),
    "xray_views_no_gate": Arm("xray_views_no_gate"),
    "naive_gate": Arm("naive_gate"),
    "largest": Arm("largest"),
    "largest_gate": Arm("largest_gate"),
    "random": Arm("random"),
}
EVERY_ARM: Mapping[str, Arm] = {**ARMS, **GATE_ARMS}
# With the gate, and without.
GATE_PAIRS: Sequence[tuple[str, str]] = (
    ("fusebot_0", "fusebot_no_gate"),
    ("fusebot_own", "fusebot_own_no_gate"),
    ("xray_gate", "xray"),
    ("xray_views", "xray_views_no_gate"),
    ("naive_gate", "naive"),
    ("largest_gate", "largest"),
    ("random_gate", "random"),
)
# Differences of actions that are reported: the first less the second.
PAIRS: Sequence[tuple[str, str]] = (
    ("fusebot_0", "xray"),
    ("fusebot_8", "xray"),
    ("fusebot_quarter", "xray"),
    ("fusebot_own", "xray"),
    ("fusebot_8", "fusebot_0"),
    ("fusebot_own", "fusebot_0"),
    ("fusebot_0", "naive"),
    ("fusebot_0", "random_gate"),
    ("fusebot_equal", "fusebot_0"),
    ("fusebot_equal", "xray_equal"),
    ("ours_0", "fusebot_0"),
    ("ours_8", "fusebot_8"),
    ("ours_0", "xray"),
    ("ours_8", "xray"),
    ("ours_0", "xray_equal"),
    ("ours_0", "xray_views"),
    ("ours_8", "xray_views"),
    ("ours_0", "fusebot_equal"),
    ("fusebot_posterior", "fusebot_equal"),
    ("ours_plain", "fusebot_posterior"),
    ("ours_0", "ours_plain"),
    ("ours_8", "ours_0"),
    (OTHERS_KNOWN, "ours_0"),
    (KNOWN, "ours_0"),
)
TABLE_1, TABLE_2, TABLE_3 = (f"[Boroushaki2023] Table {n}" for n in (1, 2, 3))
DIFFERS = "real soft objects, human-built piles, networks for masks and grasps"


BOUNDS: Mapping[str, Callable[[SimulatedPileRobot], Belief]] = {KNOWN: TruePlace, OTHERS_KNOWN: TrueOthers}


def run_arm(arm: Arm, scene: PileScene, tags: TaggedItems, seed: int) -> SearchResult:
    """Search a pile in one way, with the tags that are `dealt`."""
    task = SearchTask(scene, tags, seed)
    robot, target = task.robot(), tags.target_size
    if arm.way in BOUNDS:
        method = replace(search_method("ours", target), name=arm.way, belief=BOUNDS[arm.way](robot))
    else:
        method = search_method(arm.way, target, seed)
    return SearchRun(task, method, robot).run()


def dealt(arm: Arm, scene: PileScene, seed: int) -> TaggedItems:
    """Deal the tags of an arm.

    Raises:
        PileError: If there are no items for them where they should be.
    """
    count = arm.tags + round(arm.share * (len(scene.items) - 1))
    return tagged_items_of(scene, arm.placement, count, seed, only_soft=arm.only_soft)


def result_or_why(arm: Arm, scene: PileScene, seed: int) -> SearchResult | str:
    """Search a pile in one way; a word on why not where its tags or its physics cannot be, and only there.

    A search that the simulation broke off says nothing about the method.
    """
    try:
        tags = dealt(arm, scene, seed)
    except PileError as cannot:
        return cannot.kind
    result = run_arm(arm, scene, tags, seed)
    return result.outcome if result.outcome == ARM_STOPPED else result


def searches_trial(cell: Cell, seed: int, rng: np.random.Generator) -> Mapping[str, MetricValue]:  # noqa: ARG001
    """Search one pile by every method."""
    return row_of(str(cell["family"]), seed, EVERY_ARM, (*PAIRS, *GATE_PAIRS))


def row_of(
    family: str,
    seed: int,
    arms: Mapping[str, Arm],
    pairs: Sequence[tuple[str, str]],
    target_class: str = HIDDEN,
) -> dict[str, MetricValue]:
    """Search one pile in several ways, and compare them; None for a way whose tags or physics cannot be."""
    scene = pile_scene(family, seed, target_class)
    row: dict[str, MetricValue] = {"scene": scene.fingerprint}
    actions: dict[str, float | None] = {}
    for name, arm in arms.items():
        result = result_or_why(arm, scene, seed)
        if isinstance(result, str):
            row |= _nothing(name, result)
            actions[name] = None
            continue
        row |= _judged(name, result)
        actions[name] = float(result.actions) if result.found else LOST
    for one, other in pairs:
        a, b = actions[one], actions[other]
        row[_difference(one, other)] = None if a is None or b is None else a - b
    return row


def metrics_of(arms: Iterable[str], pairs: Iterable[tuple[str, str]]) -> tuple[Metric, ...]:
    """What `row_of` measures."""
    return (
        Metric("scene", (), "text"),
        *(metric for arm in arms for metric in _metrics_of(arm)),
        *(
            Metric(_difference(one, other), ("mean",), "float", f"actions: {one} less {other}", "", 1.0, 2)
            for one, other in pairs
        ),
    )


def _difference(one: str, other: str) -> str:
    return f"less_{one}_{other}"


def _judged(arm: str, result: SearchResult) -> dict[str, MetricValue]:
    removals = [step for step in result.steps if not step.on_target]
    return {
        f"found_{arm}": result.found,
        f"ended_{arm}": result.outcome,
        f"actions_{arm}": [float(result.actions)] if result.found else [],
        f"all_{arm}": float(result.actions) if result.found else LOST,
        f"time_s_{arm}": [result.elapsed_s] if result.found else [],
        f"grasps_{arm}": [float(step.attempt.success) for step in result.steps],
        f"said_{arm}": [step.chance for step in result.steps],
        f"removed_{arm}": float(sum(step.attempt.success for step in removals)),
        f"located_{arm}": float(result.tags_located),
    }


def _nothing(arm: str, why: str) -> dict[str, MetricValue]:
    names = ("found", "actions", "all", "time_s", "grasps", "said", "removed", "located")
    nothing: dict[str, MetricValue] = {f"{name}_{arm}": None for name in names}
    return {**nothing, f"ended_{arm}": why}


def _metrics_of(arm: str) -> tuple[Metric, ...]:
    quantiles = ("p10", "median", "p90")
    return (
        Metric(f"found_{arm}", (SHARE,), "bool", f"found, {arm}", "%", 100.0),
        Metric(f"ended_{arm}", (), "text"),
        Metric(f"actions_{arm}", quantiles, "samples", f"actions of searches that found it, {arm}"),
        Metric(f"all_{arm}", ("mean",), "float", f"actions, 16 where it was not found, {arm}", "", 1.0, 2),
        Metric(f"time_s_{arm}", quantiles, "samples", f"time of the arm where it was found, {arm}", "s", 1.0, 0),
        Metric(f"grasps_{arm}", (SHARE,), "samples", f"grasps that held, {arm}", "%", 100.0, 0),
        Metric(f"said_{arm}", ("mean",), "samples", f"what was promised of them, {arm}", "%", 100.0, 0),
        Metric(f"removed_{arm}", ("mean",), "float", f"things taken off, {arm}", "", 1.0, 1),
        Metric(f"located_{arm}", ("mean",), "float", f"tags located at the start, {arm}"),
    )


def paper_values(arm: str, median: float, p90: float, source: str, metric: str = "actions") -> list[PaperValue]:
    """Median and 90 % quantile that a paper prints for an arm."""
    name = f"{metric}_{arm}"
    return [PaperValue(name, "median", median, source, DIFFERS), PaperValue(name, "p90", p90, source, DIFFERS)]


SEARCHES = Study(
    name="searches",
    title="Searching piles for a hidden thing",
    kind="simulated",
    factors={"family": FAMILIES},
    seeds=range(1000, 1034),
    tuning_seeds=range(TUNED_BELOW),
    trial=searches_trial,
    metrics=metrics_of(EVERY_ARM, (*PAIRS, *GATE_PAIRS)),
    paper=(
        *paper_values("fusebot_8", 3.0, 6.0, TABLE_1),
        *paper_values("fusebot_own", 2.0, 5.0, TABLE_1),
        *paper_values("xray", 5.0, 11.0, TABLE_1),
        *paper_values("naive", 4.0, 6.9, TABLE_3),
        *paper_values("fusebot_8", 62.0, 132.0, TABLE_2, "time_s"),
        *paper_values("xray", 142.0, 237.0, TABLE_2, "time_s"),
        *(
            PaperValue(f"found_{arm}", SHARE, share, TABLE_1, DIFFERS)
            for arm, share in (("fusebot_8", 0.95), ("fusebot_own", 0.95), ("xray", 0.84))
        ),
    ),
    note=(
        "Targets that no view of the scan sees. Grasps are executed in MuJoCo, cloth is pinched by a stated surrogate; "
        "masks come from depth, grasps from the antipodal score. fusebot, xray, naive, largest and random have the "
        "views of the paper as we read it (naive: above its voxel), its local update and no memory of failures where "
        "they choose an object; all others look again at all that the view shows and remember failures. known is told "
        "where the target is, others_known where all other things are: bounds. 0 and 8 are tags on distractors, "
        "quarter is a tag on one of four, own is a tag on the target. Constants of policies and grasps were chosen on "
        f"seeds below {TUNED_BELOW}."
    ),
)
