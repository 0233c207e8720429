"""Phase along the antenna path as a hyperbolic model plus reflections that are correlated along the path.

In one run and channel the phase lag φ = -arg h of a tag at p is

    φ(m) = k d(p, m) + constant + e(m),      d = round trip antenna → p → antenna.

What the line of sight leaves unexplained, e, is not noise: reads repeat to a degree, reflections turn the phase by up
to a radian, and they change slowly along the path. We take e as a Gaussian process with a part of reflections
(Matérn 3/2) and a part of noise,

    cov(e(m), e(m')) = σ² [ (1 + √3 u) exp(-√3 u) + ν δ_mm' ],      u = |a_m - a_m'| / ℓ,

and the constant as unknown with a flat prior. With the Cholesky factor L of this covariance at σ = 1, L⁻¹ (φ - k d) is
white and free of the constant. A fit that takes e for white noise trusts a slow bend of the phase, which is what a
reflection and a wrong range both look like; whitening makes it look at the faster changes instead.
"""

from dataclasses import dataclass

import numpy as np
from scipy.linalg import solve_triangular

from rfcompass.arrays import FloatArray, IntArray
from rfcompass.rf.runs import runs
from rfcompass.rf.waves import wavelength, wavenumber
from rfcompass.types.reads import ReadTrace

FLAT_PRIOR_RAD2 = 1e4


@dataclass(frozen=True, kw_only=True)
class PathCovariance:
    """Shape of the covariance of e.

    Both values are ours. The length was chosen on two families of measured tuning sweeps, where 0.4 to 0.6 wavelengths
    serve alike.

    Attributes:
        length_wavelengths: Correlation length ℓ of the reflections, in wavelengths.
        noise: Variance ν of the noise, as a share of σ².
    """

    length_wavelengths: float = 0.5
    noise: float = 0.01

    def whitening(self, positions_m: FloatArray, wavelength_m: float) -> FloatArray:
        """L⁻¹ at positions (n, 3) [m], shape (n, n)."""
        gaps_m = np.linalg.norm(positions_m[:, None, :] - positions_m[None, :, :], axis=2)
        u = np.sqrt(3.0) * gaps_m / (self.length_wavelengths * wavelength_m)
        covariance = (1.0 + u) * np.exp(-u) + self.noise * np.eye(len(u)) + FLAT_PRIOR_RAD2
        return np.asarray(solve_triangular(np.linalg.cholesky(covariance), np.eye(len(u)), lower=True))


@dataclass(frozen=True)
class Stretch:
    """One run in one channel: heard positions (n), wavenumber k [rad/m], and L⁻¹, shape (n, n)."""

    rows: IntArray
    channel: int
    k: float
    whitening: FloatArray


@dataclass(frozen=True)
class PhaseModel:
    """The phases of one trace, ready to be compared with any position; make it with `build_phase_model`."""

    trace: ReadTrace
    stretches: tuple[Stretch, ...]

    @property
    def channels_per_position(self) -> float:
        """Mean number of channels in which a position was heard."""
        rows = np.concatenate([s.rows for s in self.stretches])
        return rows.size / np.unique(rows).size

    def lags(self, near_m: FloatArray) -> tuple[FloatArray, ...]:
        """Phase lag φ of each stretch, unwrapped about the phase of a tag at `near_m` [m], shape (3,); each (n,)."""
        d = self.trace.round_trip_m(near_m[None, :])[0]
        return tuple(
            s.k * d[s.rows]
            + np.unwrap(
                -np.angle(self.trace.channel[s.rows, s.channel] * np.exp(1j * s.k * d[s.rows])),
                period=self.trace.phase_modulus_rad,
            )
            for s in self.stretches
        )

    def residuals(self, point_m: FloatArray, lags: tuple[FloatArray, ...]) -> FloatArray:
        """White residuals L⁻¹ (φ - k d(p)) of all stretches at a point [m], shape (N,)."""
        d = self.trace.round_trip_m(point_m[None, :])[0]
        return np.concatenate(
            [s.whitening @ (lag - s.k * d[s.rows]) for s, lag in zip(self.stretches, lags, strict=True)]
        )

    def jacobian(self, point_m: FloatArray) -> FloatArray:
        """Derivative of the white residuals with respect to x, y, z [1/m], shape (N, 3)."""
        gradient = _round_trip_gradient(self.trace, point_m)
        return np.concatenate([-s.k * (s.whitening @ gradient[s.rows]) for s in self.stretches])

    def rms_rad(self, point_m: FloatArray, lags: tuple[FloatArray, ...]) -> float:
        """Root mean square of φ - k d(p) less its mean in each stretch [rad]."""
        d = self.trace.round_trip_m(point_m[None, :])[0]
        rests = [lag - s.k * d[s.rows] for s, lag in zip(self.stretches, lags, strict=True)]
        return float(np.sqrt(np.mean(np.concatenate([rest - rest.mean() for rest in rests]) ** 2)))


def build_phase_model(trace: ReadTrace, covariance: PathCovariance) -> PhaseModel:
    """Collect every run and channel of a trace in which the tag was heard at two positions or more."""
    k, wavelength_m = wavenumber(trace.frequencies_hz), float(wavelength(trace.frequencies_hz).mean())
    known: dict[bytes, FloatArray] = {}
    stretches = []
    for run in runs(trace):
        for f in range(k.size):
            rows = run[trace.mask[run, f]]
            if rows.size >= 2:
                if rows.tobytes() not in known:
                    known[rows.tobytes()] = covariance.whitening(trace.antenna_positions_m[rows], wavelength_m)
                stretches.append(Stretch(rows, f, float(k[f]), known[rows.tobytes()]))
    return PhaseModel(trace, tuple(stretches))


def _round_trip_gradient(trace: ReadTrace, point_m: FloatArray) -> FloatArray:
    """Derivative of the round trip to each antenna position with respect to the point, shape (M, 3)."""
    rx = _unit(point_m - trace.antenna_positions_m)
    return np.asarray(2.0 * rx if trace.tx_positions_m is None else rx + _unit(point_m - trace.tx_positions_m))


def _unit(vectors: FloatArray) -> FloatArray:
    return np.asarray(vectors / np.maximum(np.linalg.norm(vectors, axis=1, keepdims=True), 1e-9))
