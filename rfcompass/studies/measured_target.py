"""Study: one tag among reference tags at known places, all from measured sweeps.

References are drawn from other sweeps of the same rail than the target's, so that no two of them shared a scan. What is
compared are the places that `survey` finds for each tag in its own sweep: m is the distance between two of them.
"""

from collections.abc import Mapping, Sequence
from functools import cache
from typing import NamedTuple

import numpy as np

from rfcompass.arrays import FloatArray
from rfcompass.errors import NoAnswer
from rfcompass.evaluation.records import MetricValue
from rfcompass.geometry.pose2 import Pose2
from rfcompass.interfaces import Localizer
from rfcompass.localization import ConsistencyLocalizer, PosteriorLocalizer, survey
from rfcompass.recordings import open_trace
from rfcompass.studies.measured import MAX_SWEEPS, data_folder, sweeps, tape_positions
from rfcompass.studies.metric import SHARE, Metric
from rfcompass.studies.study import Cell, PaperValue, Study
from rfcompass.types.observation import Observation
from rfcompass.types.proximity import ProximityMatrix
from rfcompass.types.tags import TagLayout, TagPositions

APART_M = 0.03  # a reference nearer to the target than this would give it away
REGION = 0.9
METHODS = ("posterior", "comparisons", "consistency", "nearest three")
FAMILIES = ("D1train", "D1test", "D2", "D4")
PILOT = "our own pilot study on all public sweeps of the set, unpublished"


class Surveyed(NamedTuple):
    """A tag: where the tape says it is, and where its own sweep puts it, in the plane of the rail [m], (2,) each."""

    tape_m: FloatArray
    found_m: FloatArray


def target_trial(cell: Cell, seed: int, rng: np.random.Generator) -> Mapping[str, MetricValue]:
    """Locate every tag of one sweep among references from the other sweeps."""
    family, count = str(cell["family"]), int(float(cell["references"] or 0))
    names = sweeps(family)
    pool = [tag for name in names if name != names[seed] for tag in surveyed(name)]
    errors_m, held = [], []
    for target in surveyed(names[seed]):
        far = [tag for tag in pool if np.linalg.norm(tag.tape_m - target.tape_m) >= APART_M]
        chosen = [far[i] for i in rng.permutation(len(far))[:count]]
        answer = _answer(str(cell["method"]), target, chosen)
        if answer is not None:
            errors_m.append(float(np.linalg.norm(answer.place_m - target.tape_m)))
            held += [] if answer.held is None else [float(answer.held)]
    return {"error_m": errors_m, "held": held, "unanswered": float(len(surveyed(names[seed])) - len(errors_m))}


class Answer(NamedTuple):
    """Where a method puts the target [m], shape (2,), and whether its region holds the tape's place."""

    place_m: FloatArray
    held: bool | None


@cache
def surveyed(name: str) -> tuple[Surveyed, ...]:
    """Tags of one sweep that have a tape-measured place, located with the defaults."""
    truth = tape_positions(name)
    fixes = survey(open_trace(data_folder() / "traces" / name).scan())
    return tuple(Surveyed(truth[fix.epc][:2], fix.point_m[:2]) for fix in fixes if fix.epc in truth)


def _answer(method: str, target: Surveyed, references: Sequence[Surveyed]) -> Answer | None:
    tape_m = np.array([tag.tape_m for tag in references])
    m = np.linalg.norm(np.array([tag.found_m for tag in references]) - target.found_m, axis=1)
    if method == "nearest three":
        return Answer(tape_m[np.argsort(m, kind="stable")[:3]].mean(axis=0), None)
    observation = _observation(references, tape_m, m)
    bounds_m = np.column_stack([tape_m.min(axis=0) - 0.5, tape_m.max(axis=0) + 0.5])
    try:
        if method != "posterior":
            return Answer(_localizer(method, bounds_m).estimate([observation]).centre_m, None)
        posterior = PosteriorLocalizer(bounds_m=bounds_m).infer([observation]).posterior
    except NoAnswer:
        return None
    return Answer(posterior.mean_m, posterior.level(Pose2(target.tape_m[0], target.tape_m[1], 0.0)) <= REGION)


def _localizer(method: str, bounds_m: FloatArray) -> Localizer:
    if method == "consistency":
        return ConsistencyLocalizer(bounds_m=bounds_m)
    return PosteriorLocalizer(use="comparisons", bounds_m=bounds_m)


def _observation(references: Sequence[Surveyed], tape_m: FloatArray, m: FloatArray) -> Observation:
    """The references are the robot's tags, in the frame of the rail; the target is a part of one tag."""
    found_m = np.array([tag.found_m for tag in references])
    anchor_m = np.linalg.norm(found_m[:, None] - found_m[None], axis=2)
    np.fill_diagonal(anchor_m, np.nan)
    anchors = TagPositions("base", tuple(f"r{i}" for i in range(len(m))), np.column_stack([tape_m, np.zeros(len(m))]))
    part = TagLayout("tag", ("target",), ("part",), np.zeros((1, 3)), np.array([[0.0, 0.0, 1.0]]), ("part",))
    matrix = ProximityMatrix(part.epcs, anchors.epcs, m[None], anchor_m, "surveyed_distance")
    return Observation(0, anchors, part, np.zeros(1), proximity=matrix)


MEASURED_TARGET = Study(
    name="measured-target",
    title="One tag among reference tags, from measured sweeps",
    kind="measured",
    factors={"family": FAMILIES, "references": (8, 16), "method": METHODS},
    seeds=range(MAX_SWEEPS),
    applies=lambda cell, seed: seed < len(sweeps(str(cell["family"]))),
    trial=target_trial,
    metrics=(
        Metric("error_m", ("median", "p90"), "samples", "error in the plane", "cm", 100.0),
        Metric("held", (SHARE,), "samples", "90 % region holds the tape's place", "%", 100.0),
        Metric("unanswered", ("mean",), "float", "targets without an answer, of a sweep", "", 1.0, 2),
    ),
    paper=(
        PaperValue(
            "error_m", "median", 0.066, PILOT, "25 references, proximity of five sub-apertures",
            {"method": "nearest three", "family": "D1test", "references": 16},
        ),
    ),
    note="References may be the same physical tag in another row, which favours `nearest three`.",
)  # fmt: skip
