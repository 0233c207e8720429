"""A plan without its records, or with one that says no, is not sound."""

import pickle
from dataclasses import replace

import numpy as np
import pytest

from rfcompass.errors import ShapeError
from rfcompass.types import Clearance, Configuration, Failure, GraspCandidate, GraspFailure, GraspPlan, Solution
from rfcompass.types.motions import APPROACH, CLOSE, LIFT, REACH, StageCertificate, TimedPath

NAMES = ("a", "b")
Q0 = np.zeros(2)


def timed(stage):
    return TimedPath(stage, NAMES, [0.0, 1.0], [[0, 0], [1, 1]])


def certificate(stage, **changed):
    return replace(StageCertificate(stage, 10, 5, True, Clearance("a", "b", 0.01), 0.008), **changed)


def sound():
    stages = (REACH, APPROACH, CLOSE, LIFT)
    solution = Solution(Configuration(Q0), "closed_form", 0.0, 0.0, certified_pairs=10)
    return GraspPlan(
        Q0, [Q0, Q0], [Q0, Q0], 0.075, 0.008, 0.9, solution=solution,
        stages=tuple(map(timed, stages)), certificates=tuple(map(certificate, stages)),
    )  # fmt: skip


def test_a_plan_with_all_records_has_no_defects():
    assert sound().defects == ()
    assert sound().duration_s == pytest.approx(4.0)


def without_solution(plan):
    return replace(plan, solution=None)


def not_certified(plan):
    return replace(plan, solution=replace(plan.solution, certified_pairs=None))


def without_a_certificate(plan):
    return replace(plan, certificates=plan.certificates[1:])


def touching(plan):
    return replace(plan, certificates=(certificate(REACH, apart=False), *plan.certificates[1:]))


def never_looked_at(plan):
    return replace(plan, certificates=(certificate(REACH, fcl_checks=0), *plan.certificates[1:]))


def without_a_stage(plan):
    return replace(plan, stages=plan.stages[1:])


@pytest.mark.parametrize(
    "change",
    [without_solution, not_certified, without_a_certificate, touching, never_looked_at, without_a_stage],
)
def test_each_missing_record_is_one_defect(change):
    assert len(change(sound()).defects) == 1


def test_time_goes_forward():
    for times_s in ([0.5, 1.0], [0.0, -1.0], []):
        with pytest.raises(ShapeError):
            TimedPath(REACH, NAMES, times_s, np.zeros((len(times_s), 2)))
    with pytest.raises(ShapeError, match="none of drive"):
        TimedPath("nap", NAMES, [0.0], np.zeros((1, 2)))


def test_a_base_that_is_not_mentioned_stays():
    assert timed(REACH).bases.tolist() == [[0, 0, 0], [0, 0, 0]]


def test_reasons_are_counted_most_frequent_first():
    kinds = ["unreachable", "scene_collision", "unreachable"]
    rows = [GraspCandidate(np.eye(4), 0.05, rejection=Failure(kind, "no")) for kind in kinds]
    rows.append(GraspCandidate(np.eye(4), 0.05, score=0.5))
    failure = GraspFailure("no_grasp", "none", (), tuple(rows))
    assert list(failure.reasons.items()) == [("unreachable", 2), ("scene_collision", 1)]
    assert isinstance(failure, Failure)


def test_plans_and_failures_survive_a_pickle():
    plan = pickle.loads(pickle.dumps(sound()))
    assert plan.defects == ()
    assert not plan.stages[0].joints.flags.writeable
    failure = GraspFailure("no_grasp", "none", (("n", 1.0),), (GraspCandidate(np.eye(4), 0.05, score=0.5),))
    assert pickle.loads(pickle.dumps(failure)).candidates[0].score == 0.5
