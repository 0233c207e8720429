import numpy as np
import pytest
from dtaidistance import dtw as peer
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from rfcompass.errors import InputError
from rfcompass.rf.dtw import dtw, dtw_matrix

samples = st.floats(-5.0, 5.0).map(lambda x: round(x, 3))
profiles = st.integers(1, 12).flatmap(lambda n: arrays(np.float64, n, elements=samples))
bands = st.none() | st.integers(0, 12)
costs = st.sampled_from(["absolute", "squared"])
penalties = st.sampled_from([0.0, 0.1, 1.0])


def slow_dtw(a, b, band=None, cost="absolute", step_penalty=0.0, per_step=False):
    """The recursion as it is printed, cell by cell."""
    n, m = len(a), len(b)
    width = max(n, m) if band is None else band
    D = np.full((n + 1, m + 1), np.inf)
    steps = np.zeros((n + 1, m + 1))
    D[0, 0] = 0.0
    for i in range(n):
        for j in range(m):
            if i - j > width + max(0, n - m) or j - i > width + max(0, m - n):
                continue
            gap = abs(a[i] - b[j])
            ways = [
                (D[i, j], steps[i, j]),
                (D[i, j + 1] + step_penalty, steps[i, j + 1]),
                (D[i + 1, j] + step_penalty, steps[i + 1, j]),
            ]
            best, count = min(ways)
            D[i + 1, j + 1] = best + (gap if cost == "absolute" else gap**2)
            steps[i + 1, j + 1] = count + 1
    return D[n, m] / steps[n, m] if per_step else D[n, m]


@given(profiles, profiles, bands, costs, penalties, st.booleans())
def test_anti_diagonals_give_what_the_recursion_gives(a, b, band, cost, step_penalty, per_step):
    options = {"band": band, "cost": cost, "step_penalty": step_penalty, "per_step": per_step}
    assert dtw(a, b, **options) == pytest.approx(slow_dtw(a, b, **options), rel=1e-12, abs=1e-12)


@given(profiles, profiles, bands, penalties)
def test_squared_costs_agree_with_dtaidistance(a, b, band, step_penalty):
    theirs = peer.distance(a, b, window=None if band is None else band + 1, penalty=step_penalty**0.5, use_c=True)
    assert np.sqrt(dtw(a, b, band=band, cost="squared", step_penalty=step_penalty)) == pytest.approx(theirs, abs=1e-9)


@given(profiles, profiles, bands, penalties)
def test_absolute_costs_agree_with_dtaidistance(a, b, band, step_penalty):
    window = None if band is None else band + 1
    # its C code squares the penalty, whatever the inner distance
    theirs = peer.distance(a, b, window=window, penalty=step_penalty**0.5, inner_dist="euclidean", use_c=True)
    assert dtw(a, b, band=band, step_penalty=step_penalty) == pytest.approx(theirs, abs=1e-9)


def test_long_profiles_agree_with_dtaidistance():
    rng = np.random.default_rng(7)
    A = rng.normal(size=(6, 256)).cumsum(axis=1)
    np.testing.assert_allclose(
        np.sqrt(dtw_matrix(A, cost="squared")), peer.distance_matrix_fast(A, parallel=False), rtol=1e-12
    )


@given(profiles, bands, costs, penalties, st.booleans())
def test_a_profile_is_no_distance_from_itself(a, band, cost, step_penalty, per_step):
    assert dtw(a, a, band=band, cost=cost, step_penalty=step_penalty, per_step=per_step) == 0.0


@given(profiles, profiles, bands, costs, penalties, st.booleans())
def test_the_distance_is_the_same_in_both_directions(a, b, band, cost, step_penalty, per_step):
    options = {"band": band, "cost": cost, "step_penalty": step_penalty, "per_step": per_step}
    assert dtw(a, b, **options) == pytest.approx(dtw(b, a, **options), rel=1e-12)


@given(profiles, profiles, st.integers(0, 11), costs, penalties)
def test_a_wider_band_never_enlarges_the_distance(a, b, band, cost, step_penalty):
    narrow = dtw(a, b, band=band, cost=cost, step_penalty=step_penalty)
    assert dtw(a, b, band=band + 1, cost=cost, step_penalty=step_penalty) <= narrow
    assert dtw(a, b, cost=cost, step_penalty=step_penalty) <= narrow


@given(profiles, profiles, bands, costs)
def test_a_penalty_never_lowers_the_distance(a, b, band, cost):
    free, light, heavy = (dtw(a, b, band=band, cost=cost, step_penalty=p) for p in (0.0, 0.1, 1.0))
    assert free <= light <= heavy


@given(st.integers(1, 12).flatmap(lambda n: arrays(np.float64, (2, n), elements=samples)), bands)
def test_profiles_of_equal_length_are_no_further_apart_than_without_warping(pair, band):
    assert dtw(pair[0], pair[1], band=band) <= np.abs(pair[0] - pair[1]).sum() + 1e-9
    assert dtw(pair[0], pair[1], band=0) == pytest.approx(np.abs(pair[0] - pair[1]).sum())


@given(profiles, profiles, bands, penalties)
def test_first_and_last_samples_are_a_lower_bound(a, b, band, step_penalty):
    ends = abs(a[0] - b[0]) + (abs(a[-1] - b[-1]) if len(a) > 1 or len(b) > 1 else 0.0)
    assert dtw(a, b, band=band, step_penalty=step_penalty) >= ends - 1e-12


@given(profiles, st.integers(1, 4))
def test_stretching_a_profile_costs_nothing(a, factor):
    assert dtw(a, np.repeat(a, factor)) == 0.0


def test_a_free_warp_forgives_the_shift_of_a_peak_and_a_band_does_not():
    angle = np.arange(181.0)
    here, there = (np.exp(-(((angle - centre) / 6) ** 2)) for centre in (70.0, 110.0))
    assert dtw(here, there) < 0.05 * dtw(here, there, band=10)


@given(st.integers(1, 4), st.integers(1, 4), st.integers(0, 2**31))
def test_the_matrix_holds_the_distance_of_each_pair(P, Q, seed):
    rng = np.random.default_rng(seed)
    A, B = rng.normal(size=(P, 9)), rng.normal(size=(Q, 7))
    expected = [[dtw(a, b, band=2) for b in B] for a in A]
    np.testing.assert_array_equal(dtw_matrix(A, B, band=2), expected)
    np.testing.assert_array_equal(dtw_matrix(A), dtw_matrix(A, A))


def test_a_profile_with_nan_has_no_distance_and_spoils_no_other():
    A = np.array([[0.0, 1.0], [np.nan, 1.0], [2.0, 3.0]])
    found = dtw_matrix(A)
    assert np.isnan(found[1]).all()
    assert np.isnan(found[:, 1]).all()
    assert found[0, 2] == slow_dtw(A[0], A[2])


@pytest.mark.parametrize(
    "wrong",
    [{"band": -1}, {"cost": "cubic"}, {"step_penalty": -0.1}, {"step_penalty": float("nan")}],
)
def test_options_out_of_range_are_refused(wrong):
    with pytest.raises(InputError, match="dtw"):
        dtw(np.zeros(3), np.zeros(3), **wrong)


@pytest.mark.parametrize("wrong", [np.zeros(0), np.zeros((2, 2)), np.float64(1.0)])
def test_profiles_must_be_rows_of_samples(wrong):
    with pytest.raises(InputError, match="dtw"):
        dtw(wrong, np.zeros(3))
