"""Records of the search in a pile: what the arm sees, where its hand can close, and what came of it."""

from dataclasses import dataclass

import numpy as np

from rfcompass.arrays import FloatArray, read_only
from rfcompass.errors import InputError, ShapeError
from rfcompass.types.fixes import TagFix
from rfcompass.types.piles import DepthView, ExtractionAction, InstanceMasks, VoxelGrid
from rfcompass.types.record import Record

HELD, SLIPPED, MISSED, BLOCKED, UNREACHABLE = "held", "slipped", "missed", "blocked", "unreachable"
GRASP_OUTCOMES = (HELD, SLIPPED, MISSED, BLOCKED, UNREACHABLE)


@dataclass(frozen=True, slots=True)
class GraspMaps(Record):
    """The best two-finger grasp at each pixel of a depth image, from straight above the table.

    Attributes:
        quality: Promise of success, 0 where none, in [0, 1], shape (H, W).
        angle_rad: Direction in which the jaws close, from the world's x about its z, shape (H, W).
        width_m: What the jaws close on, from contact to contact [m], shape (H, W).
        depth_m: How far the tips go below the surface that the pixel shows [m], shape (H, W).
    """

    quality: FloatArray
    angle_rad: FloatArray
    width_m: FloatArray
    depth_m: FloatArray

    def __post_init__(self) -> None:
        """Freeze the arrays; qualities are shares, widths and depths not negative."""
        shape = np.shape(self.quality)
        for name in self.__slots__:
            fixed = read_only(getattr(self, name), f"GraspMaps.{name}", (None, None))
            object.__setattr__(self, name, fixed)
            if fixed.shape != shape:
                message = f"GraspMaps.{name}: has shape {fixed.shape}, the quality {shape}"
                raise ShapeError(message, name=name, expected=shape, got=fixed.shape)
        if (self.quality < 0).any() or (self.quality > 1).any():
            raise ShapeError("GraspMaps.quality: must be in [0, 1]", name="quality")
        for name in ("width_m", "depth_m"):
            if (getattr(self, name) < 0).any():
                raise ShapeError(f"GraspMaps.{name}: must not be negative", name=name)


@dataclass(frozen=True, slots=True)
class GraspAttempt(Record):
    """What the hand felt when it went for something.

    Attributes:
        outcome: `held`: it is in the drop zone. `slipped`: the jaws had it when they had closed, but not to the end.
            `missed`: the jaws closed on nothing. `blocked`: the hand met something on its way down. `unreachable`: the
            arm cannot go there.
        gap_m: Distance of the jaws when they had closed; as they were open where they did not [m].
        duration_s: Time that the arm moved [s].
        shows_target: Whether what came into the drop zone has the target's colour.
        epcs: Tags that answered in the drop zone.
        message: Which joint, which force.
    """

    outcome: str
    gap_m: float
    duration_s: float
    shows_target: bool = False
    epcs: tuple[str, ...] = ()
    message: str = ""

    def __post_init__(self) -> None:
        """Check the outcome; nothing comes into the drop zone that was not held."""
        if self.outcome not in GRASP_OUTCOMES:
            message = f"GraspAttempt.outcome: {self.outcome!r} is none of {', '.join(GRASP_OUTCOMES)}"
            raise InputError(message, got=self.outcome, known=list(GRASP_OUTCOMES))
        object.__setattr__(self, "epcs", tuple(self.epcs))
        if (self.shows_target or self.epcs) and not self.success:
            raise InputError(f"GraspAttempt: {self.outcome}, yet something is in the drop zone", got=self.outcome)

    @property
    def success(self) -> bool:
        """Whether something was taken off the pile."""
        return self.outcome == HELD


@dataclass(frozen=True, slots=True)
class PileLook(Record):
    """What one motion of the arm over the table told.

    Attributes:
        views: Depth images with colour.
        fixes: Tags that were located, in the world frame, also those not confident.
    """

    views: tuple[DepthView, ...]
    fixes: tuple[TagFix, ...] = ()

    def __post_init__(self) -> None:
        """Freeze the sequences; there is at least one view."""
        object.__setattr__(self, "views", tuple(self.views))
        object.__setattr__(self, "fixes", tuple(self.fixes))
        if not self.views:
            raise InputError("a look at a pile without a view", got=0)


FOUND, TOO_MANY_ACTIONS, TOO_MANY_FAILURES = "found", "too_many_actions", "too_many_failures"
NOTHING_HIDDEN, NOTHING_TO_GRASP = "nothing_hidden", "nothing_to_grasp"
OUT_OF_REACH, CAMERA_BLOCKED, ARM_STOPPED = "out_of_reach", "camera_blocked", "arm_stopped"
SEARCH_ENDS = (
    FOUND,
    TOO_MANY_ACTIONS,
    TOO_MANY_FAILURES,
    NOTHING_HIDDEN,
    NOTHING_TO_GRASP,
    OUT_OF_REACH,
    CAMERA_BLOCKED,
    ARM_STOPPED,
)


@dataclass(frozen=True, slots=True)
class SearchStep(Record):
    """One action of a search: what was seen, what was believed, what was done, what came of it.

    Attributes:
        view: The image in which the object was chosen; its grasp may come from a nearer one.
        masks: Objects in it.
        grid: Where the target was thought to be, or what nobody saw if the method has no map; None where the target was
            in sight.
        action: What was gone for.
        on_target: Whether that was the target itself, in sight.
        attempt: What came of it.
        hidden_m3: Volume that no view has looked into, before the action [m³].
        elapsed_s: Time since the search began, after the action [s].
        chance: What the image promised of the grasp, after what had failed there, in [0, 1]; 0 where nothing did.
    """

    view: DepthView
    masks: InstanceMasks
    grid: VoxelGrid | None
    action: ExtractionAction
    on_target: bool
    attempt: GraspAttempt
    hidden_m3: float
    elapsed_s: float
    chance: float = 0.0


@dataclass(frozen=True, slots=True)
class SearchResult(Record):
    """How a search ended.

    Attributes:
        outcome: One of `SEARCH_ENDS`; `found` means that the target is in the drop zone.
        message: The same in words, with the numbers.
        steps: Every action, in order.
        elapsed_s: Time that the arm moved, scans included [s].
        hidden_m3: Volume that no view has looked into at the end [m³].
        tags_located: Tags that were located confidently before the first action.
        room_m3: The part of it in which a ball as thick as the target's shortest edge could lie [m³]: the map's own
            verdict on a target that was not found; None where nothing was mapped.
    """

    outcome: str
    message: str
    steps: tuple[SearchStep, ...]
    elapsed_s: float
    hidden_m3: float
    tags_located: int
    room_m3: float | None = None

    def __post_init__(self) -> None:
        """Freeze; check the outcome."""
        object.__setattr__(self, "steps", tuple(self.steps))
        if self.outcome not in SEARCH_ENDS:
            message = f"SearchResult.outcome: {self.outcome!r} is none of {', '.join(SEARCH_ENDS)}"
            raise InputError(message, got=self.outcome, known=list(SEARCH_ENDS))

    @property
    def found(self) -> bool:
        """Whether the target is in the drop zone."""
        return self.outcome == FOUND

    @property
    def actions(self) -> int:
        """Grasps, failed ones and that of the target included, as [Boroushaki2023] counts."""
        return len(self.steps)

    @property
    def failed_grasps(self) -> int:
        """Grasps that took nothing."""
        return sum(not step.attempt.success for step in self.steps)
