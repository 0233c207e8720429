"""The roles of the software. A newcomer reads this file first.

Each role is a protocol: anything with these methods can take the place of what we ship. Implementations are
frozen records of parameters; they keep no memory between calls. Simulated and real devices stand behind the
same protocol, so that nothing downstream can tell them apart.

    reads ──ReadSource──▶ Scan ──ProximityMeter──▶ ProximityMatrix ──Localizer──▶ PartEstimate ──▶ a grasp
                            └────Surveyor────────▶ TagFix
"""

from collections.abc import Iterator, Sequence
from typing import Protocol, runtime_checkable

from rfcompass.arrays import FloatArray
from rfcompass.geometry.pose2 import Pose2
from rfcompass.types.configuration import Configuration
from rfcompass.types.estimate import PartEstimate
from rfcompass.types.fixes import TagFix
from rfcompass.types.grasps import GraspOutcome
from rfcompass.types.observation import Observation
from rfcompass.types.piles import DepthView, ExtractionAction, InstanceMasks, VoxelGrid
from rfcompass.types.proximity import ProximityMatrix
from rfcompass.types.reads import ReadTrace, Scan, TagRead
from rfcompass.types.robot_state import RobotState
from rfcompass.types.search import GraspAttempt, GraspMaps, PileLook
from rfcompass.types.stops import ProposedStop
from rfcompass.types.volumes import SearchVolume


@runtime_checkable
class ReadSource(Protocol):
    """Where reads come from: a trace file, a live reader, a simulated one."""

    def __iter__(self) -> Iterator[Sequence[TagRead]]:
        """Yield batches of reads in the order of their arrival."""
        ...


@runtime_checkable
class ProximityMeter(Protocol):
    """Turns the reads of one scan into numbers that grow with the distance between two tags."""

    @property
    def kind(self) -> str:
        """Name of the meter, for example `"phase_l1"`."""
        ...

    def measure(
        self, scan: Scan, *, targets: Sequence[str] = (), anchors: Sequence[str] | None = None
    ) -> ProximityMatrix:
        """Compare every target with every anchor, and the anchors with each other.

        Args:
            scan: Reads of one stop.
            targets: EPCs of the tags on the part (K).
            anchors: EPCs of the tags whose place is known (N); every other tag of the scan if None.

        Returns:
            m with NaN for each pair in which a tag was not heard. m of a tag with itself is NaN.

        Raises:
            TagNeverHeard: If none of the tags was heard.
        """
        ...


@runtime_checkable
class Surveyor(Protocol):
    """Locates one tag from its own reads along a known antenna path."""

    def locate(self, trace: ReadTrace, volume: SearchVolume) -> TagFix:
        """Find the tag inside a search volume, both in the frame of the antenna path.

        Raises:
            TooFewReads: If the tag was heard at too few antenna positions.
        """
        ...


@runtime_checkable
class Localizer(Protocol):
    """Finds the part's pose from what was heard at one stop or several.

    The answer is in the base frame of the newest stop. Equal observations give equal answers, whatever was
    asked before, whatever the tags are called and in whatever order they come.
    """

    def estimate(self, observations: Sequence[Observation]) -> PartEstimate:
        """Estimate the pose of the part.

        Args:
            observations: Stops in the order they were made, newest last.

        Raises:
            NoAnswer: If the observations allow no answer; the subclass says why.
        """
        ...


@runtime_checkable
class Scanner(Protocol):
    """Makes one scan where the robot stands now."""

    def scan(self) -> Observation:
        """Inventory all tags once and return what was heard, with forward kinematics already run."""
        ...


@runtime_checkable
class AntennaCarrier(Protocol):
    """Moves the reader's antenna along straight legs during each scan; a second robot, a gantry, or a simulated one."""

    def use_legs(self, legs_m: FloatArray) -> None:
        """Drive these legs at every scan from now on.

        Args:
            legs_m: Start and end of each leg, in the frame of the antenna positions [m], shape (L, 2, 3).
        """
        ...


@runtime_checkable
class MobileManipulator(Protocol):
    """A robot that drives, moves its arm and closes its hand; real or simulated."""

    def move_base(self, T_base_goal: Pose2) -> Pose2:
        """Drive to a pose given in the present base frame; return the believed motion (odometry)."""
        ...

    def move_arm(self, joints: FloatArray) -> None:
        """Move the arm to joint values [rad], in the order of the URDF."""
        ...

    def close_hand(self) -> GraspOutcome:
        """Close the jaws and report whether something is held."""
        ...


