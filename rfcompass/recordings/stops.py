"""`stops.csv`: what a robot believed about itself at each stop."""

from dataclasses import dataclass

import numpy as np

from rfcompass.arrays import FloatArray, IntArray, read_only
from rfcompass.errors import InputError
from rfcompass.recordings.defects import defect
from rfcompass.recordings.text_table import TextTable, as_csv
from rfcompass.types.observation import read_covariance

STOPS_FILE = "stops.csv"

_POSE = ("base_x_m", "base_y_m", "base_theta_rad")
_COVARIANCE = ("cov_xx", "cov_xy", "cov_xt", "cov_yy", "cov_yt", "cov_tt")
_UPPER = np.triu_indices(3)


@dataclass(frozen=True, slots=True)
class Stops:
    """Believed base poses and joint values, in the order of the file.

    Attributes:
        stop_ids: Number of the stop, shape (S,).
        base_poses: x [m], y [m], θ [rad] of the base in frame `odom`, as believed, shape (S, 3).
        joint_names: URDF name of each joint (J).
        joints: Joint values [rad or m], shape (S, J).
        covariances: Covariance of (x, y, θ) [m², m rad, rad²], shape (S, 3, 3), or None if none was recorded.

    Raises:
        TraceError: If a value is not finite, a covariance is none, or a stop stands twice.
    """

    stop_ids: IntArray
    base_poses: FloatArray
    joint_names: tuple[str, ...]
    joints: FloatArray
    covariances: FloatArray | None = None

    def __post_init__(self) -> None:
        """Freeze and check."""
        S, set_ = np.size(self.stop_ids), object.__setattr__
        set_(self, "joint_names", tuple(self.joint_names))
        try:
            set_(self, "stop_ids", read_only(self.stop_ids, "stop_ids", (S,), np.int64))
            set_(self, "base_poses", read_only(self.base_poses, "base_poses", (S, 3)))
            set_(self, "joints", read_only(self.joints, "joints", (S, len(self.joint_names))))
            if self.covariances is not None:
                set_(self, "covariances", read_only(self.covariances, "covariances", (S, 3, 3)))
        except InputError as error:
            raise defect(STOPS_FILE, error.message) from error
        self._check_rows()

    def _check_rows(self) -> None:
        seen: set[int] = set()
        for row, stop_id in enumerate(self.stop_ids.tolist()):
            if stop_id in seen:
                raise defect(STOPS_FILE, f"stop {stop_id} stands twice", column="stop_id", row=row, stop_id=stop_id)
            seen.add(stop_id)
        for row, covariance in enumerate(() if self.covariances is None else self.covariances):
            try:
                read_covariance(covariance, "covariance")
            except InputError as error:
                raise defect(STOPS_FILE, error.message, column="cov_xx", row=row) from error


def parse_stops(table: TextTable) -> Stops:
    """Read the rows of a `stops.csv`; every column that is not reserved is a joint.

    Raises:
        TraceError: If a column is missing or ill-typed, or a value is not possible.
    """
    joint_names = tuple(name for name in table.columns if name not in ("stop_id", *_POSE, *_COVARIANCE))
    return Stops(
        stop_ids=table.integers("stop_id"),
        base_poses=np.stack([table.floats(name) for name in _POSE], axis=1),
        joint_names=joint_names,
        joints=np.array([table.floats(name) for name in joint_names]).reshape(len(joint_names), table.rows).T,
        covariances=_parse_covariances(table),
    )


def _parse_covariances(table: TextTable) -> FloatArray | None:
    if not any(name in table.columns for name in _COVARIANCE):
        return None
    covariances = np.zeros((table.rows, 3, 3))
    for name, i, j in zip(_COVARIANCE, *_UPPER, strict=True):
        covariances[:, i, j] = covariances[:, j, i] = table.floats(name)
    return covariances


def stops_csv(stops: Stops) -> bytes:
    """Write a `stops.csv`; equal records give equal bytes."""
    columns: dict[str, list[object]] = {"stop_id": stops.stop_ids.tolist()}
    columns |= dict(zip(_POSE, stops.base_poses.T.tolist(), strict=True))
    if stops.covariances is not None:
        columns |= dict(zip(_COVARIANCE, stops.covariances[:, *_UPPER].T.tolist(), strict=True))
    return as_csv(columns | dict(zip(stops.joint_names, stops.joints.T.tolist(), strict=True)))
