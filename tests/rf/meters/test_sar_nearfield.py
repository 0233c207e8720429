"""m is the distance in space, wherever the path lets it be."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rfcompass.rf.meters.sar_nearfield import SarNearfieldMeter
from rfcompass.types.reads import Scan
from rfcompass.types.volumes import SearchVolume

TAGS_M = np.array([[1.3, 1.5, 0.05], [1.5, 1.45, 0.2], [1.1, 1.7, 0.06], [1.35, 1.2, 0.12]])
ONE_HZ = np.array([920.0e6])


def corner_m(step_m=0.04, length_m=2.0, height_m=0.3):
    s = np.arange(0.0, length_m, step_m)
    along = np.column_stack([s, np.zeros(s.size), np.full(s.size, height_m)])
    return np.concatenate([along[::-1], along[1:][:, [1, 0, 2]]])


def distances_m(points_m):
    return np.linalg.norm(points_m[:, None] - points_m[None], axis=2)


def with_heights(scan, points_m=TAGS_M):
    return replace(scan, heights_m={f"e{k}": float(point_m[2]) for k, point_m in enumerate(points_m)})


def rigs(path_m):
    """No transmitter of its own, one that stands still, two that take turns, one that moves along."""
    turns = np.arange(len(path_m))[:, None] % 2
    return [
        None,
        np.tile([4.0, 3.0, 2.0], (len(path_m), 1)),
        np.where(turns, [4.0, 3.0, 2.0], [0.5, 4.0, 2.0]),
        path_m + np.array([0.1, 0.1, 0.05]),
    ]


def measured(scan, **parameters):
    return SarNearfieldMeter(**parameters).measure(scan).anchor_m


def check_exact(m, points_m=TAGS_M, atol=1e-3):
    """A millimetre: the models agree, so that only the choice of the peak could go wrong."""
    off = ~np.eye(len(points_m), dtype=bool)
    np.testing.assert_allclose(m[off], distances_m(points_m)[off], atol=atol)


@pytest.mark.parametrize("rig", range(4))
def test_with_two_legs_and_known_heights_m_is_the_distance_in_space(make_scan, rig):
    path_m = corner_m()
    scan = make_scan(TAGS_M, path_m, tx_m=rigs(path_m)[rig], frequencies_hz=ONE_HZ)
    check_exact(measured(with_heights(scan)))


def test_signs_that_are_not_known_do_no_harm_if_steps_are_short(make_scan):
    path_m = corner_m(step_m=0.02)
    check_exact(measured(with_heights(make_scan(TAGS_M, path_m, half_turns=True))))


def test_in_a_scan_of_two_dimensions_tags_are_as_high_as_the_antennas(make_scan):
    flat_m = TAGS_M * [1.0, 1.0, 0.0] + [0.0, 0.0, 0.3]
    scan = make_scan(flat_m, corner_m(), frequencies_hz=ONE_HZ)
    check_exact(measured(replace(scan, dimensions=2)), flat_m)


def test_without_heights_a_path_that_looks_down_finds_them(make_scan):
    """A square of 0.8 m, 0.6 m above the tags, as a wrist drives it; three channels, two fixed transmitters."""
    s = np.arange(-0.4, 0.4, 0.04)
    edge = np.full(s.size, 0.4)
    path_m = np.concatenate([np.column_stack(xy) for xy in ((s, -edge), (edge, s), (-s, edge), (-edge, -s))])
    path_m = np.column_stack([path_m, np.full(len(path_m), 0.6)])
    tags_m = np.array([[0.1, 0.05, 0.02], [-0.15, 0.1, 0.1], [0.0, -0.2, 0.05]])
    scan = make_scan(tags_m, path_m, tx_m=rigs(path_m)[2])
    check_exact(measured(scan, reach_m=0.8), tags_m)


@settings(max_examples=10)
@given(x=st.floats(0.2, 0.8), dx=st.floats(0.05, 0.3), y=st.floats(0.5, 1.0), dy=st.floats(-0.2, 0.2))
def test_a_straight_path_takes_all_tags_to_be_on_one_side(make_scan, line, x, dx, y, dy):
    points_m = np.array([[x, y, 0.0], [x + dx, y + dy, 0.0]])
    mirrored_m = points_m * [[1.0, 1.0, 1.0], [1.0, -1.0, 1.0]]
    one, other = (measured(make_scan(places, line(2.0, 51)))[0, 1] for places in (points_m, mirrored_m))
    assert one == pytest.approx(np.hypot(dx, dy), abs=1e-3)
    assert other == pytest.approx(one, abs=1e-6)


def test_a_second_leg_that_is_not_where_the_robot_believes_shifts_all_tags_alike(make_scan):
    """Tags move with the leg, most of 3 cm; at a range r > 1 m that turns and stretches what is between them by 3 %."""
    path_m, meter = corner_m(), SarNearfieldMeter()
    scan = make_scan(TAGS_M, path_m, tx_m=rigs(path_m)[1], frequencies_hz=ONE_HZ)
    believed_m = path_m + np.where(np.arange(len(path_m)) >= 50, 0.03, 0.0)[:, None] * [0.0, 1.0, 0.0]
    moved = {epc: replace(trace, antenna_positions_m=believed_m) for epc, trace in scan.traces.items()}
    shift_m = meter.place(moved["e0"], TAGS_M[0, 2]) - TAGS_M[0]
    assert 0.015 < np.linalg.norm(shift_m) < 0.03
    off = ~np.eye(len(TAGS_M), dtype=bool)
    np.testing.assert_allclose(measured(with_heights(Scan(moved)))[off], distances_m(TAGS_M)[off], rtol=0.03)


def test_a_given_volume_decides_between_mirror_images(make_scan, line):
    points_m = np.array([[0.3, -0.6, 0.0], [0.6, -0.7, 0.0], [0.5, 0.9, 0.0]])
    below = SearchVolume([-0.5, -1.5, 0.0], [1.5, -0.1, 0.0])
    meter = SarNearfieldMeter(volume=below)
    scan = make_scan(points_m, line())
    np.testing.assert_allclose(meter.place(scan.trace("e0")), points_m[0], atol=1e-3)
    np.testing.assert_allclose(meter.place(scan.trace("e2")), points_m[2] * [1, -1, 1], atol=1e-3)


def test_a_tag_that_was_heard_too_rarely_has_no_place(make_scan):
    path_m = corner_m()
    heard = np.arange(len(path_m))[:, None] < 8  # one channel at eight positions: seven differences
    scan = make_scan(TAGS_M, path_m, frequencies_hz=ONE_HZ)
    few = make_scan(TAGS_M[:1], path_m, frequencies_hz=ONE_HZ, heard=heard).trace("e0")
    m = measured(with_heights(Scan({**scan.traces, "e0": few})))
    assert np.isnan(m[0]).all()
    assert np.isfinite(m[1:, 1:][~np.eye(3, dtype=bool)]).all()


def test_a_tag_missing_from_one_leg_is_placed_by_the_other(make_scan):
    path_m = corner_m()
    heard = np.arange(len(path_m))[:, None] < 50
    scan = with_heights(make_scan(TAGS_M, path_m, frequencies_hz=ONE_HZ, heard=heard))
    volume = SearchVolume([0.0, 0.2, 0.0], [2.0, 2.5, 0.5])  # one leg alone has a mirror image
    check_exact(measured(scan, volume=volume))
