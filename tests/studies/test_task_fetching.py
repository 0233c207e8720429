"""Several parts in one room: each one that the robot knows of is an obstacle on the way to the others."""

import numpy as np
import pytest

from planners.fetch import FetchStep
from planners.worth_driving import PLACED_M, is_placed
from rfcompass.geometry import Pose2
from rfcompass.localization import ConsistencyLocalizer, PosteriorLocalizer
from rfcompass.recordings import PartDatabase
from rfcompass.robots import YouBot
from rfcompass.simulation import WheelSlip
from rfcompass.studies.fetch_modes import Mode, fetch_mode
from rfcompass.studies.fetching import FetchTask
from rfcompass.studies.task_fetching import SURVEY_LOOKS, SimulatedTask
from rfcompass.types import PartEstimate

ROBOT = YouBot()
LEGS = PartDatabase(":memory:").assembly("LACK")


def a_room(localizer=None, silent=(), **options):
    """Distances with little noise, no radio: odometry is the map."""
    options = {"sigma": 0.005, "slip": WheelSlip(position_m=0.0, heading_rad=0.0), **options}
    task = FetchTask(
        robot=ROBOT, part=LEGS[0], tags=4, localizer=localizer or PosteriorLocalizer(), seed=0, **options
    )  # fmt: skip
    return SimulatedTask(task, LEGS[1:], silent)


@pytest.fixture(scope="module")
def surveyed():
    room = a_room()
    return room, room.survey(LEGS)


def test_a_survey_finds_where_the_parts_lie(surveyed):
    room, found = surveyed
    assert found
    truth = room.true_poses()
    for name, seen in found.items():
        assert np.linalg.norm(seen.centre_m - truth[name].translation_m) <= 3 * PLACED_M


def test_what_was_found_is_an_obstacle_on_the_way_to_the_others_but_not_to_itself(surveyed):
    room, found = surveyed
    for leg in LEGS:
        names = {body.name for body in room.send_for(leg).around.world.bodies}
        assert names == found.keys() - {leg.part_id}


def test_a_silent_part_is_not_found():
    assert LEGS[2].part_id not in a_room(silent=[LEGS[2].part_id]).survey(LEGS)


def test_comparisons_from_one_stop_put_no_part_on_the_map():
    room = a_room(ConsistencyLocalizer(), sigma=0.05)
    assert room.survey(LEGS[:1]) == {}
    assert not room.send_for(LEGS[0]).around.world.bodies


def test_a_part_that_was_not_grasped_stays_on_the_map_where_it_was_last_seen():
    room = a_room()
    fetch = room.send_for(LEGS[0])
    last = list(fetch.navigate())[-1]
    assert isinstance(last.step, FetchStep)
    room.left(LEGS[0], last.step)
    (body,) = room.send_for(LEGS[1]).around.world.bodies
    assert body.name == LEGS[0].part_id
    assert np.linalg.norm(body.T_parent_body[:2, 3] - room.true_poses()[LEGS[0].part_id].translation_m) <= PLACED_M
    room.left(LEGS[1], None)
    assert len(room.send_for(LEGS[2]).around.world.bodies) == 1


@pytest.mark.slow
def test_by_radio_a_survey_looks_from_several_places_and_the_map_has_furniture():
    how = fetch_mode(Mode.BEST)
    room = a_room(how.localizer, radio=how.radio, meter=how.meter, near=how.near, map_pose=how.map_pose)
    found = room.survey(LEGS)
    assert len(room.send_for(LEGS[0]).device.stops) <= len(LEGS) * (1 + SURVEY_LOOKS)
    bodies = {body.name for body in room.send_for(LEGS[0]).around.world.bodies}
    assert found.keys() - {LEGS[0].part_id} < bodies


def estimate(sd_m, samples):
    covariance = np.diag([sd_m**2, sd_m**2, 0.1])
    return PartEstimate("leg", np.array([1.0, 0.0]), 0.0, "told", 1, covariance=covariance, samples=samples)


def test_a_part_is_placed_by_a_posterior_that_is_narrow_enough():
    samples = np.zeros((5, 3))
    assert is_placed(estimate(0.9 * PLACED_M, samples))
    assert not is_placed(estimate(1.1 * PLACED_M, samples))
    assert not is_placed(estimate(0.01, np.zeros((0, 3))))
    assert not is_placed(PartEstimate("leg", np.zeros(2), 0.0, "told", 1, samples=samples))


def test_delivered_parts_are_obstacles_where_they_were_put():
    room = a_room()
    fetch = room.send_for(LEGS[0])
    last = list(fetch.steps())[-1]
    trials = [event for event in fetch.pick_up(last) if hasattr(event, "outcome")]
    put = room.deliver(LEGS[0], trials[-1].plan, Pose2(0.4, 0.0, np.pi / 2))
    (body,) = room.send_for(LEGS[1]).around.world.bodies
    assert np.allclose(body.T_parent_body[:2, 3], put.put.T_odom_part.translation_m, atol=1e-9)