@runtime_checkable
class StateReporter(Protocol):
    """A robot that says what it believes about itself."""

    def state(self) -> RobotState:
        """Return odometry and joint sensors as they are now."""
        ...


@runtime_checkable
class HandOpener(Protocol):
    """A robot that can let go of what it holds."""

    def open_hand(self) -> None:
        """Let go: what was held stays where it is, or falls."""
        ...


@runtime_checkable
class StopProposer(Protocol):
    """Offers the stops a robot can take next: reachable, free of collision, with their cost."""

    def candidates(self, configuration: Configuration) -> Sequence[ProposedStop]:
        """List stops, in the frame of the configuration's base."""
        ...


@runtime_checkable
class GraspOracle(Protocol):
    """Judges a grasp against the true part; only simulators implement it."""

    def judge(self, T_world_hand: FloatArray, aperture_m: float) -> GraspOutcome:
        """Tell whether closing the hand there would hold the part; pose homogeneous, shape (4, 4)."""
        ...


@runtime_checkable
class DepthSource(Protocol):
    """A depth camera, real or simulated."""

    def view(self) -> DepthView:
        """Take one image where the camera is now."""
        ...


@runtime_checkable
class Segmenter(Protocol):
    """Tells objects apart in a depth image."""

    def segment(self, view: DepthView) -> InstanceMasks:
        """Label each pixel with its object."""
        ...


@runtime_checkable
class GraspQuality(Protocol):
    """Scores a two-finger grasp at each pixel of a depth image: from image to images."""

    def quality(self, view: DepthView) -> GraspMaps:
        """Say how good the best grasp at each pixel is, and how the jaws would stand."""
        ...


@runtime_checkable
class ExtractionPolicy(Protocol):
    """Chooses which object to take out of the pile next. Keeps no memory: what failed before is told."""

    def choose(
        self,
        grid: VoxelGrid,
        view: DepthView,
        masks: InstanceMasks,
        grasps: GraspMaps,
        failed_m: Sequence[FloatArray] = (),
    ) -> ExtractionAction:
        """Choose one removal.

        Args:
            grid: How likely the target is in each voxel, in the world frame; need not sum to 1.
            view: What the camera sees of the pile.
            masks: Which object each pixel of the view shows.
            grasps: The best grasp at each pixel of the view.
            failed_m: Where grasps have failed since the last success, in the world frame [m], shape (3,) each.

        Raises:
            NothingToGrasp: If the view shows no object that has a depth.
            CameraBlocked: If a policy that looks at the image itself finds nothing in it.
        """
        ...


@runtime_checkable
class PileRobot(Protocol):
    """An arm with a camera and antennas on its wrist, and a hand, over a table; real or simulated."""

    @property
    def elapsed_s(self) -> float:
        """Time that the arm has moved so far [s]."""
        ...

    def scan(self) -> PileLook:
        """Go round the table once with camera and antennas."""
        ...

    def listen_again(self) -> tuple[TagFix, ...]:
        """Go round on another way, before anything was moved; locate all tags from what was heard on both.

        Raises:
            OutOfReach: If the arm cannot go there.
        """
        ...

    def look(self, point_m: FloatArray, height_m: float, tags: Sequence[TagFix] = ()) -> PileLook:
        """Take an image from above a point, and listen on the way there to tags that may have been moved.

        Args:
            point_m: Where to look, in the world [m], shape (3,).
            height_m: Height of the camera over the table [m]; as near to that as the arm can.
            tags: Where they were, see `rfcompass.localization.follow_tag`.

        Returns:
            The image, and a fix of each of those tags that was heard.

        Raises:
            OutOfReach: If the arm cannot look there.
        """
        ...

    def reaches(self, action: ExtractionAction) -> bool:
        """Whether the arm can go for an object from where it is, and carry it to the drop zone; it stays at rest."""
        ...

    def grasp(self, action: ExtractionAction) -> GraspAttempt:
        """Go for an object and put what is held into the drop zone.

        Raises:
            ArmStopped: If nothing can be done any more: a protective stop, or a simulation that blew up.
        """
        ...
