"""A simulated arm over a simulated pile: sees, hears, grasps, and counts the time. Behind it is the truth."""

from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace

import numpy as np

from planners.ik import IkRules, InverseKinematics
from planners.path_timing import in_time
from planners.pile_arm import ArmMotion, PileArm, link_poses
from rfcompass.arrays import FloatArray
from rfcompass.errors import ArmStopped, NoAnswer, OutOfReach, PileError, PileUnsettled
from rfcompass.localization import SarSurveyor, follow_tag
from rfcompass.robots import load_robot
from rfcompass.simulation import AntennaTrack, Inventory, inventory_scan
from rfcompass.simulation.piles import (
    ExecutedGrasp,
    PileCamera,
    PileScan,
    PileScene,
    PileWorld,
    RadioSetting,
    TaggedItems,
    grasp_item,
    hear_tags,
)
from rfcompass.simulation.piles.scanning import FRAME
from rfcompass.studies.pile_scan import ANTENNA, CAMERA, PILE_SAR, ROBOT, SEARCH, T_WORLD_BASE, WristWay, wrist_way
from rfcompass.types import DepthView, ExtractionAction, GraspAttempt, InstanceMasks, PileLook, TagFix
from rfcompass.types.configuration import Configuration
from rfcompass.types.counts import check_count
from rfcompass.types.grasps import Failure
from rfcompass.types.motions import REACH, RETREAT
from rfcompass.types.reads import ReadTrace
from rfcompass.types.search import BLOCKED, HELD, UNREACHABLE
from rfcompass.types.world import World

# Ours: where the hand opens, beside the table, in the world; time to hear all tags at one antenna position; distance
# between two antenna positions on a way between looks, and how few are worth locating anything from.
DROP_M = (0.60, -0.30, 0.35)
READ_S = 0.10
_APART_M, _FEWEST = 0.03, 6
_REMEMBERED = 12  # views whose true masks are kept; ours


def pile_arm() -> PileArm:
    """The UR5e where the studies put it."""
    robot = load_robot(ROBOT)
    ik = InverseKinematics(robot, World(floor_m=-float(T_WORLD_BASE[2, 3])), IkRules(certify=False, explain=False))
    return PileArm(ik, T_WORLD_BASE, CAMERA, np.array(DROP_M), robot.posture("scan"))


