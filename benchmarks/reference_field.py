"""A field of errors over reference tags: where a target is if its fix errs as those of its neighbours do.

What is seen of a tag at p is a vector z (its fix, perhaps its level) that differs from what physics says of p by a
field,

    z - f(p) = B h(p) + g(p) + e,    h(p) = [1, (p - mean) / spread],

with g a Gaussian process, squared exponential over a length ℓ, of a times the covariance Σ of the noise e. B has a
normal prior in units of Σ and Σ an inverse Wishart one, so that a target's z, given the references, is a Student vector
in closed form. ℓ and a are averaged over a few values by their evidence; references that are altogether off are weighed
down. A prior says that the target lies within the hull of the references, widened by the longest edge of their minimum
spanning tree. Tried for measured sweeps, see docs/posterior.md; not part of the library.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.sparse.csgraph import minimum_spanning_tree
from scipy.spatial import ConvexHull

from rfcompass.arrays import FloatArray

LENGTHS_M = (0.1, 0.2, 0.4)
SHARES = (0.0, 0.5, 2.0)  # a; 0 leaves the linear trend alone
TREND_SD = (10.0, 3.0, 3.0)  # of B, in units of the noise
NOISE_DEGREES, PRIOR_DEGREES, PREDICTIVE_DEGREES = 4.0, 4.0, 4.0
STEP_M, MARGIN_M, LEAST_Y_M = 0.03, 0.5, 0.15
ROUNDS = 8


@dataclass(frozen=True, slots=True)
class Guess:
    """Where a target is [m], shape (2,), and whether the 90 % region holds its true place; None without a region."""

    place_m: FloatArray
    held: bool | None


def squares(places_m: FloatArray) -> FloatArray:
    """Middles of squares of 3 cm on the side of the path where the references are [m], shape (G, 2)."""
    low_m, high_m = places_m.min(axis=0) - MARGIN_M, places_m.max(axis=0) + MARGIN_M
    x_m, y_m = np.arange(low_m[0], high_m[0], STEP_M), np.arange(max(low_m[1], LEAST_Y_M), high_m[1], STEP_M)
    return np.stack(np.meshgrid(x_m, y_m, indexing="ij"), axis=-1).reshape(-1, 2)


def judged(grid_m: FloatArray, log_density: FloatArray, truth_m: FloatArray) -> Guess:
    """Mean of a density over squares, and whether its 90 % region holds a place."""
    weight = np.exp(log_density - log_density.max())
    weight /= weight.sum()
    at = np.argmin(np.linalg.norm(grid_m - truth_m, axis=1))
    return Guess(weight @ grid_m, bool(weight[weight > weight[at]].sum() <= 0.9))


def near_references(places_m: FloatArray, grid_m: FloatArray) -> FloatArray:
    """True for squares within the hull of the references, widened by the longest edge of their spanning tree."""
    gaps_m = np.linalg.norm(places_m[:, None] - places_m[None], axis=2)
    hull = ConvexHull(places_m, qhull_options="QJ")
    inside = (grid_m @ hull.equations[:, :2].T + hull.equations[:, 2] <= 1e-9).all(axis=1)
    corners_m = places_m[hull.vertices]
    to_edge_m = [
        _distance_to_edge(grid_m, a_m, b_m) for a_m, b_m in zip(corners_m, np.roll(corners_m, -1, axis=0), strict=True)
    ]
    return inside | (np.min(to_edge_m, axis=0) <= minimum_spanning_tree(gaps_m).max())


def field_log_density(
    z: FloatArray,
    seen: FloatArray,
    places_m: FloatArray,
    grid_m: FloatArray,
    physics: Callable[[FloatArray], FloatArray],
) -> FloatArray:
    """Log density of the target's z at each square, shape (G,).

    Args:
        z: What is seen of the target, in units of the noise expected, shape (F,).
        seen: The same of the references, shape (N, F).
        places_m: Their places [m], shape (N, 2).
        grid_m: Squares [m], shape (G, 2).
        physics: f, from places (n, 2) to (n, F), in the same units.
    """
    off = seen - physics(places_m)
    middle = np.median(off, axis=0)
    target_off = z - physics(grid_m) - middle
    found = [
        _student(target_off, off - middle, places_m, grid_m, (length_m, share))
        for share in SHARES
        for length_m in (LENGTHS_M if share else LENGTHS_M[:1])
    ]
    return np.asarray(np.logaddexp.reduce(found, axis=0))


def _student(
    target_off: FloatArray, off: FloatArray, places_m: FloatArray, grid_m: FloatArray, shape: tuple[float, float]
) -> FloatArray:
    """Log density of the target for one length ℓ and share a, with the evidence for these as a factor."""
    (N, F), sd2 = off.shape, np.square(TREND_SD)
    H, Hg = (_trend(points_m, places_m) for points_m in (places_m, grid_m))
    prior, across = (_smooth(p, places_m, shape) + (h * sd2) @ H.T for p, h in ((places_m, H), (grid_m, Hg)))
    weight = np.ones(N)
    for _ in range(ROUNDS):
        inverse = np.linalg.inv(prior + np.diag(1.0 / weight))
        pull = inverse @ off
        sigma = (PRIOR_DEGREES * np.eye(F) + off.T @ pull) / (PRIOR_DEGREES + N)
        noise2 = _squared(pull / weight[:, None], sigma)
        weight = np.clip((NOISE_DEGREES + F) / (NOISE_DEGREES + noise2), 0.02, None)
    log_sigma = np.linalg.slogdet(sigma)[1]
    evidence = 0.5 * F * np.linalg.slogdet(inverse)[1] - 0.5 * (PRIOR_DEGREES + N) * log_sigma
    variance = shape[1] + 1.0 + Hg**2 @ sd2 - np.einsum("ij,jk,ik->i", across, inverse, across)
    miss2 = _squared(target_off - across @ pull, sigma) / variance
    tail = 0.5 * (PREDICTIVE_DEGREES + F) * np.log1p(miss2 / PREDICTIVE_DEGREES)
    return np.asarray(evidence - 0.5 * log_sigma - 0.5 * F * np.log(variance) - tail)


def _trend(points_m: FloatArray, places_m: FloatArray) -> FloatArray:
    middle_m = places_m.mean(axis=0)
    spread_m = np.sqrt(np.sum((places_m - middle_m) ** 2, axis=1).mean())
    return np.column_stack([np.ones(len(points_m)), (points_m - middle_m) / spread_m])


def _smooth(points_m: FloatArray, places_m: FloatArray, shape: tuple[float, float]) -> FloatArray:
    gaps2 = np.sum((points_m[:, None] - places_m[None]) ** 2, axis=2)
    return np.asarray(shape[1] * np.exp(-0.5 * gaps2 / shape[0] ** 2))


def _squared(vectors: FloatArray, sigma: FloatArray) -> FloatArray:
    return np.einsum("ij,jk,ik->i", vectors, np.linalg.inv(sigma), vectors)


def _distance_to_edge(grid_m: FloatArray, a_m: FloatArray, b_m: FloatArray) -> FloatArray:
    along = np.clip((grid_m - a_m) @ (b_m - a_m) / max(float(np.sum((b_m - a_m) ** 2)), 1e-12), 0.0, 1.0)
    return np.asarray(np.linalg.norm(grid_m - a_m - along[:, None] * (b_m - a_m), axis=1))


def stacked(values: Sequence[FloatArray]) -> FloatArray:
    """Columns side by side, shape (n, F)."""
    return np.column_stack([np.atleast_2d(v.T).T for v in values])
