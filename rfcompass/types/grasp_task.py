"""What an arm is asked to do with its hand, and the answer: a task of inverse kinematics and its solution."""

from dataclasses import dataclass

import numpy as np

from rfcompass.arrays import FloatArray, read_only
from rfcompass.errors import ShapeError
from rfcompass.types.configuration import Configuration
from rfcompass.types.record import Record
from rfcompass.types.world import Clearance


@dataclass(frozen=True, slots=True)
class GraspTask(Record):
    """Where the tool must be, and as much of its orientation as matters, in the present base frame.

    An axis that is None is free. Five joints can do a task with one of them free, or with both where the approach
    lies in the plane of the arm.

    Attributes:
        point_m: Position of the tool [m], shape (3,).
        approach: Direction in which the tool points, shape (3,), made a unit vector; None if free.
        closing: Direction along which the jaws close, shape (3,), made a unit vector, perpendicular to `approach`;
            None if free.
        jaws_alike: Half a turn about the approach is the same grasp: the closing axis counts without its sign.
        any_heading: The task may be turned as a whole about the vertical through its point: only the heights of the
            axes' tips count. For things that are round, or where only the pitch of the tool matters.
    """

    point_m: FloatArray
    approach: FloatArray | None = None
    closing: FloatArray | None = None
    jaws_alike: bool = True
    any_heading: bool = False

    def __post_init__(self) -> None:
        """Freeze and normalise; two axes must be perpendicular."""
        object.__setattr__(self, "point_m", read_only(self.point_m, "GraspTask.point_m", (3,)))
        for name in ("approach", "closing"):
            if (axis := getattr(self, name)) is not None:
                object.__setattr__(self, name, _unit(axis, f"GraspTask.{name}"))
        if self.approach is not None and self.closing is not None and abs(self.approach @ self.closing) > 1e-6:
            message = f"GraspTask: approach and closing are not perpendicular: {self.approach @ self.closing:.3g}"
            raise ShapeError(message, name="closing")

    @staticmethod
    def of_pose(T_base_tool: FloatArray, approach_axis: FloatArray, closing_axis: FloatArray) -> "GraspTask":
        """The task that a whole tool pose asks for.

        Args:
            T_base_tool: Homogeneous pose, shape (4, 4).
            approach_axis: Approach in the tool frame, shape (3,).
            closing_axis: Closing axis in the tool frame, shape (3,).
        """
        T = read_only(T_base_tool, "T_base_tool", (4, 4))
        return GraspTask(T[:3, 3], T[:3, :3] @ approach_axis, T[:3, :3] @ closing_axis)

    @property
    def is_vertical(self) -> bool:
        """True if the approach is vertical, down or up."""
        return self.approach is not None and bool(abs(self.approach[2]) > 1 - 1e-12)


def _unit(axis: FloatArray, name: str) -> FloatArray:
    vector = read_only(axis, name, (3,))
    length = np.linalg.norm(vector)
    if length < 1e-12:
        raise ShapeError(f"{name}: has no direction", name=name)
    return read_only(vector / length, name, (3,))


@dataclass(frozen=True, slots=True)
class Solution(Record):
    """Joint values that do a task, and how they were found and checked.

    Attributes:
        configuration: Joints, and the base pose to drive to, in the present base frame; the identity if it stays.
        method: `"closed_form"`, `"sqp"` or `"ipopt"`.
        residual_m: Distance between tool and task [m], by pinocchio.
        residual_rad: Largest angle between an axis of the tool and the task's [rad], by pinocchio.
        at_limit: Joints that stand at one of their limits.
        clearance: Nearest pair that must not touch; None where nothing can touch.
        tries: Starts, or branches, that were needed.
        certified_pairs: Pairs of solids that fcl found apart; None if it was not asked.
    """

    configuration: Configuration
    method: str
    residual_m: float
    residual_rad: float
    at_limit: tuple[str, ...] = ()
    clearance: Clearance | None = None
    tries: int = 1
    certified_pairs: int | None = None
