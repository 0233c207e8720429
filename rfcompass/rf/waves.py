"""Wave constants and the response of a tag in free space."""

import numpy as np
import numpy.typing as npt

from rfcompass.arrays import ComplexArray, FloatArray

SPEED_OF_LIGHT_M_S = 299_792_458.0


def wavelength(frequency_hz: npt.ArrayLike) -> FloatArray:
    """Wavelength λ = c / f [m], same shape as `frequency_hz`."""
    return np.asarray(SPEED_OF_LIGHT_M_S / np.asarray(frequency_hz, dtype=np.float64))


def wavenumber(frequency_hz: npt.ArrayLike) -> FloatArray:
    """Phase per metre of path, k = 2π f / c [rad/m], same shape as `frequency_hz`."""
    return np.asarray(2.0 * np.pi * np.asarray(frequency_hz, dtype=np.float64) / SPEED_OF_LIGHT_M_S)


def free_space_channel(
    point_m: FloatArray,
    antenna_positions_m: FloatArray,
    frequencies_hz: FloatArray,
    *,
    tx_positions_m: FloatArray | None = None,
    spreading: bool = True,
) -> ComplexArray:
    """Channel of a tag in free space [Boroushaki2023], Eq. 1.

    h(f, m) = a(m) · exp(-j 2π f d(m) / c),   d = r_tx + r_rx (monostatic: 2 r),   a = 1 / (r_tx r_rx).

    Args:
        point_m: Tag in the frame of the antenna path [m], shape (3,).
        antenna_positions_m: Receiving antenna [m], shape (M, 3).
        frequencies_hz: Carrier frequencies [Hz], shape (F,).
        tx_positions_m: Transmitting antenna of a bistatic rig [m], shape (M, 3); None when monostatic.
        spreading: Let the amplitude fall with distance, 1 at one metre; otherwise a = 1.

    Returns:
        h, shape (M, F).
    """
    r_rx = np.linalg.norm(antenna_positions_m - point_m, axis=1)
    r_tx = r_rx if tx_positions_m is None else np.linalg.norm(tx_positions_m - point_m, axis=1)
    amplitude = 1.0 / (r_tx * r_rx) if spreading else np.ones_like(r_rx)
    return np.asarray(amplitude[:, None] * np.exp(-1j * np.outer(r_tx + r_rx, wavenumber(frequencies_hz))))
