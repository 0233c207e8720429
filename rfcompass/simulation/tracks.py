"""Where the moving antenna goes."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
import numpy.typing as npt

from rfcompass.arrays import FloatArray, IntArray, read_only
from rfcompass.errors import InputError, ShapeError
from rfcompass.simulation.antennas import look_along
from rfcompass.types.record import Record


@dataclass(frozen=True, slots=True)
class AntennaTrack(Record):
    """Poses of one antenna along its way.

    Attributes:
        positions_m: Phase centre in the scene [m], shape (M, 3).
        rotations: R_scene_antenna, boresight = first column, shape (M, 3, 3).
        ports: Reader port at each position, from 1, shape (M,).
    """

    positions_m: FloatArray
    rotations: FloatArray
    ports: IntArray

    def __post_init__(self) -> None:
        """Freeze the arrays; check that they belong together and that rotations rotate."""
        M, set_ = len(self.positions_m), object.__setattr__
        set_(self, "positions_m", read_only(self.positions_m, "AntennaTrack.positions_m", (M, 3)))
        set_(self, "rotations", read_only(self.rotations, "AntennaTrack.rotations", (M, 3, 3)))
        set_(self, "ports", read_only(self.ports, "AntennaTrack.ports", (M,), np.int64))
        turned = np.einsum("mij,mik->mjk", self.rotations, self.rotations)
        if M and np.abs(turned - np.eye(3)).max() > 1e-6:
            raise ShapeError("AntennaTrack.rotations: one of them is no rotation", name="rotations")
        if (self.ports < 1).any():
            raise ShapeError("AntennaTrack.ports: ports count from 1", name="ports")

    def __len__(self) -> int:
        return len(self.positions_m)

    @classmethod
    def at(cls, positions_m: FloatArray, *, facing_m: npt.ArrayLike | None = None, port: int = 1) -> "AntennaTrack":
        """Make a track of given positions.

        Args:
            positions_m: Positions in the scene [m], shape (M, 3).
            facing_m: Point that the boresight always points at [m], shape (3,); along the scene's x if left out.
            port: Reader port throughout.
        """
        M = len(positions_m)
        if facing_m is None:
            rotations = np.tile(np.eye(3), (M, 1, 1))
        else:
            rotations = np.array([look_along(np.asarray(facing_m) - point) for point in positions_m]).reshape(M, 3, 3)
        return cls(positions_m, rotations, np.full(M, port))

    @classmethod
    def line(
        cls,
        start_m: npt.ArrayLike,
        end_m: npt.ArrayLike,
        spacing_m: float = 0.04,
        *,
        facing_m: npt.ArrayLike | None = None,
        port: int = 1,
    ) -> "AntennaTrack":
        """Go straight from start to end, both included, at most `spacing_m` apart [m]; see `at` for the rest."""
        return cls.polyline(np.stack([start_m, end_m]), spacing_m, facing_m=facing_m, port=port)

    @classmethod
    def polyline(
        cls,
        corners_m: npt.ArrayLike,
        spacing_m: float = 0.04,
        *,
        facing_m: npt.ArrayLike | None = None,
        port: int = 1,
    ) -> "AntennaTrack":
        """Go from corner to corner, each met once, at most `spacing_m` apart [m]; one port throughout.

        An L is a polyline of three corners, shape (3, 3) [m]. See `at` for the other arguments.
        """
        corners = read_only(np.array(corners_m, dtype=np.float64), "AntennaTrack.polyline", (None, 3))
        if len(corners) < 2 or not (np.isfinite(spacing_m) and spacing_m > 0):
            raise InputError(f"a track needs two corners and a spacing above 0, got {len(corners)} and {spacing_m} m")
        legs = [_leg(start, end, spacing_m) for start, end in pairwise(corners)]
        return cls.at(np.concatenate([*legs, corners[-1:]]), facing_m=facing_m, port=port)

    @classmethod
    def square(
        cls,
        centre_m: npt.ArrayLike,
        side_m: float,
        height_m: float,
        spacing_m: float = 0.04,
        *,
        facing_m: npt.ArrayLike | None = None,
    ) -> "AntennaTrack":
        """Go once round a level square, as FuseBot's wrist does; looks straight down unless `facing_m` is given.

        Args:
            centre_m: Centre of the square, x and y [m], shape (2,).
            side_m: Edge [m].
            height_m: Height above the floor [m].
            spacing_m: Largest distance between neighbours [m].
            facing_m: Point that the boresight always points at [m], shape (3,).
        """
        x, y = np.asarray(centre_m, dtype=np.float64)[:2]
        ring = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1], [-1, -1]]) * side_m / 2 + [x, y]
        track = cls.polyline(np.column_stack([ring, np.full(5, height_m)]), spacing_m, facing_m=facing_m)
        open_ring = cls(track.positions_m[:-1], track.rotations[:-1], track.ports[:-1])
        if facing_m is not None:
            return open_ring
        down = np.tile(look_along(np.array([0.0, 0.0, -1.0])), (len(open_ring), 1, 1))
        return replace(open_ring, rotations=down)

    def then(self, other: "AntennaTrack") -> "AntennaTrack":
        """Go on with another track."""
        names = ("positions_m", "rotations", "ports")
        return AntennaTrack(*(np.concatenate([getattr(self, name), getattr(other, name)]) for name in names))

    def through_ports(self, ports: Sequence[int]) -> "AntennaTrack":
        """Read through each of several ports in turn at every position, such as the two feeds of a dual antenna."""
        n, M = len(ports), len(self)
        repeated = (np.repeat(self.positions_m, n, axis=0), np.repeat(self.rotations, n, axis=0))
        return AntennaTrack(*repeated, np.tile(np.asarray(ports, dtype=np.int64), M))

    def perturbed(
        self,
        rng: np.random.Generator,
        *,
        walk_m_per_step: float = 0.0,
        jitter_m: float = 0.0,
        offset_m: float = 0.0,
        turn_rad: float = 0.0,
        turn_about_m: npt.ArrayLike | None = None,
    ) -> "AntennaTrack":
        """Return where the antenna truly went when its carrier believes in this track.

        Args:
            rng: Source of all errors.
            walk_m_per_step: Standard deviation of a random walk's step along each axis, in the plane [m].
            jitter_m: Standard deviation of an independent error of each position along each axis [m].
            offset_m: Standard deviation of a shift of the whole track along x and y [m].
            turn_rad: Standard deviation of a turn of the whole track about z [rad].
            turn_about_m: Point to turn about [m], shape (3,); the first position if left out.
        """
        M = len(self)
        walk = np.cumsum(rng.normal(0.0, 1.0, (M, 2)), axis=0) * walk_m_per_step
        moved = self.positions_m + rng.normal(0.0, 1.0, (M, 3)) * jitter_m
        moved[:, :2] += walk + rng.normal(0.0, 1.0, 2) * offset_m
        angle = rng.normal() * turn_rad
        R = np.array([[np.cos(angle), -np.sin(angle), 0], [np.sin(angle), np.cos(angle), 0], [0, 0, 1.0]])
        centre = self.positions_m[0] if turn_about_m is None else np.asarray(turn_about_m, dtype=np.float64)
        return AntennaTrack((moved - centre) @ R.T + centre, R @ self.rotations, self.ports)


def _leg(start_m: FloatArray, end_m: FloatArray, spacing_m: float) -> FloatArray:
    """Equally spaced points from start on, without the end."""
    steps = max(int(np.ceil(np.linalg.norm(end_m - start_m) / spacing_m - 1e-9)), 1)
    return np.asarray(start_m + np.arange(steps)[:, None] / steps * (end_m - start_m))
