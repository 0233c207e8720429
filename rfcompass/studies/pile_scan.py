"""The arm over the table: where it stands, the way that its camera and antennas go, and one scan with what it tells.

World frame: the pile's, z up, the table top is z = 0. A UR5e stands 0.50 m beside the table's middle, its foot 0.27 m
above the table top: the camera can then go round a square at both heights. The first square is the one by which scenes
are judged; the second is lower, wider, and nearer to the arm, since the antennas hang 17 cm beyond the camera. All
numbers are ours.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cache

import numpy as np

from planners.ik import InverseKinematics
from planners.scan_motion import ScanMotion, plan_scan
from rfcompass.arrays import FloatArray
from rfcompass.errors import TagNeverHeard, UnsuitablePath
from rfcompass.localization import WRIST_SAR, LocatedTags, locate_all
from rfcompass.recordings import Trace, TraceMeta, TraceTag, reads_table
from rfcompass.robots import Robot, load_robot
from rfcompass.simulation import AntennaTrack
from rfcompass.simulation.piles import PileScan, scan_poses
from rfcompass.simulation.piles.scanning import FRAME
from rfcompass.studies.fetch_trace import antenna_poses
from rfcompass.types.grasps import Failure
from rfcompass.types.reads import Scan
from rfcompass.types.volumes import SearchVolume
from rfcompass.types.workspace import Workspace
from rfcompass.types.world import World

ROBOT, CAMERA, ANTENNA = "ur5e_2f85", "camera_optical_link", "antenna_rx_link"
T_WORLD_BASE = np.array([[0.0, -1.0, 0.0, 0.0], [1.0, 0.0, 0.0, -0.50], [0.0, 0.0, 1.0, 0.27], [0.0, 0.0, 0.0, 1.0]])
# Each round of the camera: middle of the square, half its side, height over the table [m]. Images: on the first.
_HIGH, _LOW = ((0.0, 0.0), 0.22, 0.70), ((0.0, -0.08), 0.28, 0.45)
# A low and narrow one for tags that the others left unsure: of three that were tried on seeds below 12, it helped most.
_AGAIN = ((0.0, -0.08), 0.15, 0.42)
ROUNDS_M = {"one": (_HIGH,), "two": (_HIGH, _LOW), "again": (_AGAIN,)}
_HALF_TURN = np.diag([-1.0, -1.0, 1.0, 1.0])  # of the image: the antennas then hang away from the arm
LOWER_M, UPPER_M = np.array([-0.5, -0.4, 0.0]), np.array([0.5, 0.4, 0.4])
# Chosen on seeds below 20: a tag is confidently located if its box is smaller than that. [Boroushaki2023] prints none.
PILE_SAR = replace(WRIST_SAR, max_box_m=(0.20, 0.20, 0.30))
SEARCH = SearchVolume(LOWER_M, np.array([0.5, 0.4, 0.3]))


@dataclass(frozen=True, slots=True)
class WristWay:
    """Where camera and antenna go, by forward kinematics of a way that touches nothing.

    Attributes:
        robot: The arm.
        motion: Its joints.
        camera_poses: Where images are taken, in the world, shape (8, 4, 4).
        track: The receiving antenna, at every waypoint.
    """

    robot: Robot
    motion: ScanMotion
    camera_poses: FloatArray
    track: AntennaTrack


def workspace(spacing_m: float = 0.01) -> Workspace:
    """What is mapped: 1 x 0.8 x 0.4 m that stand on the table."""
    return Workspace.between(LOWER_M, UPPER_M, spacing_m)


@cache
def wrist_way(heights: str = "two") -> WristWay:
    """Plan the scan: once round the square at each height.

    Args:
        heights: `"one"` or `"two"`, or `"again"` for another way.

    Raises:
        UnsuitablePath: If the arm cannot go there.
    """
    robot = load_robot(ROBOT)
    rounds = [scan_poses(*square) @ _HALF_TURN for square in ROUNDS_M[heights]]
    wanted = np.concatenate([np.concatenate([once, once[:1]]) for once in rounds])
    ik = InverseKinematics(robot, World(floor_m=-float(T_WORLD_BASE[2, 3])))
    motion = plan_scan(ik, CAMERA, np.linalg.inv(T_WORLD_BASE) @ wanted, robot.posture("scan"))
    if isinstance(motion, Failure):
        raise UnsuitablePath(f"the arm cannot go round the table: {motion.message}", **dict(motion.numbers))
    camera = motion.poses_of(robot, CAMERA, T_WORLD_BASE)[motion.stops[: len(rounds[0])]]
    antenna = motion.poses_of(robot, ANTENNA, T_WORLD_BASE)
    ports = np.ones(len(antenna), dtype=np.int64)
    return WristWay(robot, motion, camera, AntennaTrack(antenna[:, :3, 3], antenna[:, :3, :3], ports))


def located(scan: Scan, epcs: Sequence[str]) -> LocatedTags:
    """Locate tags on the table as FuseBot does; those never heard are refusals."""
    return locate_all(scan, SEARCH, surveyor=PILE_SAR, epcs=epcs)


def pile_trace(scan: PileScan) -> Trace:
    """Record the reads of a scan: a trace that `rfcompass survey` takes.

    Raises:
        TagNeverHeard: If no tag answered.
    """
    if not len(scan.inventory):
        raise TagNeverHeard("no tag of the pile was heard", heard=[])
    poses = antenna_poses(list(scan.inventory.antenna_rows()))
    meta = TraceMeta(
        frame=FRAME,
        geometry="bistatic" if scan.inventory.rig.tx is not None else "monostatic",
        phase_modulus="pi" if scan.inventory.half_turns else "2pi",
        tags=tuple(TraceTag(epc) for epc in scan.inventory.epcs),
        source="simulated: scan of a pile",
        license="Apache-2.0",
        reader="simulated",
    )
    return Trace(meta=meta, reads=reads_table(scan.inventory.reads()), antenna_poses=poses)
