"""Grasps: what was asked, what was found, what came of it."""

from dataclasses import dataclass, field

import numpy as np

from rfcompass.arrays import BoolArray, FloatArray, read_only
from rfcompass.errors import ShapeError
from rfcompass.types.record import Record


@dataclass(frozen=True, slots=True)
class Failure(Record):
    """A typed reason why there is no plan.

    Attributes:
        kind: Machine-readable reason, for example `"joint_limit"` or `"scene_collision"`.
        message: The same for a human, with the numbers.
        numbers: Named evidence (which joint, how deep, how far).
    """

    kind: str
    message: str
    numbers: tuple[tuple[str, float | str], ...] = ()


@dataclass(frozen=True, slots=True)
class Contacts(Record):
    """Where two jaws hold a part, in the part frame; the left jaw first.

    Attributes:
        points_m: Middle of each contact [m], shape (2, 3).
        normals: Outward unit normals of the part there, shape (2, 3).
        width_m: Distance of the jaws when they have closed [m].
        angles_rad: Angle between the closing direction and each normal [rad], shape (2,).
    """

    points_m: FloatArray
    normals: FloatArray
    width_m: float
    angles_rad: FloatArray

    def __post_init__(self) -> None:
        """Freeze the arrays."""
        for name, shape in (("points_m", (2, 3)), ("normals", (2, 3)), ("angles_rad", (2,))):
            object.__setattr__(self, name, read_only(getattr(self, name), f"Contacts.{name}", shape))


@dataclass(frozen=True, slots=True)
class GraspCandidate(Record):
    """One way to grasp the part, kept whether or not it survived.

    Attributes:
        T_part_hand: Hand pose in the part frame, homogeneous, shape (4, 4).
        aperture_m: Opening of the jaws [m].
        score: Figure of merit, higher is better; None if rejected.
        rejection: Why it was rejected; None if it was not.
    """

    T_part_hand: FloatArray
    aperture_m: float
    score: float | None = None
    rejection: Failure | None = None

    def __post_init__(self) -> None:
        """Freeze the pose; a candidate has either a score or a rejection."""
        object.__setattr__(self, "T_part_hand", read_only(self.T_part_hand, "GraspCandidate.T_part_hand", (4, 4)))
        if (self.score is None) == (self.rejection is None):
            raise ShapeError("GraspCandidate: needs either a score or a rejection", name="score")


@dataclass(frozen=True, slots=True)
class GraspPlan(Record):
    """A hand placement that was checked, with the way there and back.

    Attributes:
        configuration: Joint values at the grasp, in the model's order, shape (Q,).
        approach: Joint path from pre-grasp to grasp, shape (A, Q).
        retreat: Joint path after the jaws have closed, shape (B, Q).
        aperture_m: Opening before closing [m].
        clearance_m: Smallest distance to anything that must not be touched, along the whole path [m].
        success_probability: Probability of a firm grasp under the estimate; None for a point estimate.
        candidates: Every candidate that was looked at.
    """

    configuration: FloatArray
    approach: FloatArray
    retreat: FloatArray
    aperture_m: float
    clearance_m: float
    success_probability: float | None = None
    candidates: tuple[GraspCandidate, ...] = ()

    def __post_init__(self) -> None:
        """Freeze the arrays and check that they belong to one model."""
        Q, set_ = np.size(self.configuration), object.__setattr__
        set_(self, "configuration", read_only(self.configuration, "GraspPlan.configuration", (Q,)))
        set_(self, "approach", read_only(self.approach, "GraspPlan.approach", (None, Q)))
        set_(self, "retreat", read_only(self.retreat, "GraspPlan.retreat", (None, Q)))


@dataclass(frozen=True, slots=True)
class GraspOutcome(Record):
    """What came of a grasp.

    Attributes:
        success: True if the part is in the hand.
        failure: Why not; None on success.
    """

    success: bool
    failure: Failure | None = None


@dataclass(frozen=True, slots=True)
class ReachMap(Record):
    """Where the tool can go: a voxel volume with the share of tool directions that can be reached in each voxel.

    Attributes:
        origin_m: Centre of the first voxel in the base frame [m], shape (3,).
        spacing_m: Edge of a voxel [m].
        share: Share of directions reached, between 0 and 1, shape (X, Y, Z).
    """

    origin_m: FloatArray
    spacing_m: float
    share: FloatArray

    def __post_init__(self) -> None:
        """Freeze the arrays and check the spacing."""
        object.__setattr__(self, "origin_m", read_only(self.origin_m, "ReachMap.origin_m", (3,)))
        object.__setattr__(self, "share", read_only(self.share, "ReachMap.share", (None, None, None)))
        if not self.spacing_m > 0:
            raise ShapeError(f"ReachMap.spacing_m: {self.spacing_m} is not positive", name="spacing_m")

    @property
    def reachable(self) -> BoolArray:
        """Voxels with at least one direction, shape (X, Y, Z)."""
        return np.asarray(self.share > 0)


@dataclass(frozen=True, slots=True)
class RunEvent(Record):
    """One thing that happened in a run.

    Attributes:
        stop_id: Stop at which it happened.
        kind: For example `"scan"`, `"estimate"`, `"move_base"`.
        numbers: Named values.
    """

    stop_id: int
    kind: str
    numbers: tuple[tuple[str, float | str], ...] = ()


@dataclass(frozen=True, slots=True)
class RunLog(Record):
    """What a run did, in order; viewers draw it.

    Attributes:
        part_id: What was fetched.
        configurations: Robot configuration at each stop, model order, shape (S, Q).
        events: What happened.
    """

    part_id: str
    configurations: FloatArray
    events: tuple[RunEvent, ...] = field(default_factory=tuple)

    def __post_init__(self) -> None:
        """Freeze the array."""
        object.__setattr__(
            self, "configurations", read_only(self.configurations, "RunLog.configurations", (None, None))
        )
