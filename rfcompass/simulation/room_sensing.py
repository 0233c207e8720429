"""What a scan brings in a simulated room: ready-made proximities, or reads of a radio."""

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from rfcompass.arrays import FloatArray
from rfcompass.errors import InputError
from rfcompass.geometry.pose2 import Pose2
from rfcompass.simulation.inventory import Inventory
from rfcompass.types.proximity import ProximityMatrix
from rfcompass.types.tags import TagPositions


@dataclass(frozen=True, slots=True)
class RoomState:
    """Where every tag truly is while a scan is made, in the room frame: z counts from the floor. This is truth.

    Attributes:
        T_room_base: Pose of the robot's base.
        anchors: Tags on the robot (N).
        anchor_dipoles: Their electrical axes, unit vectors, shape (N, 3).
        targets: Tags on the part (K).
        target_dipoles: Their electrical axes, unit vectors, shape (K, 3).
    """

    T_room_base: Pose2
    anchors: TagPositions
    anchor_dipoles: FloatArray
    targets: TagPositions
    target_dipoles: FloatArray


@dataclass(frozen=True, slots=True)
class Heard:
    """What one scan brought: one of the two.

    Attributes:
        inventory: Reads of a radio.
        proximity: Ready-made proximities.
    """

    inventory: Inventory | None = None
    proximity: ProximityMatrix | None = None


class RoomSensor(Protocol):
    """Listens to the tags of a room from where they are now."""

    def hear(self, state: RoomState, rng: np.random.Generator) -> Heard:
        """Make one scan."""
        ...


@dataclass(frozen=True, slots=True)
class NoisyDistances:
    """No radio: the proximity of two tags is their distance times a random factor, m = d exp(σ n), n ~ N(0, 1).

    Comparisons go wrong where distances are nearly equal, as they do on a real channel.

    Attributes:
        sigma: Standard deviation of log m (ours); 0.05 makes about 2 % of all comparisons wrong.
        silent: EPCs of broken tags: their m is NaN.
    """

    sigma: float = 0.05
    silent: frozenset[str] = frozenset()

    def __post_init__(self) -> None:
        """Refuse noise that cannot be."""
        if not (np.isfinite(self.sigma) and self.sigma >= 0):
            raise InputError(f"NoisyDistances.sigma: {self.sigma} is not a finite number >= 0", name="sigma")

    def hear(self, state: RoomState, rng: np.random.Generator) -> Heard:
        """Measure every pair; both directions of a pair of anchors agree."""
        anchors, targets = state.anchors, state.targets
        anchor_m = np.triu(self._noisy(anchors.points_m, anchors.points_m, rng), 1)
        anchor_m = anchor_m + anchor_m.T
        np.fill_diagonal(anchor_m, np.nan)
        m = self._noisy(targets.points_m, anchors.points_m, rng)
        m[[epc in self.silent for epc in targets.epcs]] = np.nan
        return Heard(proximity=ProximityMatrix(targets.epcs, anchors.epcs, m, anchor_m, "noisy_distance"))

    def _noisy(self, a_m: FloatArray, b_m: FloatArray, rng: np.random.Generator) -> FloatArray:
        d = np.linalg.norm(a_m[:, None, :] - b_m[None, :, :], axis=2)
        return np.asarray(d * np.exp(rng.normal(0.0, self.sigma, d.shape)))
