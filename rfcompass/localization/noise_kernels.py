"""Noise of a meter from the robot's own tags, whose places are known: the sums, compiled."""

import numba
import numpy as np

from rfcompass.arrays import FloatArray

_REFITS = 5
_BATCH = 16  # factors multiplied before a logarithm is taken


@numba.njit(cache=True, error_model="numpy")
def _scale_for(d: FloatArray, m: FloatArray, s2: FloatArray, start: float) -> float:
    """Scale c of m = c (d + s t), t Student-4, by reweighting: w = 5 / (4 + u²)."""
    c = start
    for _ in range(_REFITS):
        top, below = 0.0, 0.0
        for n in range(d.size):
            miss = m[n] / c - d[n]
            w = 5.0 / (4.0 + miss * miss / s2[n]) / s2[n]
            top += w * m[n] * d[n]
            below += w * d[n] * d[n]
        c = max(top / below, 1e-12)
    return c


@numba.njit(cache=True, error_model="numpy")
def distance_noise(d: FloatArray, m: FloatArray, alphas: FloatArray, betas: FloatArray) -> tuple[float, float, float]:
    """Most likely scale c and noise α, β of m = c (d + s t), s² = α² + β² d², t Student-4, over a grid of α and β.

    Args:
        d: True distances [m], shape (P,).
        m: Proximities of the same pairs, shape (P,).
        alphas: Values of α to try [m].
        betas: Values of β to try.

    Returns:
        c [units of m per metre], α [m], β.
    """
    best, found = -np.inf, (1.0, alphas[-1], betas[-1])
    start = np.median(m / d)
    for alpha in alphas:
        for beta in betas:
            s2 = alpha * alpha + beta * beta * d * d
            c = _scale_for(d, m, s2, max(start, 1e-12))
            u2 = (m / c - d) ** 2 / s2
            fit = -(np.log(c) + 0.5 * np.log(s2) + 2.5 * np.log(1.0 + 0.25 * u2)).sum()
            if fit > best:
                best, found = fit, (c, alpha, beta)
    return found


@numba.njit(cache=True, error_model="numpy")
def comparison_fits(
    d: FloatArray, m: FloatArray, scales: FloatArray, lapses: FloatArray
) -> tuple[FloatArray, int, int]:
    """Log likelihood of P(nearer wins) = λ/2 + (1 - λ) / (1 + exp(-Δd / s)) over a grid of s and λ.

    Every anchor plays the part tag in turn and is compared with every pair of the others.

    Args:
        d: Distances between the anchors [m], shape (N, N).
        m: Their proximities, NaN where missing, shape (N, N).
        scales: Values of s to try [m], shape (S,).
        lapses: Values of λ to try, shape (L,).

    Returns:
        The log likelihoods, shape (S, L), number of comparisons, and how many of them are right.
    """
    fit, product = np.zeros((scales.size, lapses.size)), np.ones((scales.size, lapses.size))
    count, right, N = 0, 0, d.shape[0]
    for k in range(N):
        for i in range(N):
            for j in range(i):
                ahead = m[k, j] - m[k, i]
                if k in (i, j) or not abs(ahead) > 0.0:
                    continue
                lead = (d[k, j] - d[k, i]) * np.sign(ahead)
                count += 1
                right += lead > 0.0
                for a in range(scales.size):
                    wins = 1.0 / (1.0 + np.exp(-lead / scales[a]))
                    for b in range(lapses.size):
                        product[a, b] *= 0.5 * lapses[b] + (1.0 - lapses[b]) * wins
                if count % _BATCH == 0:
                    fit += np.log(product)
                    product[:] = 1.0
    return fit + np.log(product), count, right


@numba.njit(cache=True, error_model="numpy")
def own_fix_errors(anchors_m: FloatArray, r_m: FloatArray, noise: FloatArray, prior_sd: float) -> FloatArray:
    """How far each anchor seems from its place, by its distances to all the others.

    Student-4 location by reweighted Gauss-Newton steps in the plane, from the true place, with a normal prior on
    the displacement so that directions which the others do not observe stay put.

    Args:
        anchors_m: Anchors [m], shape (N, 3).
        r_m: Distances that their proximities stand for [m], NaN where missing, shape (N, N).
        noise: α [m] and β, shape (2,).
        prior_sd: Standard deviation of the prior [m].

    Returns:
        Displacements [m], NaN for an anchor with fewer than three distances, shape (N, 2).
    """
    N = anchors_m.shape[0]
    errors = np.full((N, 2), np.nan)
    for i in range(N):
        shift = np.zeros(2)
        for _ in range(_REFITS):
            xx = yy = 1.0 / prior_sd**2
            xy, count = 0.0, 0
            gx, gy = -shift[0] * xx, -shift[1] * yy
            for j in range(N):
                if j == i or np.isnan(r_m[i, j]):
                    continue
                dx, dy = anchors_m[i, 0] + shift[0] - anchors_m[j, 0], anchors_m[i, 1] + shift[1] - anchors_m[j, 1]
                d = np.sqrt(dx * dx + dy * dy + (anchors_m[i, 2] - anchors_m[j, 2]) ** 2)
                s2 = noise[0] ** 2 + noise[1] ** 2 * d * d
                miss = r_m[i, j] - d
                w = 5.0 / (4.0 + miss * miss / s2) / s2
                ux, uy = dx / d, dy / d
                xx, xy, yy = xx + w * ux * ux, xy + w * ux * uy, yy + w * uy * uy
                gx, gy = gx + w * miss * ux, gy + w * miss * uy
                count += 1
            if count < 3:
                break
            det = xx * yy - xy * xy
            shift[0] += (yy * gx - xy * gy) / det
            shift[1] += (xx * gy - xy * gx) / det
        if count >= 3:
            errors[i] = shift
    return errors
