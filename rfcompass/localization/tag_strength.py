"""How strong a tag is: what its received level says about its distance, once tags are compared with each other.

In free space the amplitude of the channel falls with the product of the two ways (radar equation),

    |h(m)| = A / (d_tx(m) d_rx(m)),        S(p) = 20 log10 mean_m( |h(m)| d_tx(m, p) d_rx(m, p) )   [dB],

so that S(p) is the strength A of the tag if it is at p. Nobody knows A: it holds the reader's power, the antennas and
the tag. But reader and antennas are the same for all tags of a scan, and tags of one kind differ by a decibel or two:
a place that makes one tag much stronger or weaker than the others is not likely. The mean is one of amplitudes, since
a fade takes many decibels from a few positions but little from the mean.
"""

from dataclasses import dataclass

import numpy as np

from rfcompass.arrays import FloatArray
from rfcompass.types.reads import ReadTrace

_DB = 20.0 / np.log(10.0)


@dataclass(frozen=True)
class TagStrength:
    """Strength of one tag as a function of its place; make it with `tag_strength`.

    Attributes:
        level: Sum of |h| over the channels of each position, shape (M,).
        cells: Number of cells that were heard.
        rx_m: Receiving antenna at each position [m], shape (M, 3).
        tx_m: Transmitting antenna at each position [m], shape (M, 3).
    """

    level: FloatArray
    cells: int
    rx_m: FloatArray
    tx_m: FloatArray

    def at(self, point_m: FloatArray) -> float:
        """S at a point [dB]; `point_m` has shape (3,)."""
        return float(_DB * np.log(np.sum(self.level * self._ways(point_m)) / self.cells))

    def gradient(self, point_m: FloatArray) -> FloatArray:
        """Derivative of S with respect to x, y, z [dB/m], shape (3,)."""
        rx, tx = point_m - self.rx_m, point_m - self.tx_m
        d_rx, d_tx = _length(rx), _length(tx)
        slopes = d_tx / d_rx * rx + d_rx / d_tx * tx
        return np.asarray(_DB * (self.level @ slopes) / np.sum(self.level * self._ways(point_m)))

    def _ways(self, point_m: FloatArray) -> FloatArray:
        return np.asarray((_length(point_m - self.rx_m) * _length(point_m - self.tx_m))[:, 0])


def tag_strength(trace: ReadTrace) -> TagStrength:
    """Collect what a trace says about the strength of its tag."""
    rx_m = trace.antenna_positions_m
    tx_m = rx_m if trace.tx_positions_m is None else trace.tx_positions_m
    return TagStrength(np.abs(trace.channel).sum(axis=1), int(trace.mask.sum()), rx_m, tx_m)


def _length(vectors: FloatArray) -> FloatArray:
    return np.asarray(np.maximum(np.linalg.norm(vectors, axis=1, keepdims=True), 1e-9))
