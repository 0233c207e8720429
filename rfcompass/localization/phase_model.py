"""Phase along the antenna path as a hyperbolic model plus reflections that are correlated along the path.

In one run and channel the phase lag φ = -arg h of a tag at p is

    φ(m) = k d(p, m) + constant + e(m),      d = round trip antenna → p → antenna.

What the line of sight leaves unexplained, e, is not noise: reads repeat to a degree, reflections turn the phase by up
to a radian, and they change slowly along the path. We take e as a Gaussian process with a part of reflections
(Matérn 3/2) and a part of noise,

    cov(e(m), e(m')) = σ² [ (1 + √3 u) exp(-√3 u) + ν δ_mm' ] / (1 + ν),      u = |a_m - a_m'| / ℓ.

It says how far a least-squares fit can be off; a fit that took e for independent noise would be far too sure of itself.
"""

from dataclasses import dataclass

import numpy as np

from rfcompass.arrays import FloatArray, IntArray
from rfcompass.rf.runs import runs
from rfcompass.rf.waves import wavelength, wavenumber
from rfcompass.types.reads import ReadTrace
from rfcompass.types.volumes import SearchVolume


@dataclass(frozen=True, kw_only=True)
class PathCovariance:
    """Shape of the covariance of e.

    Both values are ours: the likeliest length for the residuals at the true positions of two families of measured
    development sweeps is 0.15 to 0.2 m, about half a wavelength.

    Attributes:
        length_wavelengths: Correlation length ℓ of the reflections, in wavelengths.
        noise: Variance ν of the noise, as a share of that of the reflections.
    """

    length_wavelengths: float = 0.5
    noise: float = 0.01

    def correlation(self, positions_m: FloatArray, wavelength_m: float) -> FloatArray:
        """cov(e, e) / σ² at positions (n, 3) [m], shape (n, n)."""
        gaps_m = np.linalg.norm(positions_m[:, None, :] - positions_m[None, :, :], axis=2)
        u = np.sqrt(3.0) * gaps_m / (self.length_wavelengths * wavelength_m)
        return np.asarray(((1.0 + u) * np.exp(-u) + self.noise * np.eye(len(u))) / (1.0 + self.noise))


@dataclass(frozen=True)
class Stretch:
    """One run in one channel: heard positions (n) and wavenumber k [rad/m]."""

    rows: IntArray
    channel: int
    k: float


@dataclass(frozen=True)
class PhaseModel:
    """The phases of one trace, ready to be compared with any position; make it with `build_phase_model`."""

    trace: ReadTrace
    stretches: tuple[Stretch, ...]

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
        """φ - k d(p) less its mean, which takes out the constant, of all stretches at a point [m], shape (N,)."""
        d = self.trace.round_trip_m(point_m[None, :])[0]
        return np.concatenate([_centred(lag - s.k * d[s.rows]) for s, lag in zip(self.stretches, lags, strict=True)])

    def jacobian(self, point_m: FloatArray) -> FloatArray:
        """Derivative of the residuals with respect to x, y, z [rad/m], shape (N, 3)."""
        gradient = _round_trip_gradient(self.trace, point_m)
        return np.concatenate([-s.k * _centred(gradient[s.rows]) for s in self.stretches])

    def fit_covariance(
        self, point_m: FloatArray, variance_rad2: float, shape: PathCovariance, volume: SearchVolume
    ) -> FloatArray:
        """Covariance of a least-squares fit near a point if the errors are correlated [m²], shape (n, n).

        (JᵀJ/σ² + P)⁻¹ (JᵀRJ/σ² + P) (JᵀJ/σ² + P)⁻¹ over the n free axes, with R the correlation along each run and P
        the prior of a tag anywhere in the volume, which decides where the path does not observe an axis. Reflections
        are the same in all channels, so that the channels of a run count as one.

        Args:
            point_m: The fit [m], shape (3,).
            variance_rad2: σ² [rad²].
            shape: How errors are correlated along the path.
            volume: Where the tag can be; gives the free axes.
        """
        free = volume.free_axes
        prior = np.diag(12.0 / (volume.upper_m - volume.lower_m)[free] ** 2)
        information, spread = prior.copy(), prior.copy()
        gradient = _round_trip_gradient(self.trace, point_m)[:, free]
        wavelength_m = float(wavelength(self.trace.frequencies_hz).mean())
        for rows, k in self._runs_and_mean_wavenumbers():
            J = k / np.sqrt(max(variance_rad2, 1e-12)) * _centred(gradient[rows])
            information += J.T @ J
            spread += J.T @ shape.correlation(self.trace.antenna_positions_m[rows], wavelength_m) @ J
        inverse = np.linalg.inv(information)
        return np.asarray(inverse @ spread @ inverse)

    def independent_share(self, shape: PathCovariance) -> float:
        """How many of the N residuals are independent of each other, as a share n / N.

        A run of m positions whose errors have the correlation R is worth m² / ΣR positions in a mean, and a run's
        channels, which see the same reflections, count as one.

        Args:
            shape: How errors are correlated along the path.
        """
        wavelength_m = float(wavelength(self.trace.frequencies_hz).mean())
        positions_m = self.trace.antenna_positions_m
        worth = sum(
            rows.size**2 / shape.correlation(positions_m[rows], wavelength_m).sum()
            for rows, _ in self._runs_and_mean_wavenumbers()
        )
        return float(worth / sum(stretch.rows.size for stretch in self.stretches))

    def _runs_and_mean_wavenumbers(self) -> list[tuple[IntArray, float]]:
        """Positions heard in some channel, and the mean k of those channels, for each run."""
        k = wavenumber(self.trace.frequencies_hz)
        heard = [run[self.trace.mask[run].any(axis=1)] for run in runs(self.trace)]
        return [(rows, float(k.mean())) for rows in heard if rows.size >= 2]


def build_phase_model(trace: ReadTrace) -> PhaseModel:
    """Collect every run and channel of a trace in which the tag was heard at two positions or more."""
    k = wavenumber(trace.frequencies_hz)
    heard = [(run[trace.mask[run, f]], f) for run in runs(trace) for f in range(k.size)]
    return PhaseModel(trace, tuple(Stretch(rows, f, float(k[f])) for rows, f in heard if rows.size >= 2))


def _centred(values: FloatArray) -> FloatArray:
    return np.asarray(values - values.mean(axis=0))


def _round_trip_gradient(trace: ReadTrace, point_m: FloatArray) -> FloatArray:
    """Derivative of the round trip to each antenna position with respect to the point, shape (M, 3)."""
    rx = _unit(point_m - trace.antenna_positions_m)
    return np.asarray(2.0 * rx if trace.tx_positions_m is None else rx + _unit(point_m - trace.tx_positions_m))


def _unit(vectors: FloatArray) -> FloatArray:
    return np.asarray(vectors / np.maximum(np.linalg.norm(vectors, axis=1, keepdims=True), 1e-9))
