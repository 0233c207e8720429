"""Where the antennas were while a reader read: fixed to a wall, or on a carrier that logs its path.

A reader knows ports, not places. A `Carriage` gives each read the number of an antenna pose, and knows these poses.
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from types import MappingProxyType
from typing import Protocol

import numpy as np

from rfcompass.arrays import BoolArray, FloatArray, IntArray
from rfcompass.errors import TraceError
from rfcompass.recordings.antenna_poses import AntennaPoses, parse_poses
from rfcompass.recordings.text_table import TextTable, read_text_table
from rfcompass.types.record import Record, frozen_mapping

# Reads within ±2.5 mm of the path share a pose: λ / 130 at 920 MHz, less than any method resolves (ours).
POSE_SPACING_M = 0.005

_IDENTITY = (0.0, 0.0, 0.0, 1.0)
_POSITION, _QUATERNION = ("x_m", "y_m", "z_m"), ("qx", "qy", "qz", "qw")


class Carriage(Protocol):
    """Knows where the antennas were."""

    def pose_ids(self, antennas: IntArray, t_ns: IntArray, known_time: BoolArray) -> IntArray:
        """Number of the pose of each read, -1 where the place is unknown, all of shape (R,).

        Args:
            antennas: Port of each read.
            t_ns: Host time of each read, UTC [ns].
            known_time: False where a read has no host time.
        """
        ...

    def poses(self, pairs: Iterable[tuple[int, int]]) -> AntennaPoses:
        """Poses of the given pairs (pose_id, antenna)."""
        ...


@dataclass(frozen=True, slots=True)
class StillAntennas(Record):
    """Antennas that do not move: pose 0 for each port.

    Attributes:
        positions_m: Phase centre by port [m], shape (3,) each. A port that is not listed has no place; if none is
            listed, nothing is known, and all are put at the origin.
        quaternions_xyzw: Orientation by port, shape (4,) each; the identity if not listed.
    """

    positions_m: Mapping[int, FloatArray] = field(default_factory=dict)
    quaternions_xyzw: Mapping[int, FloatArray] = field(default_factory=dict)

    def __post_init__(self) -> None:
        """Freeze the mappings."""
        object.__setattr__(self, "positions_m", frozen_mapping(self.positions_m))
        object.__setattr__(self, "quaternions_xyzw", frozen_mapping(self.quaternions_xyzw))

    @classmethod
    def of(cls, poses: AntennaPoses) -> "StillAntennas":
        """Take one pose for each port.

        Raises:
            TraceError: If a port has several, or there is none.
        """
        ports = poses.antennas.tolist()
        if not ports:
            raise TraceError("no antenna has a pose", poses=0)
        for port in ports:
            if ports.count(port) > 1:
                message = f"antenna {port} has {ports.count(port)} poses; antennas that move need a carrier log"
                raise TraceError(message, antenna=port, poses=ports.count(port))
        return cls(
            dict(zip(ports, poses.positions_m, strict=True)), dict(zip(ports, poses.quaternions_xyzw, strict=True))
        )

    @classmethod
    def read(cls, path: str | Path) -> "StillAntennas":
        """Read an `antenna_poses.csv` with one row for each port.

        Raises:
            TraceError: If the file is damaged, or a port has several poses.
        """
        return cls.of(parse_poses(read_text_table(Path(path))))

    def pose_ids(self, antennas: IntArray, t_ns: IntArray, known_time: BoolArray) -> IntArray:  # noqa: ARG002
        """Pose 0, whenever it was, for the ports that have a place."""
        if not self.positions_m:
            return np.zeros(antennas.shape, dtype=np.int64)
        return np.where(np.isin(antennas, list(self.positions_m)), 0, -1)

    def poses(self, pairs: Iterable[tuple[int, int]]) -> AntennaPoses:
        """The pose of each port that is named."""
        known = sorted(set(pairs))
        positions_m = self.positions_m or {port: np.zeros(3) for _, port in known}
        return AntennaPoses(
            pose_ids=np.array([pose_id for pose_id, _ in known], dtype=np.int64),
            antennas=np.array([port for _, port in known], dtype=np.int64),
            positions_m=np.array([positions_m[port] for _, port in known]).reshape(-1, 3),
            quaternions_xyzw=np.array(
                [self.quaternions_xyzw.get(port, np.array(_IDENTITY)) for _, port in known]
            ).reshape(-1, 4),
        )


@dataclass(frozen=True, slots=True, eq=False)
class _Path:
    """Log of one antenna: time since the first row [s], place and orientation, travelled length s [m], shape (L,)."""

    start_ns: int
    t_s: FloatArray
    positions_m: FloatArray
    quaternions_xyzw: FloatArray
    s_m: FloatArray

    def pose_ids(self, t_ns: IntArray) -> IntArray:
        t_s = (t_ns - self.start_ns) / 1e9
        inside = (t_s >= 0.0) & (t_s <= self.t_s[-1])
        s_m = np.interp(t_s, self.t_s, self.s_m)
        return np.where(inside, np.rint(s_m / POSE_SPACING_M).astype(np.int64), -1)

    def pose(self, pose_id: int) -> tuple[FloatArray, FloatArray]:
        s_m = min(pose_id * POSE_SPACING_M, float(self.s_m[-1]))
        position_m = np.array([np.interp(s_m, self.s_m, axis) for axis in self.positions_m.T])
        row = min(int(np.searchsorted(self.s_m, s_m)), self.s_m.size - 1)
        return position_m, self.quaternions_xyzw[row]


@dataclass(frozen=True, slots=True, eq=False)
class CarrierLog:
    """Antennas on a carrier that logs where it is, at host time.

    The place between two rows of the log is interpolated linearly. Poses lie every 5 mm along the travelled path, and
    a read belongs to the nearest one; while the carrier stands still, all reads share a pose. Reads before the first
    row and after the last have no place. The orientation of a pose is that of the next row; a turn on the spot is not
    seen.

    Attributes:
        paths: Log by port.
    """

    paths: Mapping[int, _Path]

    @classmethod
    def read(cls, path: str | Path) -> "CarrierLog":
        """Read a CSV with the columns t_ns, antenna, x_m, y_m, z_m, and optionally qx, qy, qz, qw.

        Raises:
            TraceError: If it is damaged or the time does not increase; names `column` and `row`.
        """
        file = Path(path)
        table = read_text_table(file)
        t_ns, antennas = table.integers("t_ns"), table.integers("antenna")
        positions_m = np.stack([table.floats(name) for name in _POSITION], axis=1)
        quaternions = _quaternions(table)
        paths = {}
        for port in np.unique(antennas).tolist():
            rows = np.flatnonzero(antennas == port)
            _check_times(file.name, t_ns[rows], rows)
            paths[port] = _path(t_ns[rows], positions_m[rows], quaternions[rows])
        if not paths:
            raise TraceError(f"{file.name}: holds no row", file=file.name)
        return cls(MappingProxyType(paths))

    def pose_ids(self, antennas: IntArray, t_ns: IntArray, known_time: BoolArray) -> IntArray:
        """Number of the nearest pose along the path of each read's port."""
        pose_ids = np.full(antennas.shape, -1)
        for port, path in self.paths.items():
            of_port = (antennas == port) & known_time
            pose_ids[of_port] = path.pose_ids(t_ns[of_port])
        return pose_ids

    def poses(self, pairs: Iterable[tuple[int, int]]) -> AntennaPoses:
        """Poses along the paths."""
        known = sorted(set(pairs))
        found = [self.paths[port].pose(pose_id) for pose_id, port in known]
        return AntennaPoses(
            pose_ids=np.array([pose_id for pose_id, _ in known], dtype=np.int64),
            antennas=np.array([port for _, port in known], dtype=np.int64),
            positions_m=np.array([position_m for position_m, _ in found]).reshape(-1, 3),
            quaternions_xyzw=np.array([quaternion for _, quaternion in found]).reshape(-1, 4),
        )


def _quaternions(table: TextTable) -> FloatArray:
    if not any(name in table.columns for name in _QUATERNION):
        return np.tile(_IDENTITY, (table.rows, 1))
    return np.stack([table.floats(name) for name in _QUATERNION], axis=1)


def _check_times(file: str, t_ns: IntArray, rows: IntArray) -> None:
    backwards = np.diff(t_ns) <= 0
    if backwards.any():
        row = int(rows[int(np.argmax(backwards)) + 1])
        message = f"{file}, column t_ns, row {row}: the time does not increase"
        raise TraceError(message, file=file, column="t_ns", row=row)


def _path(t_ns: IntArray, positions_m: FloatArray, quaternions_xyzw: FloatArray) -> _Path:
    steps_m = np.linalg.norm(np.diff(positions_m, axis=0), axis=1)
    s_m = np.concatenate([[0.0], np.cumsum(steps_m)])
    return _Path(int(t_ns[0]), (t_ns - t_ns[0]) / 1e9, positions_m, quaternions_xyzw, s_m)
