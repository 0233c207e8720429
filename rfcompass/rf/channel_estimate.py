"""Channel of a tag from the samples of a software radio [Boroushaki2023], section 4.2, step 1.

A tag answers with a signal x(t) that the reader knows once it has decoded it, and the radio receives
y(t) = h x(t) + n(t). The least-squares estimate of the channel is the correlation

    h = Σ_t y(t) x*(t) / Σ_t |x(t)|²,

with the noise power σ² = Σ_t |y - h x|² / (T - 1), and the variance σ² / Σ |x|² of h itself.

Deviations:
    The paper prints the sum without its denominator. Then the size of h depends on how long one listened and how loudly
    the tag answered, and measurements of different length get different weights in Eq. 1. `normalised=False` gives the
    printed sum; `offset=True` also takes out what does not change with the tag, above all the reader's own carrier.
"""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from rfcompass.arrays import ComplexArray, FloatArray, read_only
from rfcompass.errors import InputError, ShapeError
from rfcompass.types.record import Record

SILENT = 1e-12  # share of the energy of x below which its variation is rounding


@dataclass(frozen=True, slots=True)
class ChannelEstimate(Record):
    """Channels estimated from samples, one for each element of the batch (any shape, such as frequencies by poses).

    Attributes:
        channel: h.
        noise_power: σ², power of the noise in one sample.
        standard_error: Standard deviation of h, real and imaginary part together.
    """

    channel: ComplexArray
    noise_power: FloatArray
    standard_error: FloatArray

    def __post_init__(self) -> None:
        """Freeze the arrays and check that they belong together."""
        shape, set_ = np.shape(self.channel), object.__setattr__
        set_(self, "channel", read_only(self.channel, "ChannelEstimate.channel", shape, np.complex128))
        for name in ("noise_power", "standard_error"):
            set_(self, name, read_only(getattr(self, name), f"ChannelEstimate.{name}", shape))


def estimate_channel(
    received: npt.ArrayLike, sent: npt.ArrayLike, *, normalised: bool = True, offset: bool = False
) -> ChannelEstimate:
    """Correlate what was received with what the tag sent [Boroushaki2023], section 4.2.

    Args:
        received: Complex samples y of each frequency and pose, shape (..., T).
        sent: The tag's signal x, sampled at the same times, shape (T,) for all of them or (..., T).
        normalised: Divide by the energy of x; otherwise h is the sum as printed.
        offset: Fit y = h x + c, with a constant c for each element of the batch.

    Returns:
        One channel for each element of the batch, shape (...).

    Raises:
        ShapeError: If samples are not finite, or the shapes do not fit.
        InputError: If there are too few samples to tell noise from signal, or a signal x is silent (with `offset`:
            does not change).
    """
    y, x = _samples(received, "received"), _samples(sent, "sent")
    try:
        x = np.broadcast_to(x, y.shape)
    except ValueError as error:
        message = f"sent: shape {x.shape} does not fit the received samples, {y.shape}"
        raise ShapeError(message, name="sent", got=x.shape, expected=y.shape) from error
    unknowns = 1 + offset
    if y.shape[-1] <= unknowns:
        message = f"{y.shape[-1]} samples give no channel with its noise, {unknowns + 1} do"
        raise InputError(message, samples=y.shape[-1], needed=unknowns + 1)
    total = (np.abs(x) ** 2).sum(axis=-1)
    if offset:
        y, x = _without_mean(y), _without_mean(x)
    energy = (np.abs(x) ** 2).sum(axis=-1)
    _require_signal(energy, total)
    h = (y * x.conj()).sum(axis=-1) / energy
    noise = (np.abs(y - h[..., None] * x) ** 2).sum(axis=-1) / (y.shape[-1] - unknowns)
    scale = np.ones_like(energy) if normalised else energy
    return ChannelEstimate(h * scale, noise, np.sqrt(noise / energy) * scale)


def _samples(values: npt.ArrayLike, name: str) -> ComplexArray:
    shape = np.shape(values)
    if not shape:
        raise ShapeError(f"{name}: a single number is no signal", name=name, got=shape)
    return read_only(values, name, shape, np.complex128)


def _without_mean(signal: ComplexArray) -> ComplexArray:
    return np.asarray(signal - signal.mean(axis=-1, keepdims=True))


def _require_signal(energy: FloatArray, total: FloatArray) -> None:
    silent = energy <= SILENT * total
    if silent.any():
        where = np.argwhere(silent)[0].tolist()
        message = f"{int(silent.sum())} of {silent.size} signals are silent or do not change, the first at {where}"
        raise InputError(message, silent=int(silent.sum()), first=where)
