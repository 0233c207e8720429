"""The compiled matched filter is the printed sum, and knows nothing that a reader cannot know."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from survey_scenes import FREQUENCIES_HZ, RAIL_M, reads_of, square_m

from rfcompass.errors import ShapeError
from rfcompass.localization import sar_image
from rfcompass.rf import SPEED_OF_LIGHT_M_S, Matching, build_hologram
from rfcompass.types import ReadTrace, SearchVolume

VOLUME = SearchVolume([0.0, 0.4, -0.2], [1.0, 1.2, 0.2])
MATCHINGS = [Matching(coherent=c, amplitude=a) for c in (False, True) for a in (False, True)]


def printed_sum(trace, points_m, matching):
    """[Boroushaki2023], Eq. 1, squared, cell by cell; one sum for each channel unless they are coherent."""
    h = np.where(trace.mask, trace.channel, 0)
    size = np.abs(h)
    h = h / size.max() if matching.amplitude else np.divide(h, size, out=np.zeros_like(h), where=size > 0)
    k = 2 * np.pi * trace.frequencies_hz / SPEED_OF_LIGHT_M_S
    power = []
    for d in trace.round_trip_m(points_m):
        sums = (h * np.exp(1j * np.outer(d, k))).sum(axis=0)
        power.append(abs(sums.sum()) ** 2 if matching.coherent else (np.abs(sums) ** 2).sum())
    return np.array(power)


@pytest.mark.parametrize("matching", MATCHINGS, ids=str)
@pytest.mark.parametrize("heard", [1.0, 0.6])
def test_the_compiled_filter_is_the_printed_sum(matching, heard):
    trace = reads_of([0.4, 0.7, 0.05], heard=heard)
    points_m = np.random.default_rng(1).uniform(VOLUME.lower_m, VOLUME.upper_m, (300, 3))
    expected = printed_sum(trace, points_m, matching)
    found = build_hologram(trace, VOLUME, matching).power(points_m)
    assert np.abs(found - expected).max() < 2e-3 * expected.max()


@pytest.mark.parametrize("matching", MATCHINGS, ids=str)
@pytest.mark.parametrize("moves", [False, True], ids=["still", "moving"])
def test_a_bistatic_path_uses_both_ways(moves, matching):
    trace = reads_of([0.4, 0.7, 0.05])
    tx_m = RAIL_M + np.array([0.0, 0.3, 0.1]) if moves else np.tile([0.5, -0.4, 0.3], (len(RAIL_M), 1))
    both = ReadTrace("tag", RAIL_M, FREQUENCIES_HZ, trace.channel, trace.read_counts, trace.antenna_ports, tx_m)
    points_m = np.random.default_rng(2).uniform(VOLUME.lower_m, VOLUME.upper_m, (200, 3))
    expected = printed_sum(both, points_m, matching)
    assert np.abs(build_hologram(both, VOLUME, matching).power(points_m) - expected).max() < 2e-3 * expected.max()


@given(st.floats(-2.0, 2.0), st.floats(0.1, 2.0))
def test_looks_of_one_channel_need_no_table_and_err_by_rounding_only(x_m, y_m):
    trace, points_m = reads_of([x_m, y_m, 0.05]), np.random.default_rng(4).uniform([-5, 0.1, -2], [5, 5, 2], (600, 3))
    wide = SearchVolume([-5.0, 0.1, -2.0], [5.0, 5.0, 2.0])
    expected = printed_sum(trace, points_m, Matching())
    assert np.abs(build_hologram(trace, wide, Matching()).power(points_m) - expected).max() < 1e-4 * expected.max()


@given(st.integers(0, 1000))
def test_a_constant_for_each_channel_changes_nothing(seed):
    points_m = np.random.default_rng(3).uniform(VOLUME.lower_m, VOLUME.upper_m, (50, 3))
    powers = [build_hologram(reads_of([0.4, 0.7, 0.0], seed=s), VOLUME, Matching()).power(points_m) for s in (0, seed)]
    assert np.allclose(*powers, rtol=1e-3, atol=1e-3 * powers[0].max())


@given(st.integers(0, 1000))
def test_half_turns_change_nothing_if_the_phase_is_known_modulo_pi(seed):
    points_m = np.random.default_rng(3).uniform(VOLUME.lower_m, VOLUME.upper_m, (50, 3))
    traces = [reads_of([0.4, 0.7, 0.0], seed=s, modulus_rad=np.pi, same_constant=True) for s in (0, seed)]
    powers = [build_hologram(trace, VOLUME, Matching()).power(points_m) for trace in traces]
    assert np.allclose(*powers, rtol=1e-3, atol=1e-3 * powers[0].max())


def test_a_full_grid_holds_the_filter_at_every_voxel():
    trace, volume = reads_of([0.1, 0.0, 0.0], square_m()), SearchVolume([-0.2, -0.1, 0.0], [0.2, 0.1, 0.1])
    image = sar_image(trace, volume, spacing_m=0.05)
    assert image.values.shape == (9, 5, 3)
    hologram = build_hologram(trace, volume, Matching())
    for index in [(0, 0, 0), (8, 4, 2), (4, 2, 1)]:
        point_m = image.origin_m + image.spacing_m * np.array(index)
        assert np.isclose(image.values[index], hologram.power(np.minimum(point_m, volume.upper_m)[None])[0], rtol=1e-4)


def test_a_point_outside_the_volume_is_refused():
    hologram = build_hologram(reads_of([0.4, 0.7, 0.0]), VOLUME, Matching())
    with pytest.raises(ShapeError, match="outside"):
        hologram.power(np.array([[0.5, 3.0, 0.0]]))
