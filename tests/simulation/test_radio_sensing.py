"""A scan by radio: what the carrier believes, who is heard, and that a trace gives the same scan."""

import dataclasses

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rfcompass.errors import DuplicateEpc, InputError
from rfcompass.geometry import Pose2
from rfcompass.recordings import PartDatabase, open_trace, write_trace
from rfcompass.robots import YouBot
from rfcompass.simulation import (
    DUAL_DIPOLE,
    NOISE_R420,
    RIG_PAPER,
    SQUIGGLE,
    Carrier,
    PlacedTags,
    PlaneRoom,
    RadioSensor,
    Scatterers,
    SimulatedRobot,
    load_recipe,
)
from rfcompass.studies.fetch_trace import fetch_trace

ROBOT = YouBot()
LEG = PartDatabase(":memory:").part("table_leg_3")
LAYOUT = LEG.layout(2)
ROOM = PlaneRoom(T_room_base=Pose2(2.0, 2.5, 0.4), T_room_part=Pose2(2.5, 2.6, 1.0))
SHORT_L = Carrier(legs_m=np.array([[[2.0, 1.0, 0.3], [1.0, 1.0, 0.3]], [[1.0, 1.0, 0.3], [1.0, 2.0, 0.3]]]))
R420_BISTATIC = dataclasses.replace(RIG_PAPER, noise=NOISE_R420)


def placed(layout, model, rng):
    return PlacedTags.draw(layout.epcs, layout.points_m, layout.dipoles, model, rng)


def a_robot(seed=0, rig=RIG_PAPER, **more):
    rng = np.random.default_rng(seed)
    sensor = RadioSensor(
        scene=load_recipe("free_space").draw(rng), robot_tags=placed(ROBOT.layout, SQUIGGLE, rng),
        part_tags=placed(LAYOUT, SQUIGGLE, rng), rig=rig, carrier=SHORT_L, **more,
    )  # fmt: skip
    return SimulatedRobot(ROBOT, LEG, LAYOUT, ROOM, rng, ROBOT.posture("scan").joints, sensor)


@given(st.integers(0, 1000))
def test_the_first_leg_of_a_carrier_without_errors_is_where_it_believes(seed):
    sure = dataclasses.replace(SHORT_L, walk_m=0.0)
    first = len(sure.track()) // 2
    driven = sure.driven(np.random.default_rng(seed)).positions_m
    assert np.allclose(driven[:first], sure.track().positions_m[:first])
    assert not np.allclose(driven[first:], sure.track().positions_m[first:])


@pytest.mark.parametrize("bad", [{"walk_m": -0.1}, {"leg_offset_m": np.nan}, {"leg_turn_rad": np.inf}])
def test_errors_of_a_carrier_that_cannot_be_are_refused(bad):
    with pytest.raises(InputError):
        dataclasses.replace(SHORT_L, **bad)


def test_a_scan_hears_robot_and_part_and_leaves_strays_out():
    rng = np.random.default_rng(5)
    stray = PlacedTags.draw(("ff01",), np.array([[2.0, 2.0, 0.1]]), np.array([[0.0, 0.0, 1.0]]), SQUIGGLE, rng)
    robot = a_robot(other_tags=(stray,))
    scan = robot.scan().scan
    assert set(scan.epcs) == {*ROBOT.layout.epcs, *LAYOUT.epcs}
    assert "ff01" in {read.epc for read in robot.stops[0].inventory.reads()}


def test_a_scan_names_where_the_carrier_believes_it_was_never_where_it_was():
    trace = next(iter(a_robot().scan().scan.traces.values()))
    nominal = {tuple(position) for position in SHORT_L.track().positions_m.tolist()}
    assert {tuple(position) for position in trace.antenna_positions_m.tolist()} <= nominal


def test_the_same_seed_hears_the_same_to_the_last_bit():
    one, other = a_robot(7).scan().scan, a_robot(7).scan().scan
    for epc in one.epcs:
        assert one.trace(epc).channel.tobytes() == other.trace(epc).channel.tobytes()


@pytest.mark.parametrize("rig", [RIG_PAPER, R420_BISTATIC], ids=["iq", "phase modulo pi"])
def test_a_scan_read_back_from_its_trace_is_the_scan_to_the_last_bit(rig, tmp_path):
    robot = a_robot(3, rig)
    stops = [robot.scan()]
    robot.move_base(Pose2(0.3, 0.1, 0.2))
    stops.append(robot.scan())
    write_trace(fetch_trace(ROBOT, robot.stops), tmp_path / "trace")
    for heard, read in zip(stops, open_trace(tmp_path / "trace").observations(ROBOT, LEG), strict=True):
        assert heard.scan.epcs == read.scan.epcs
        for epc in heard.scan.epcs:
            one, other = heard.scan.trace(epc), read.scan.trace(epc)
            for name in ("antenna_positions_m", "tx_positions_m", "frequencies_hz", "channel", "read_counts"):
                assert getattr(one, name).tobytes() == getattr(other, name).tobytes(), (epc, name)
            assert one.phase_modulus_rad == other.phase_modulus_rad


def test_tags_of_different_types_are_heard_in_one_room_as_they_would_be_alone():
    rng = np.random.default_rng(0)
    stray = placed(dataclasses.replace(LAYOUT, epcs=("aa", "bb")), DUAL_DIPOLE, rng).moved(
        np.array([[2.0, 2.0, 0.1], [2.2, 2.0, 0.1]]), np.tile([0.0, 0.0, 1.0], (2, 1))
    )
    heard = a_robot(other_tags=(stray,))
    heard.scan()
    assert {"aa", "bb", *LAYOUT.epcs} <= {read.epc for read in heard.stops[0].inventory.reads()}


def test_one_epc_on_two_tags_is_refused():
    rng = np.random.default_rng(0)
    twin = placed(LAYOUT, SQUIGGLE, rng).moved(LAYOUT.points_m + np.array([2.0, 2.0, 0.1]), LAYOUT.dipoles)
    with pytest.raises(DuplicateEpc):
        a_robot(other_tags=(twin,)).scan()


def test_a_dual_antenna_is_read_through_both_feeds_at_every_place():
    dual = dataclasses.replace(SHORT_L, ports=(1, 2))
    track = dual.track()
    assert track.ports.tolist() == [1, 2] * len(SHORT_L.track())
    assert np.array_equal(track.positions_m[::2], track.positions_m[1::2])
    driven = dual.driven(np.random.default_rng(0))
    assert np.array_equal(driven.positions_m[::2], driven.positions_m[1::2])


def test_a_metal_robot_changes_what_is_heard():
    metal, air = a_robot(1), a_robot(1, body=Scatterers.none())
    epc = LAYOUT.epcs[0]
    assert not np.allclose(metal.scan().scan.trace(epc).channel, air.scan().scan.trace(epc).channel)
