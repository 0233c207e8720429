"""Grasps: what was asked, what was found, what came of it."""

from collections.abc import Iterable
from dataclasses import dataclass, field

import numpy as np

from rfcompass.arrays import BoolArray, FloatArray, read_only
from rfcompass.errors import ShapeError
from rfcompass.geometry.pose2 import Pose2
from rfcompass.types.grasp_task import Solution
from rfcompass.types.motions import APPROACH, CLOSE, LIFT, REACH, StageCertificate, TimedPath
from rfcompass.types.record import Record
from rfcompass.types.stops import ProposedStop


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
class GraspFailure(Failure):
    """No grasp: the reason, with all that was tried.

    Attributes:
        candidates: Every candidate that was looked at, each with its own reason.
        base: Where to drive first, in the present base frame: from there the part can be grasped; None if that does
            not help or nobody looked.
    """

    candidates: tuple[GraspCandidate, ...] = ()
    base: Pose2 | None = None

    @property
    def reasons(self) -> dict[str, int]:
        """How many candidates were rejected for each reason, most frequent first."""
        return count_reasons(self.candidates)


@dataclass(frozen=True, slots=True)
class MeasureAdvice(Record):
    """What one more stop would do for a grasp: "measure again first".

    Attributes:
        stop: Where to measure, and how long it takes to get there.
        success_now: Success probability of the plan as it is.
        success_after: Expected success probability of the grasp that would be chosen after the stop.
        spread: Standard deviation of that success over the outcomes.
        outcomes: Hypothetical measurements that were played through.
    """

    stop: ProposedStop
    success_now: float
    success_after: float
    spread: float
    outcomes: int

    @property
    def message(self) -> str:
        """The advice in words."""
        rise = f"success would rise from {self.success_now:.2f} to {self.success_after:.2f}"
        return f"measure again first: {rise} with this stop"


@dataclass(frozen=True, slots=True)
class GraspPlan(Record):
    """A hand placement that was checked, with the way there and back.

    Frame of everything: the base frame at the grasp. Where the base drives first, `base` is where to, in the base
    frame before the drive, and the stage "drive" is in that frame too.

    Attributes:
        configuration: Joint values at the grasp, hand open, in the model's order, shape (Q,).
        approach: Joint path from pre-grasp to grasp, shape (A, Q).
        retreat: Joint path after the jaws have closed: lift and retreat, shape (B, Q).
        aperture_m: Opening before closing [m].
        clearance_m: No two things that must not touch come nearer than this, along the whole path [m]; bodies that
            stand around count as grown by the planner's margin.
        success_probability: Probability of a firm grasp under the estimate; None for a point estimate.
        candidates: Every candidate that was looked at.
        part_id: What is grasped.
        T_base_hand: Pose of the tool frame at the grasp, shape (4, 4).
        T_part_hand: The same in the part's frame, at the estimated pose, shape (4, 4).
        closed_m: Opening after closing on the part [m].
        success_sd: Standard deviation of that probability, for the number of samples.
        risks: Share of the samples in which the grasp fails, for each reason.
        stages: The motions, in order, within the limits of velocity.
        solution: How the inverse kinematics was solved.
        certificates: What each stage was checked against, in the order of the stages.
        base: Where to drive first; the identity if the base stays.
        advice: What measuring once more would bring; None if nobody asked or nothing would.
    """

    configuration: FloatArray
    approach: FloatArray
    retreat: FloatArray
    aperture_m: float
    clearance_m: float
    success_probability: float | None = None
    candidates: tuple[GraspCandidate, ...] = ()
    part_id: str = ""
    T_base_hand: FloatArray = field(default_factory=lambda: np.eye(4))
    T_part_hand: FloatArray = field(default_factory=lambda: np.eye(4))
    closed_m: float = 0.0
    success_sd: float = 0.0
    risks: tuple[tuple[str, float], ...] = ()
    stages: tuple[TimedPath, ...] = ()
    solution: Solution | None = None
    certificates: tuple[StageCertificate, ...] = ()
    base: Pose2 = field(default_factory=Pose2)
    advice: MeasureAdvice | None = None

    def __post_init__(self) -> None:
        """Freeze the arrays and check that they belong to one model."""
        Q, set_ = np.size(self.configuration), object.__setattr__
        set_(self, "configuration", read_only(self.configuration, "GraspPlan.configuration", (Q,)))
        set_(self, "approach", read_only(self.approach, "GraspPlan.approach", (None, Q)))
        set_(self, "retreat", read_only(self.retreat, "GraspPlan.retreat", (None, Q)))
        set_(self, "T_base_hand", read_only(self.T_base_hand, "GraspPlan.T_base_hand", (4, 4)))
        set_(self, "T_part_hand", read_only(self.T_part_hand, "GraspPlan.T_part_hand", (4, 4)))
        for name in ("candidates", "risks", "stages", "certificates"):
            set_(self, name, tuple(getattr(self, name)))

    @property
    def defects(self) -> tuple[str, ...]:
        """What speaks against executing the plan: records that are missing or say no. Empty for a sound plan."""
        found = []
        if self.solution is None:
            found.append("no record of how the inverse kinematics was solved")
        elif self.solution.certified_pairs is None:
            found.append("the grasp itself has no certificate by fcl")
        certified = {row.stage: row for row in self.certificates}
        for stage in self.stages:
            row = certified.get(stage.stage)
            if row is None or not row.fcl_checks:
                found.append(f"stage {stage.stage} has no certificate by fcl")
            elif not (row.apart and row.at_least_m >= 0):
                found.append(f"stage {stage.stage} touches something")
        missing = [name for name in (REACH, APPROACH, CLOSE, LIFT) if name not in {row.stage for row in self.stages}]
        return (*found, *(f"no stage {name}" for name in missing))

    @property
    def reasons(self) -> dict[str, int]:
        """How many candidates were rejected for each reason, most frequent first."""
        return count_reasons(self.candidates)

    @property
    def duration_s(self) -> float:
        """Time of all motions together [s]."""
        return sum(stage.duration_s for stage in self.stages)


def count_reasons(candidates: Iterable[GraspCandidate]) -> dict[str, int]:
    """How many candidates were rejected for each reason, most frequent first, then by name."""
    kinds = [row.rejection.kind for row in candidates if row.rejection is not None]
    return {kind: kinds.count(kind) for kind in sorted(set(kinds), key=lambda kind: (-kinds.count(kind), kind))}


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
