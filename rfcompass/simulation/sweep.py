"""A tagged table seen by one moving antenna, with one reflecting wall and a noisy reader.

The smallest world that still contains what a surveyor does not model: a mirror image of every tag, an
unknown phase constant of each tag, phase noise and missed reads. The room of the papers comes with the
physical channel; this one is for first steps and for tests.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from rfcompass.arrays import ComplexArray, FloatArray, read_only
from rfcompass.rf.waves import SPEED_OF_LIGHT_M_S
from rfcompass.types.reads import TagRead
from rfcompass.types.record import Record, frozen_mapping


@dataclass(frozen=True, slots=True, kw_only=True)
class SweepScene(Record):
    """Where tags and antenna are, and how bad the air and the reader are. This record is truth.

    Attributes:
        tags_m: Position of each tag [m], by EPC, shape (3,) each.
        antenna_positions_m: Antenna at each pose [m], shape (M, 3).
        frequencies_hz: Carriers that the reader hops through [Hz], shape (F,).
        wall_y_m: The wall is the plane y = wall_y_m [m].
        reflection: Field reflection coefficient of the wall, between -1 and 1; 0 for free space.
        phase_noise_rad: Standard deviation of the phase of a single read [rad].
        read_probability: Chance that a tag answers at a pose and frequency.
    """

    tags_m: Mapping[str, FloatArray]
    antenna_positions_m: FloatArray
    frequencies_hz: FloatArray
    wall_y_m: float = 2.0
    reflection: float = -0.3
    phase_noise_rad: float = 0.1
    read_probability: float = 0.95

    def __post_init__(self) -> None:
        """Freeze the arrays."""
        set_ = object.__setattr__
        tags_m = {epc: read_only(point, f"SweepScene.tags_m[{epc}]", (3,)) for epc, point in self.tags_m.items()}
        set_(self, "tags_m", frozen_mapping(tags_m))
        positions = read_only(self.antenna_positions_m, "SweepScene.antenna_positions_m", (None, 3))
        set_(self, "antenna_positions_m", positions)
        set_(self, "frequencies_hz", read_only(self.frequencies_hz, "SweepScene.frequencies_hz", (None,)))


def simulate_sweep(scene: SweepScene, rng: np.random.Generator) -> tuple[TagRead, ...]:
    """Read every tag at every pose and frequency, as a monostatic reader with phase_sign = +1 reports it.

    The channel is the square of the one-way field, direct path plus mirror image:
    h = (e^{-jkr}/r + Γ e^{-jkr'}/r')². The reader reports phase = -arg h + constant(tag) + noise.

    Args:
        scene: The world; truth.
        rng: Source of phase constants, noise and missed reads.

    Returns:
        Reads in order of pose, then tag, then frequency.
    """
    mirror = np.array([1.0, -1.0, 1.0])
    points_m = np.array(list(scene.tags_m.values())).reshape(-1, 3)
    direct = _one_way(scene, points_m)
    image = _one_way(scene, points_m * mirror + np.array([0.0, 2.0 * scene.wall_y_m, 0.0]))
    h = (direct + scene.reflection * image) ** 2
    constant = rng.uniform(0.0, 2.0 * np.pi, (1, len(points_m), 1))
    phase_rad = (-np.angle(h) + constant + rng.normal(0.0, scene.phase_noise_rad, h.shape)) % (2.0 * np.pi)
    rssi_dbm = -45.0 + 20.0 * np.log10(np.abs(h))  # ours: -45 dBm at 1 m, about what a desk reader shows
    heard = rng.random(h.shape) < scene.read_probability
    epcs = tuple(scene.tags_m)
    return tuple(
        TagRead(
            epc=epcs[t],
            antenna=1,
            freq_hz=float(scene.frequencies_hz[f]),
            rssi_dbm=float(rssi_dbm[m, t, f]),
            phase_rad=float(phase_rad[m, t, f]),
            pose_id=int(m),
        )
        for m, t, f in np.argwhere(heard)
    )


def _one_way(scene: SweepScene, points_m: FloatArray) -> ComplexArray:
    """Field e^{-jkr}/r from each antenna position to each point at each frequency, shape (M, T, F)."""
    r = np.linalg.norm(scene.antenna_positions_m[:, None, :] - points_m[None, :, :], axis=2)[:, :, None]
    k = 2.0 * np.pi * scene.frequencies_hz / SPEED_OF_LIGHT_M_S
    return np.asarray(np.exp(-1j * k * r) / r)
