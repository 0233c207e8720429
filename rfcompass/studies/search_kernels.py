"""Study: the deformable kernel against the spherical one, in whole searches [Boroushaki2023], Table 4.

One trial is one pile, searched twice: with the paper's kernel of a tag on something soft, and with the ball that it
takes for something rigid. Nothing but soft things is tagged, and all else is equal, so that only the kernel differs.
"""

from collections.abc import Mapping

import numpy as np

from rfcompass.evaluation.records import MetricValue
from rfcompass.studies.metric import SHARE, Metric
from rfcompass.studies.pile_scenes import pile_scene
from rfcompass.studies.searches import DIFFERS, LOST, TAGS, TUNED_BELOW, Arm, paper_values, result_or_why
from rfcompass.studies.study import Cell, PaperValue, Study
from rfcompass.types import SearchResult

FAMILIES = ("soft_1p10",)
KERNELS: Mapping[str, Arm] = {
    "deformable": Arm("fusebot", TAGS, only_soft=True),
    "spherical": Arm("spherical", TAGS, only_soft=True),
}
TABLE_4 = "[Boroushaki2023] Table 4"
_COUNTS = ("held", "actions", "all_held", "all", "located")


def kernels_trial(cell: Cell, seed: int, rng: np.random.Generator) -> Mapping[str, MetricValue]:  # noqa: ARG001
    """Search one pile with each kernel; None for one with which the physics cannot be, or without soft things."""
    scene = pile_scene(str(cell["family"]), seed)
    row: dict[str, MetricValue] = {"scene": scene.fingerprint}
    for name, arm in KERNELS.items():
        result = result_or_why(arm, scene, seed)
        if isinstance(result, str):
            row |= {f"{count}_{name}": None for count in ("found", *_COUNTS)} | {f"ended_{name}": result}
        else:
            row |= judged(name, result)
    for metric in ("all_held", "all"):
        one, other = (row[f"{metric}_{name}"] for name in KERNELS)
        both = isinstance(one, float) and isinstance(other, float)
        row[f"less_{metric}"] = float(one) - float(other) if both else None  # type: ignore[arg-type]
    return row


def judged(kernel: str, result: SearchResult) -> dict[str, MetricValue]:
    """What is counted of one search: actions with failed grasps, and held ones, without them, as the paper counts."""
    held = float(result.actions - result.failed_grasps)
    return {
        f"found_{kernel}": result.found,
        f"ended_{kernel}": result.outcome,
        f"held_{kernel}": [held] if result.found else [],
        f"actions_{kernel}": [float(result.actions)] if result.found else [],
        f"all_held_{kernel}": held if result.found else LOST,
        f"all_{kernel}": float(result.actions) if result.found else LOST,
        f"located_{kernel}": float(result.tags_located),
    }


def _metrics_of(kernel: str) -> tuple[Metric, ...]:
    quantiles = ("p10", "median", "p90")
    return (
        Metric(f"found_{kernel}", (SHARE,), "bool", f"found, {kernel}", "%", 100.0),
        Metric(f"ended_{kernel}", (), "text"),
        Metric(f"held_{kernel}", quantiles, "samples", f"actions where found, failed grasps left out, {kernel}"),
        Metric(f"actions_{kernel}", quantiles, "samples", f"actions where found, {kernel}"),
        Metric(f"all_held_{kernel}", ("mean",), "float", f"the first, 16 where not found, {kernel}", "", 1.0, 2),
        Metric(f"all_{kernel}", ("mean",), "float", f"the second, 16 where not found, {kernel}", "", 1.0, 2),
        Metric(f"located_{kernel}", ("mean",), "float", f"tags located at the start, {kernel}", "", 1.0, 1),
    )


SEARCH_KERNELS = Study(
    name="search-kernels",
    title="Searching piles of soft things with a kernel for soft or for rigid ones",
    kind="simulated",
    factors={"family": FAMILIES},
    seeds=range(1000, 1100),
    tuning_seeds=range(TUNED_BELOW),
    trial=kernels_trial,
    metrics=(
        Metric("scene", (), "text"),
        *(metric for kernel in KERNELS for metric in _metrics_of(kernel)),
        Metric("less_all_held", ("mean",), "float", "failed grasps left out: deformable less spherical", "", 1.0, 2),
        Metric("less_all", ("mean",), "float", "actions: deformable less spherical", "", 1.0, 2),
    ),
    paper=(
        *paper_values("deformable", 3.0, 4.0, TABLE_4, "held"),
        *paper_values("spherical", 4.0, 6.2, TABLE_4, "held"),
        *(PaperValue(f"found_{kernel}", SHARE, 1.0, TABLE_4, DIFFERS) for kernel in KERNELS),
    ),
    note=(
        "Targets that no view of the scan sees, in one pile of ten other things, about two thirds of them soft: covers "
        "and cushions, both stated surrogates. Up to 8 tags, on soft things alone, often fewer. Both searches "
        "are the paper's (`fusebot`), and only the kernel differs. The paper had 20 trials and left failed grasps out."
    ),
)
