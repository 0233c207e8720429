"""Motions in time, and the record of what they were checked against."""

from dataclasses import dataclass, field

import numpy as np

from rfcompass.arrays import FloatArray, read_only
from rfcompass.errors import ShapeError
from rfcompass.types.record import Record
from rfcompass.types.world import Clearance

# The stages of a grasp, in their order; a plan whose base stays has no drive.
DRIVE, REACH, APPROACH, CLOSE, LIFT, RETREAT = "drive", "reach", "approach", "close", "lift", "retreat"
STAGES = (DRIVE, REACH, APPROACH, CLOSE, LIFT, RETREAT)


@dataclass(frozen=True, slots=True)
class TimedPath(Record):
    """A motion of joints and base, one waypoint at a time; between two of them everything moves evenly.

    Attributes:
        stage: What it is for, one of `STAGES`.
        names: URDF names of the joints, in the model's order (Q).
        times_s: When each waypoint is passed [s], from 0, never falling, shape (T,).
        joints: Joint values at each [rad or m], shape (T, Q).
        bases: Pose x, y, θ of the base at each [m, m, rad], in the frame of the plan, shape (T, 3); a base that
            stays at the frame's origin if left out.
    """

    stage: str
    names: tuple[str, ...]
    times_s: FloatArray
    joints: FloatArray
    bases: FloatArray = field(default_factory=lambda: np.zeros((0, 3)))

    def __post_init__(self) -> None:
        """Freeze the arrays; time goes forward."""
        set_, T = object.__setattr__, np.size(self.times_s)
        if self.stage not in STAGES:
            raise ShapeError(f"TimedPath.stage: {self.stage!r} is none of {', '.join(STAGES)}", name="stage")
        set_(self, "names", tuple(self.names))
        set_(self, "times_s", read_only(self.times_s, "TimedPath.times_s", (T,)))
        set_(self, "joints", read_only(self.joints, "TimedPath.joints", (T, len(self.names))))
        bases = np.zeros((T, 3)) if np.size(self.bases) == 0 else self.bases
        set_(self, "bases", read_only(bases, "TimedPath.bases", (T, 3)))
        if not T or self.times_s[0] != 0 or (np.diff(self.times_s) < 0).any():
            raise ShapeError("TimedPath.times_s: must start at 0 and never fall", name="times_s")

    @property
    def duration_s(self) -> float:
        """When the last waypoint is passed [s]."""
        return float(self.times_s[-1])


@dataclass(frozen=True, slots=True)
class StageCertificate(Record):
    """What one stage of a plan was checked against, by two independent checkers.

    Attributes:
        stage: Name of the stage.
        pairs: Pairs of solids that had to stay apart.
        fcl_checks: Configurations along the path at which fcl looked at every pair.
        apart: True if fcl found nothing touching at any of them.
        clearance: The nearest pair that the gap-free check met; None where nothing can touch.
        at_least_m: No pair comes nearer than this anywhere along the stage [m], by the gap-free check.
    """

    stage: str
    pairs: int
    fcl_checks: int
    apart: bool
    clearance: Clearance | None
    at_least_m: float
