"""Antennas of readers: gain, pattern and polarisation.

Antenna frame: boresight along +x; the axis of linear polarisation is z. An antenna is a complex vector p and a scalar
pattern g: in the unit direction d it radiates the field

    e(d) = g(d · x) [p - (p · d) d],

the part of p across the ray. For a dipole along z this is its sin θ pattern; for a patch p = z, or (y ± j z) / √2 when
circular (with exp(+jωt) and waves exp(-jkr); `rhcp` has the minus sign). By reciprocity e is also what it receives.
"""

from dataclasses import dataclass

import numpy as np

from rfcompass.arrays import ComplexArray, FloatArray, IntArray
from rfcompass.errors import InputError
from rfcompass.types.record import Record

PATTERNS = ("isotropic", "dipole", "patch")
POLARISATIONS = ("linear", "rhcp", "lhcp", "dual")

_Z = np.array([0.0, 0.0, 1.0])
_Y = np.array([0.0, 1.0, 0.0])


@dataclass(frozen=True, slots=True, kw_only=True)
class AntennaModel(Record):
    """One antenna type.

    Attributes:
        gain_dbi: Gain at boresight (dipole: across its axis), over an isotropic antenna of the same polarisation [dB].
        pattern: `"isotropic"`: equal in all directions, only the polarisation turns; `"dipole"`: sin θ about the
            polarisation axis; `"patch"`: falls from boresight as ((1 + cos θ) / 2)ⁿ, with n from `beamwidth_rad`.
        polarisation: `"linear"`, `"rhcp"`, `"lhcp"`, or `"dual"`: two linear feeds, z at odd ports and y at even ones.
        cross_polar: Field of the orthogonal polarisation that leaks in, relative to the wanted one.
        beamwidth_rad: Full width of a patch's beam at half power [rad].
        front_to_back_db: How far a patch's field behind it stays below that in front [dB].
    """

    gain_dbi: float = 0.0
    pattern: str = "isotropic"
    polarisation: str = "linear"
    cross_polar: float = 0.0
    beamwidth_rad: float = float(np.radians(65.0))
    front_to_back_db: float = 20.0

    def __post_init__(self) -> None:
        """Check names and numbers."""
        for key, known in (("pattern", PATTERNS), ("polarisation", POLARISATIONS)):
            if (value := getattr(self, key)) not in known:
                raise InputError(f"AntennaModel.{key}: {value!r} is none of {', '.join(known)}", key=key, got=value)
        for key in ("gain_dbi", "front_to_back_db"):
            if not np.isfinite(value := getattr(self, key)):
                raise InputError(f"AntennaModel.{key}: {value} is not finite", key=key, got=value)
        if not 0 <= self.cross_polar <= 1:
            raise InputError(f"AntennaModel.cross_polar: {self.cross_polar} is not in [0, 1]", key="cross_polar")
        if not 0 < self.beamwidth_rad <= np.pi:
            raise InputError(f"AntennaModel.beamwidth_rad: {self.beamwidth_rad} is not in (0, pi]", key="beamwidth_rad")

    @property
    def exponent(self) -> float:
        """Exponent n of a patch's field pattern: half the power at half the beamwidth."""
        return float(np.log(0.5) / (2.0 * np.log((1.0 + np.cos(self.beamwidth_rad / 2.0)) / 2.0)))

    @property
    def back_field(self) -> float:
        """Field behind a patch, relative to boresight."""
        return float(10.0 ** (-self.front_to_back_db / 20.0))

    def vectors(self, ports: IntArray) -> ComplexArray:
        """Polarisation p in the antenna frame for each port, unit length before the leak is added, shape (M, 3).

        Args:
            ports: Reader port of each antenna position, from 1; only a dual antenna tells them apart, shape (M,).
        """
        turn = {"rhcp": -1j, "lhcp": 1j}
        if self.polarisation in turn:
            wanted = (_Y + turn[self.polarisation] * _Z) / np.sqrt(2.0)
            return np.tile(wanted + self.cross_polar * wanted.conj(), (len(ports), 1))
        leak = self.cross_polar
        z, y = (_Z + leak * _Y).astype(np.complex128), (_Y + leak * _Z).astype(np.complex128)
        even = (ports % 2 == 0) & (self.polarisation == "dual")
        return np.where(even[:, None], y, z)


def look_along(direction: FloatArray) -> FloatArray:
    """Rotation of an antenna whose boresight points along `direction`, its z axis as upright as it can be.

    Straight up or down, z points along the scene's x.

    Args:
        direction: Any length but zero, scene frame, shape (3,).

    Returns:
        R_scene_antenna, shape (3, 3).
    """
    length = np.linalg.norm(direction)
    if not (np.isfinite(length) and length > 0):
        raise InputError(f"an antenna cannot look along {np.asarray(direction).tolist()}", got=direction)
    x = np.asarray(direction, dtype=np.float64) / length
    up = _Z if abs(x[2]) < 1.0 - 1e-9 else np.array([1.0, 0.0, 0.0])
    z = up - (up @ x) * x
    z /= np.linalg.norm(z)
    return np.column_stack([x, np.cross(z, x), z])


# Vertical whip of the paper's receiver: 1.28 as in a conservative half-wave dipole; leak 0.05. Ours.
VERT900 = AntennaModel(gain_dbi=1.07, pattern="dipole", cross_polar=0.05)
# Circular panel as sold for fixed readers: 9 dBic, 65 deg, axial ratio about 1 dB (leak 0.06). Typical values; ours.
PATCH_CIRCULAR = AntennaModel(gain_dbi=9.0, pattern="patch", polarisation="rhcp", cross_polar=0.06)
# Linear panel: 9 dBi, 65 deg. Ours.
PATCH_LINEAR = AntennaModel(gain_dbi=9.0, pattern="patch", cross_polar=0.05)
# Panel with two linear feeds, read in turn through two ports. Ours.
PATCH_DUAL = AntennaModel(gain_dbi=9.0, pattern="patch", polarisation="dual", cross_polar=0.05)
# Log-periodic card of FuseBot's wrist: about 6 dBi and 80 deg from 500 MHz to 1 GHz. Ours.
LOG_PERIODIC = AntennaModel(
    gain_dbi=6.0, pattern="patch", cross_polar=0.05, beamwidth_rad=float(np.radians(80.0)), front_to_back_db=15.0
)