@dataclass(eq=False, kw_only=True)
class SimulatedPileRobot:
    """A `PileRobot` over a scene; changes its world as it works.

    Noise follows from the seed and from what was done so far: two methods that have done the same see the same.

    Args:
        scene: The pile; truth.
        tags: Which items are tagged.
        seed: Of all noise.
        way: Where a scan goes.
        arm: Plans and times the motions.
        absent: Whether the target is taken away before: it is sought in vain.
        surveyor: Locates tags.
        other_way: Where the arm goes to listen again.
        world: The pile now; truth.
        taken: Numbers of the items in the drop zone, in order; truth.
        motions: What the arm did, and when each motion began [s].
        tables: States of all items at the start and after each grasp, and when the hand had closed [s]; truth.
        scanned: What the first scan handed out; None while there was none, or nothing on the table carries a tag.
    """

    scene: PileScene
    tags: TaggedItems
    seed: int
    way: WristWay = field(default_factory=lambda: wrist_way("two"))
    arm: PileArm = field(default_factory=pile_arm)
    absent: bool = False
    surveyor: SarSurveyor = PILE_SAR
    other_way: WristWay = field(default_factory=lambda: wrist_way("again"))
    world: PileWorld = field(init=False)
    taken: list[int] = field(init=False, default_factory=list)
    motions: list[tuple[float, ArmMotion]] = field(init=False, default_factory=list)
    tables: list[tuple[float, Mapping[int, FloatArray]]] = field(init=False, default_factory=list)
    scanned: PileScan | None = field(init=False, default=None)
    _heard: dict[str, ReadTrace] = field(init=False, repr=False, default_factory=dict)
    _shown: list[tuple[DepthView, InstanceMasks]] = field(init=False, repr=False, default_factory=list)
    _planned: tuple[tuple[bytes, bytes], ArmMotion | Failure] | None = field(init=False, repr=False, default=None)
    _elapsed_s: float = field(init=False, repr=False, default=0.0)
    _grasps: int = field(init=False, repr=False, default=0)
    _looks: int = field(init=False, repr=False, default=0)

    def __post_init__(self) -> None:
        """Stand at rest over the table."""
        check_count(self.seed, "SimulatedPileRobot.seed")
        self.world = self.scene.world()
        if self.absent:
            self.world.remove(self.scene.target)
            self.world.settle()
        self.tables.append((0.0, self.world.states))
        self._joints = self.arm.resting
        self._camera = PileCamera(self.world, np.random.default_rng([self.seed, 0]))
        self._setting = RadioSetting.draw([tag.epc for tag in self.tags.tags], np.random.default_rng([self.seed, 3]))

    @property
    def elapsed_s(self) -> float:
        """Time that the arm has moved, or stood to read, so far [s]."""
        return self._elapsed_s

    def scan(self) -> PileLook:
        """Go round the table once with camera and antennas; without tags to hear, only as far as the last image.

        Raises:
            OutOfReach: If the arm cannot go to where the way begins.
        """
        rng = self._rng(1)
        self._heard.clear()
        last_image = int(self.way.motion.stops[len(self.way.camera_poses) - 1])
        path = self.way.motion.path if self.tags.tags else self.way.motion.path[: last_image + 1]
        self._begin(self.way)
        views = [self._view(T) for T in self.way.camera_poses]
        around = ArmMotion((in_time(self.way.robot, REACH, path),), 0.0, self.way.camera_poses[-1])
        self._moved(_reading(around, len(self.way.track)) if self.tags.tags else around)
        inventory = self._hears(self.way.track, rng)
        if inventory is not None:
            self.scanned = self.scanned or PileScan(tuple(views), inventory)
        return PileLook(tuple(views), self._located(self._traces(inventory)))

    def listen_again(self) -> tuple[TagFix, ...]:
        """Go round on another way, and locate all tags from what was heard on both.

        Raises:
            OutOfReach: If the arm cannot go to where the way begins.
        """
        rng, way = self._rng(4), self.other_way
        self._begin(way)
        around = ArmMotion((in_time(way.robot, REACH, way.motion.path),), 0.0, way.camera_poses[-1])
        self._moved(_reading(around, len(way.track)))
        return self._located(self._traces(self._hears(way.track, rng)))

    def look(self, point_m: FloatArray, height_m: float, tags: Sequence[TagFix] = ()) -> PileLook:
        """Take an image from above a point, and listen on the way there to tags that may have been moved.

        Raises:
            OutOfReach: If the arm cannot look from there.
        """
        motion = self.arm.look_at(point_m, height_m, self._joints)
        if isinstance(motion, Failure):
            raise OutOfReach(f"the arm cannot look at the pile: {motion.message}", **dict(motion.numbers))
        track = self._track(motion) if tags else None
        if track is None or len(track) < _FEWEST:
            self._moved(motion)
            return PileLook((self._view(motion.T_world_link),))
        self._moved(_reading(motion, len(track)))
        view = self._view(motion.T_world_link)
        return PileLook((view,), self._followed(self._traces(self._hears(track, self._rng(2))), tags))

    def reaches(self, action: ExtractionAction) -> bool:
        """Plan the way to a grasp and to the drop zone."""
        return isinstance(self._fetch(action), ArmMotion)

    def grasp(self, action: ExtractionAction) -> GraspAttempt:
        """Go for an object and put what is held into the drop zone; an empty hand stays above the place.

        Raises:
            ArmStopped: If the simulation of the grasp blew up; the pile is as it was.
        """
        self._grasps, self._looks = self._grasps + 1, 0
        motion = self._fetch(action)
        if isinstance(motion, Failure):
            return GraspAttempt(UNREACHABLE, action.aperture_m, 0.0, message=motion.message)
        try:
            done = grasp_item(self.world, action.T_world_hand, action.aperture_m)
        except PileUnsettled as why:
            raise ArmStopped(f"the arm stopped: {why}", during="grasp", **why.numbers) from why
        held, motion = done.outcome == HELD, _as_it_went(motion, done)
        self.tables.append((self._elapsed_s + motion.closed_s, self.world.states))
        self._moved(motion)
        self.taken.extend(done.taken)
        there = {tag.number: tag.epc for tag in self.tags.tags}
        return GraspAttempt(
            done.outcome,
            done.gap_m,
            motion.duration_s,
            shows_target=held and self.scene.target in done.taken,
            epcs=tuple(there[number] for number in done.taken if number in there) if held else (),
            message="" if held else _felt(done),
        )

    def true_masks(self, view: DepthView) -> InstanceMasks:
        """Which item each pixel of one of the last views shows: truth, for studies that say that they use it.

        Raises:
            ValueError: If it is none of them.
        """
        for seen, masks in reversed(self._shown):
            if seen is view:
                return masks
        raise ValueError("this robot did not take that view")

    def _fetch(self, action: ExtractionAction) -> ArmMotion | Failure:
        """The motion of a grasp; that of the last question is kept."""
        asked = (action.T_world_hand.tobytes(), self._joints.joints.tobytes())
        if self._planned is None or self._planned[0] != asked:
            self._planned = asked, self.arm.fetch(action.T_world_hand, self._joints)
        return self._planned[1]

    def _view(self, T_world_camera: FloatArray) -> DepthView:
        self._camera.move_to(T_world_camera)
        view, masks = self._camera.view_and_masks()
        self._shown = [*self._shown[1 - _REMEMBERED :], (view, masks)]
        return view

    def _moved(self, motion: ArmMotion) -> None:
        self.motions.append((self._elapsed_s, motion))
        self._elapsed_s += motion.duration_s
        self._joints = motion.end

    def _rng(self, what: int) -> np.random.Generator:
        self._looks += 1
        return np.random.default_rng([self.seed, what, self._grasps, self._looks])

    def _track(self, motion: ArmMotion) -> AntennaTrack:
        """Where the receiving antenna goes, at even distances."""
        path = motion.path
        ends_m = link_poses(self.arm, path, ANTENNA)[:, :3, 3]
        steps = np.maximum(1, np.ceil(np.linalg.norm(np.diff(ends_m, axis=0), axis=1) / _APART_M)).astype(int)
        rows = [a + (b - a) * k / n for a, b, n in zip(path[:-1], path[1:], steps, strict=True) for k in range(n)]
        T = link_poses(self.arm, [*rows, path[-1]], ANTENNA)
        return AntennaTrack(T[:, :3, 3], T[:, :3, :3], np.ones(len(T), dtype=np.int64))

    def _begin(self, way: WristWay) -> None:
        """Go to where a way begins."""
        motion = self.arm.move_to(Configuration(way.motion.path[0]), self._joints)
        if isinstance(motion, Failure):
            raise OutOfReach(f"the arm cannot begin its scan: {motion.message}", **dict(motion.numbers))
        self._moved(ArmMotion((motion,), 0.0, way.camera_poses[0]))

    def _hears(self, track: AntennaTrack, rng: np.random.Generator) -> Inventory | None:
        """What tags of the table answer along a track; None where no tag is."""
        if not self.tags.tags:
            return None
        try:
            return hear_tags(self.world, self.tags, track, rng, setting=self._setting)
        except PileError:  # all of them have rolled off the table
            return None

    def _traces(self, inventory: Inventory | None) -> Mapping[str, ReadTrace]:
        epcs = [tag.epc for tag in self.tags.tags]
        return {} if inventory is None else inventory_scan(inventory, epcs, FRAME).traces

    def _located(self, heard: Mapping[str, ReadTrace]) -> tuple[TagFix, ...]:
        """Locate all tags from what was heard since the scan began."""
        for epc, trace in heard.items():
            self._heard[epc] = self._heard[epc].then(trace) if epc in self._heard else trace
        fixes = []
        for trace in self._heard.values():
            with suppress(NoAnswer):  # too few reads
                fixes.append(self.surveyor.locate(trace, SEARCH))
        return tuple(fixes)

    def _followed(self, heard: Mapping[str, ReadTrace], tags: Sequence[TagFix]) -> tuple[TagFix, ...]:
        """Say where some tags are now."""
        fixes = []
        for fix in tags:
            if fix.epc in heard:
                with suppress(NoAnswer):
                    fixes.append(follow_tag(heard[fix.epc], fix, SEARCH, self.surveyor))
        return tuple(fixes)


def _as_it_went(motion: ArmMotion, done: ExecutedGrasp) -> ArmMotion:
    """What was done of a planned fetch: an empty hand is not carried away, a blocked one does not close."""
    if done.outcome == HELD:
        return motion
    stages = tuple(stage for stage in motion.stages if stage.stage != RETREAT)
    return replace(motion, stages=stages, waiting_s=0.0 if done.outcome == BLOCKED else motion.waiting_s)


def _felt(done: ExecutedGrasp) -> str:
    """Why nothing is in the drop zone, as far as a hand can tell."""
    if done.outcome == BLOCKED:
        return f"{done.force_n:.0f} N on the way down"
    return f"jaws {1000 * done.gap_m:.0f} mm apart once they had closed"


def _reading(motion: ArmMotion, positions: int) -> ArmMotion:
    """The same motion, slowed down until there is time to read at so many antenna positions."""
    moving_s = motion.duration_s - motion.waiting_s
    slower = max(1.0, READ_S * positions / moving_s) if moving_s > 0 else 1.0
    return replace(motion, stages=tuple(replace(stage, times_s=stage.times_s * slower) for stage in motion.stages))
