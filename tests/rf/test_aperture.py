import numpy as np
import pytest

from rfcompass.errors import UnsuitablePath
from rfcompass.rf.aperture import straight_apertures

TAG_M = [0.5, 0.7, 0.0]


def test_positions_on_a_line_keep_their_distances(make_trace):
    direction = np.array([1.0, 2.0, -1.0]) / np.sqrt(6.0)
    places_m = np.sort(np.random.default_rng(0).uniform(0.0, 1.0, 30))
    (aperture,) = straight_apertures(make_trace(TAG_M, places_m[:, None] * direction))
    np.testing.assert_allclose(np.diff(aperture.offsets_m), np.diff(places_m), atol=1e-12)


def test_offsets_grow_in_path_direction_whatever_the_direction(make_trace, line):
    for path in (line(), line()[::-1]):
        (aperture,) = straight_apertures(make_trace(TAG_M, path.copy()))
        assert (np.diff(aperture.offsets_m) > 0).all()


def test_a_bent_path_has_one_aperture_for_each_leg(make_trace, line):
    corner = np.concatenate([line(0.5, 26), np.array([0.5, 0.0, 0.0]) + line(0.5, 26)[1:, [1, 0, 2]]])
    trace = make_trace(TAG_M, corner)
    one, other = straight_apertures(trace)
    np.testing.assert_array_equal(np.concatenate([one.channel, other.channel]), trace.channel)
    assert np.ptp(one.offsets_m) + np.ptp(other.offsets_m) == pytest.approx(0.98)


def test_a_curve_is_refused_with_the_size_of_the_bend(make_trace):
    angle = np.linspace(0.0, np.pi / 2, 40)[:, None]
    curve = 0.5 * np.hstack([np.cos(angle), np.sin(angle), 0 * angle])
    with pytest.raises(UnsuitablePath, match="straight") as caught:
        straight_apertures(make_trace(TAG_M, curve))
    assert caught.value.numbers["bend_m"] > 0.02


def test_an_antenna_that_stands_still_is_no_aperture(make_trace):
    with pytest.raises(UnsuitablePath, match="no aperture"):
        straight_apertures(make_trace(TAG_M, np.zeros((5, 3))))


def test_a_transmitter_that_moves_otherwise_than_the_receiver_is_refused(make_trace, line):
    with pytest.raises(UnsuitablePath, match="apart"):
        straight_apertures(make_trace(TAG_M, line(), tx_m=line()[:, [1, 0, 2]]))


@pytest.mark.parametrize(("half_turns", "legs"), [(False, 2.0), (True, 4.0)])
def test_a_half_turn_ambiguity_doubles_the_path(make_trace, half_turns, legs):
    (aperture,) = straight_apertures(make_trace(TAG_M, half_turns=half_turns))
    assert aperture.legs == legs


def test_a_fixed_transmitter_leaves_one_leg(make_trace, line):
    tx_m = np.broadcast_to([0.0, -1.0, 0.0], (51, 3))
    (aperture,) = straight_apertures(make_trace(TAG_M, line(), tx_m=tx_m))
    assert aperture.legs == 1.0


def test_a_transmitter_that_moves_along_makes_two_legs(make_trace, line):
    (aperture,) = straight_apertures(make_trace(TAG_M, line(), tx_m=line() + np.array([0.0, 0.1, 0.0])))
    assert aperture.legs == 2.0


@pytest.mark.parametrize("parts", [1, 2, 5])
def test_sub_apertures_are_equally_long_and_hold_every_position_once(make_trace, parts):
    (whole,) = straight_apertures(make_trace(TAG_M))
    split = whole.split(parts)
    np.testing.assert_array_equal(np.concatenate([part.offsets_m for part in split]), whole.offsets_m)
    assert all(np.ptp(part.offsets_m) <= np.ptp(whole.offsets_m) / parts + 1e-9 for part in split)
