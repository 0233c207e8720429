"""A search cannot see truth: a target that is moved unseen changes no question, and records alone give the result."""

import pickle
from dataclasses import dataclass, field, replace
from functools import partial

import pytest
from same_records import differences

pytest.importorskip("mujoco", reason="the extra `piles` is not installed")

from simulation.pile_scenes import RED, at, item, tiny

from planners.pile_search import PileSearch
from rfcompass.errors import ArmStopped, NoAnswer
from rfcompass.interfaces import ExtractionPolicy, PileRobot
from rfcompass.simulation.piles import PileScene, flat_state
from rfcompass.studies.search_bounds import TruePlace
from rfcompass.studies.search_methods import search_method
from rfcompass.studies.searching import SearchRun, SearchTask, tagged_items_of

SEED = 1
IN_ONE, IN_THE_OTHER, IN_SIGHT = (-0.12, 0.03), (0.10, -0.05), (0.0, 0.15)
both_ways = pytest.mark.parametrize("name", ["ours", "fusebot"])


def two_boxes(target_m):
    """Two boxes, solid to every eye, and a small target in one of them; nothing falls before the first grasp."""
    things = {
        1: item(1, size_m=(0.12, 0.07, 0.09)),
        2: item(2, size_m=(0.07, 0.10, 0.08)),
        3: item(3, size_m=(0.04, 0.04, 0.03), rgb=RED),
    }
    places_m = {1: (*IN_ONE, 0.045), 2: (*IN_THE_OTHER, 0.04), 3: (*target_m, 0.03)}
    states = {number: flat_state(thing, at(*places_m[number])) for number, thing in things.items()}
    return PileScene("boxes", SEED, "hidden", tuple(things.values()), states, dict.fromkeys(things, 0), target=3)


def run_of(scene, name, tags=0):
    task = SearchTask(scene, tagged_items_of(scene, "any", tags, SEED), SEED, spacing_m=0.02)
    return SearchRun.of(task, search_method(name, task.tags.target_size, SEED))


@dataclass
class Noting:
    """A policy that notes what it is asked."""

    policy: ExtractionPolicy
    asked: list = field(default_factory=list)

    def choose(self, *question):
        self.asked.append(question)
        return self.policy.choose(*question)


def first_choice(run):
    """What the policy is asked before the arm goes for anything, what it goes for, and what the map was."""
    noting, gone_for = Noting(run.method.policy), []

    def grasp(action):
        gone_for.append(action)
        raise ArmStopped("seen enough", during="grasp")

    run.robot.grasp = grasp
    result = replace(run.search, method=replace(run.method, policy=noting)).run()
    return noting.asked, gone_for, replace(result, steps=())


@both_ways
def test_a_hidden_target_that_is_moved_unseen_changes_neither_question_nor_choice(name):
    one, other = (first_choice(run_of(two_boxes(target_m), name)) for target_m in (IN_ONE, IN_THE_OTHER))
    asked, gone_for, _ = one
    assert asked
    assert len(gone_for) == 1
    assert differences(other, one) == []


def test_who_is_told_the_truth_or_sees_the_target_is_asked_something_else():
    """So the test above can fail."""
    told = []
    for target_m in (IN_ONE, IN_THE_OTHER):
        run = run_of(two_boxes(target_m), "fusebot")
        run.method = replace(run.method, belief=TruePlace(run.robot))
        told.append(first_choice(run))
    assert differences(told[1], told[0])
    hidden, in_sight = (first_choice(run_of(two_boxes(target_m), "fusebot")) for target_m in (IN_ONE, IN_SIGHT))
    assert differences(in_sight, hidden)


@dataclass
class Recorder:
    """Hands questions on to a robot, and keeps what it says as a file could."""

    robot: PileRobot
    said: list = field(default_factory=list)

    @property
    def elapsed_s(self):
        return self.robot.elapsed_s

    def _ask(self, asked, *told):
        try:
            answer = getattr(self.robot, asked)(*told)
        except NoAnswer as why:
            answer = why
        self.said.append(pickle.dumps((asked, told, answer, self.elapsed_s)))
        if isinstance(answer, NoAnswer):
            raise answer
        return answer

    def __getattr__(self, asked):
        if asked not in ("scan", "listen_again", "look", "reaches", "grasp"):
            raise AttributeError(asked)
        return partial(self._ask, asked)


@dataclass
class Player(Recorder):
    """Says it again, without any robot, pile or truth."""

    robot: None = None
    elapsed_s: float = 0.0

    def _ask(self, asked, *told):
        *question, answer, self.elapsed_s = pickle.loads(self.said.pop(0))
        assert differences([asked, told], question) == []
        if isinstance(answer, NoAnswer):
            raise answer
        return answer


@both_ways
def test_a_search_in_the_records_of_another_is_the_same_to_the_last_bit(name):
    run = run_of(tiny(), name, tags=2)
    recorder = Recorder(run.robot)
    result = replace(run.search, robot=recorder).run()
    played = PileSearch(
        robot=Player(said=recorder.said),
        method=run.method,
        target=run.task.tags.target_size,
        sizes=run.task.tags.sizes,
        workspace=run.search.workspace,
        segmenter=run.search.segmenter,
        quality=run.search.quality,
    ).run()
    assert result.actions >= 1
    assert differences(played, result) == []
