"""Compiled slopes are the printed ones; the climb ends at the top of a lobe, or at the border below it."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rfcompass.rf.image_slopes import LegSlopes, Slopes, climb_to_top
from rfcompass.types.volumes import SearchVolume

BOX = SearchVolume([-1.0, -1.0, 0.3], [1.0, 1.0, 0.3])
WIDTHS_M = np.array([0.05, 0.3, 1.0])
inside = st.floats(-0.9, 0.9)


def distance(point_m, antenna_m):
    """Distances [m] with gradients and Hessians."""
    away_m = point_m - antenna_m
    r = np.linalg.norm(away_m, axis=1)
    u = away_m / r[:, None]
    return r, u, (np.eye(3) - u[:, :, None] * u[:, None, :]) / r[:, None, None]


def printed(leg, point_m):
    """Power of a leg with its derivatives, as at the top of `image_slopes`."""
    ways = [distance(point_m, antenna_m) for antenna_m in (leg.rx_m, leg.rx_m if leg.tx_m is None else leg.tx_m)]
    d, g, H = (one + other for one, other in zip(*ways, strict=True))
    value, gradient, hessian = 0.0, np.zeros(3), np.zeros((3, 3))
    for rows in leg.runs:
        for channels in [np.arange(leg.k.size)] if leg.coherent else np.arange(leg.k.size)[:, None]:
            k, w = leg.k[channels], leg.h[np.ix_(rows, channels)] * np.exp(1j * np.outer(d[rows], leg.k[channels]))
            A, slope = w.sum(), 1j * np.einsum("mf,f,mi->i", w, k, g[rows])
            turn = np.einsum("mf,f,mi,mj->ij", w, k**2, g[rows], g[rows])
            bend = np.einsum("mf,f,mij->ij", w, 1j * k, H[rows]) - turn
            value += abs(A) ** 2
            gradient += 2.0 * (A.conj() * slope).real
            hessian += 2.0 * (np.outer(slope.conj(), slope) + A.conj() * bend).real
    return value / leg.norm, gradient / leg.norm, hessian / leg.norm


@pytest.mark.parametrize("coherent", [False, True])
@pytest.mark.parametrize("bistatic", [False, True])
@given(x=inside, y=inside, seed=st.integers(0, 1000))
def test_compiled_slopes_are_the_printed_ones(bistatic, coherent, x, y, seed):
    rng = np.random.default_rng(seed)
    rx_m, tx_m = rng.uniform([-1, 1.5, 0], [1, 2.5, 1], (2, 12, 3))
    h = rng.normal(size=(12, 3)) + 1j * rng.normal(size=(12, 3))
    h[rng.random(h.shape) < 0.2] = 0.0
    runs = tuple(np.array_split(rng.permutation(12), 2))
    k = rng.uniform(18.0, 21.0, 3)
    leg = LegSlopes(rx_m, tx_m if bistatic else None, h, k, runs, coherent, norm=3.0)
    point_m = np.array([x, y, 0.3])
    for found, expected in zip(leg.power(point_m), printed(leg, point_m), strict=True):
        np.testing.assert_allclose(found, expected, rtol=1e-9, atol=1e-9 * np.abs(expected).max())


def hill(top_m):
    """Logarithm of a Lorentzian hill: not a parabola, and curved the other way far from its top."""

    def at(point_m):
        u = (point_m - top_m) / WIDTHS_M
        size = 1.0 + u @ u
        slope = -2.0 * u / WIDTHS_M / size
        bend = -2.0 * np.diag(1.0 / WIDTHS_M**2) / size + np.outer(slope, slope)
        return Slopes(-float(np.log(size)), slope, bend)

    return at


@given(x=inside, y=inside, dx=st.floats(-0.09, 0.09), dy=st.floats(-0.09, 0.09))
def test_it_finds_the_top_to_the_last_bit(x, y, dx, dy):
    top_m = np.array([x, y, 0.3])
    found = climb_to_top(hill(top_m), BOX, top_m + np.array([dx, dy, 0.0]), 0.3)
    np.testing.assert_allclose(found, top_m, atol=1e-9)


@given(x=inside, beyond=st.floats(0.01, 0.2))
def test_a_top_beyond_the_border_is_met_at_the_border(x, beyond):
    found = climb_to_top(hill(np.array([x, 1.0 + beyond, 0.3])), BOX, np.array([x, 0.9, 0.3]), 0.3)
    np.testing.assert_allclose(found, [x, 1.0, 0.3], atol=1e-9)


def test_a_height_that_is_known_is_kept():
    found = climb_to_top(hill(np.array([0.1, 0.2, 0.8])), BOX, np.array([0.12, 0.1, 0.3]), 0.3)
    assert found[2] == 0.3


def test_where_nothing_is_known_it_stays():
    def flat(_):
        return Slopes(0.0, np.zeros(3), np.zeros((3, 3)))

    assert climb_to_top(flat, BOX, np.array([0.1, 0.2, 0.3]), 0.3).tolist() == [0.1, 0.2, 0.3]
