"""`antenna_poses.csv`: where each antenna was."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from types import MappingProxyType

import numpy as np

from rfcompass.arrays import FloatArray, IntArray, read_only
from rfcompass.errors import ShapeError
from rfcompass.recordings.defects import defect, first_row
from rfcompass.recordings.text_table import TextTable, as_csv

POSES_FILE = "antenna_poses.csv"

_POSITION = ("x_m", "y_m", "z_m")
_QUATERNION = ("qx", "qy", "qz", "qw")
_KNOWN = ("pose_id", "antenna", *_POSITION, *_QUATERNION)


@dataclass(frozen=True, slots=True)
class AntennaPoses:
    """Poses of the reader's antennas in the trace's frame, ordered by pose_id, then antenna.

    Attributes:
        pose_ids: Number of the pose, shape (P,).
        antennas: Reader port, shape (P,).
        positions_m: Phase centre of the antenna [m], shape (P, 3).
        quaternions_xyzw: Orientation, not normalised, shape (P, 4).
        unknown: Text of columns that this version does not know, kept for rewriting.

    Raises:
        TraceError: If a value is not finite, a quaternion is zero or a (pose_id, antenna) stands twice; `row` counts
            the rows as they were handed in.
    """

    pose_ids: IntArray
    antennas: IntArray
    positions_m: FloatArray
    quaternions_xyzw: FloatArray
    unknown: Mapping[str, Sequence[str]] = field(default_factory=dict)

    def __post_init__(self) -> None:
        """Check, bring into order and freeze."""
        P = np.size(self.pose_ids)
        pose_ids, antennas = (self._read(name, (P,), np.int64) for name in ("pose_ids", "antennas"))
        positions_m, quaternions = self._read("positions_m", (P, 3)), self._read("quaternions_xyzw", (P, 4))
        order = np.lexsort((antennas, pose_ids))
        _check_distinct(pose_ids[order], antennas[order], order)
        if (row := first_row(np.abs(quaternions).max(axis=1, initial=0.0) < 1e-9)) is not None:
            raise defect(POSES_FILE, "the quaternion is zero", column="qw", row=row)
        unknown = {name: tuple(cells[i] for i in order) for name, cells in self.unknown.items()}
        for name, value in (
            ("pose_ids", pose_ids),
            ("antennas", antennas),
            ("positions_m", positions_m),
            ("quaternions_xyzw", quaternions),
        ):
            object.__setattr__(self, name, read_only(value[order], name, value.shape, value.dtype))
        object.__setattr__(self, "unknown", MappingProxyType(unknown))

    @classmethod
    def along(cls, positions_m: FloatArray, antenna: int = 1) -> "AntennaPoses":
        """Make the poses 0, 1, … of one antenna that keeps its orientation, from its positions [m], shape (P, 3)."""
        P = len(positions_m)
        identity = np.tile([0.0, 0.0, 0.0, 1.0], (P, 1))
        return cls(np.arange(P), np.full(P, antenna, dtype=np.int64), positions_m, identity)

    def _read(
        self, name: str, shape: tuple[int, ...], dtype: type = np.float64
    ) -> np.ndarray[tuple[int, ...], np.dtype]:
        try:
            return read_only(getattr(self, name), name, shape, dtype)
        except ShapeError as error:
            raise defect(POSES_FILE, error.message) from error

    def __reduce__(self) -> tuple[object, ...]:
        """Rebuild through the constructor: a mapping proxy cannot be pickled."""
        fields = (self.pose_ids, self.antennas, self.positions_m, self.quaternions_xyzw, dict(self.unknown))
        return AntennaPoses, fields

    def rows_of(self, pose_ids: IntArray, antennas: IntArray) -> IntArray:
        """Row of each (pose_id, antenna) in this record, -1 where there is none; all of shape (R,)."""
        if not self.pose_ids.size:
            return np.full(pose_ids.shape, -1)
        known_poses, known_antennas = np.unique(self.pose_ids), np.unique(self.antennas)
        pose_index, antenna_index = _index_in(known_poses, pose_ids), _index_in(known_antennas, antennas)
        row_of = np.full((known_poses.size + 1, known_antennas.size + 1), -1)
        row_of[_index_in(known_poses, self.pose_ids), _index_in(known_antennas, self.antennas)] = np.arange(
            self.pose_ids.size
        )
        return np.asarray(row_of[pose_index, antenna_index])


def _check_distinct(pose_ids: IntArray, antennas: IntArray, row_of: IntArray) -> None:
    repeated = (np.diff(pose_ids) == 0) & (np.diff(antennas) == 0)
    if (i := first_row(repeated)) is not None:
        pose_id, antenna, row = int(pose_ids[i]), int(antennas[i]), int(row_of[i + 1])
        message = f"pose {pose_id} of antenna {antenna} stands twice (also in row {row_of[i]})"
        raise defect(POSES_FILE, message, column="pose_id", row=row, pose_id=pose_id, antenna=antenna)


def _index_in(known: IntArray, values: IntArray) -> IntArray:
    """Index of each value in the ascending `known`; its size where the value is not among them."""
    index = np.searchsorted(known, values)
    found = known[np.minimum(index, known.size - 1)] == values
    return np.where(found, index, known.size)


def parse_poses(table: TextTable) -> AntennaPoses:
    """Read the rows of an `antenna_poses.csv`.

    Raises:
        TraceError: If a column is missing or ill-typed, or a pose is not possible.
    """
    return AntennaPoses(
        pose_ids=table.integers("pose_id"),
        antennas=table.integers("antenna"),
        positions_m=np.stack([table.floats(name) for name in _POSITION], axis=1),
        quaternions_xyzw=np.stack([table.floats(name) for name in _QUATERNION], axis=1),
        unknown={name: cells for name, cells in table.columns.items() if name not in _KNOWN},
    )


def poses_csv(poses: AntennaPoses) -> bytes:
    """Write an `antenna_poses.csv`; equal records give equal bytes."""
    numbers = np.concatenate([poses.positions_m, poses.quaternions_xyzw], axis=1).T.tolist()
    ids = {"pose_id": poses.pose_ids.tolist(), "antenna": poses.antennas.tolist()}
    return as_csv({**ids, **dict(zip((*_POSITION, *_QUATERNION), numbers, strict=True)), **poses.unknown})
