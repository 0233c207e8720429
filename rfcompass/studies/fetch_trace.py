"""A simulated fetch as a trace: the same records that a file or a reader would give."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pinocchio as pin
import pyarrow as pa

from rfcompass.arrays import FloatArray
from rfcompass.recordings import AntennaPoses, Stops, Trace, TraceMeta, TraceTag, reads_table
from rfcompass.robots import Robot
from rfcompass.simulation import Inventory, RecordedStop
from rfcompass.simulation.inventory import AntennaRow
from rfcompass.types.reads import TagRead


def fetch_trace(robot: Robot, stops: Sequence[RecordedStop]) -> Trace:
    """Record what was believed and heard at every stop: reads of a radio, or ready-made proximities.

    Args:
        robot: The robot that carried the tags.
        stops: All stops of one job, at least one.
    """
    inventories = [stop.inventory for stop in stops if stop.inventory is not None]
    meta = TraceMeta(
        frame="room" if inventories else "odom",
        geometry="bistatic" if inventories and inventories[0].rig.tx is not None else "monostatic",
        phase_modulus="pi" if inventories and inventories[0].half_turns else "2pi",
        source="simulated: radio" if inventories else "simulated: distances with noise",
        license="Apache-2.0",
        reader="simulated",
    )
    reads, poses = _reads_and_poses([(stop.observation.stop_id, stop.inventory) for stop in stops])
    return trace_of_stops(robot, stops, meta, reads, poses)


def trace_of_stops(
    robot: Robot, stops: Sequence[RecordedStop], meta: TraceMeta, reads: pa.Table, poses: AntennaPoses
) -> Trace:
    """Put reads beside what the robot believed at each stop, and list all tags.

    Args:
        robot: The robot that carried the tags.
        stops: All stops of one job, at least one.
        meta: How to interpret the reads; robot and tags are filled in.
        reads: All reads, with their stops.
        poses: Where the antennas were.
    """
    observations = [stop.observation for stop in stops]
    bases = [observation.base_pose for observation in observations]
    tags = (*_robot_tags(robot), *_part_tags(stops[-1]))
    return Trace(
        meta=replace(meta, tags=tags, robot=robot.name, tag_layout=robot.description.layout_name),
        reads=reads,
        antenna_poses=poses,
        stops=Stops(
            stop_ids=np.array([observation.stop_id for observation in observations]),
            base_poses=np.array([[base.x_m, base.y_m, base.theta_rad] for base in bases]),
            joint_names=robot.joint_names,
            joints=np.array([stop.configuration.joints for stop in stops]),
            covariances=np.array([observation.base_covariance for observation in observations]),
        ),
        proximity={seen.stop_id: seen.proximity for seen in observations if seen.proximity is not None},
    )


def _robot_tags(robot: Robot) -> list[TraceTag]:
    tags = robot.layout
    return [
        TraceTag(epc, "robot", tags.frames[i], _vector(tags.points_m[i]), _vector(tags.dipoles[i]))
        for i, epc in enumerate(tags.epcs)
    ]


def _part_tags(stop: RecordedStop) -> list[TraceTag]:
    tags = stop.observation.part
    return [
        TraceTag(epc, tags.body, None, _vector(tags.points_m[k]), _vector(tags.dipoles[k]))
        for k, epc in enumerate(tags.epcs)
    ]


def _reads_and_poses(heard: Sequence[tuple[int, Inventory | None]]) -> tuple[pa.Table, AntennaPoses]:
    """All reads as one table, and all antenna poses, numbered on from stop to stop."""
    reads: list[TagRead] = []
    rows: list[AntennaRow] = []
    stop_ids: list[int] = []
    first = 0
    for stop_id, inventory in heard:
        if inventory is not None:
            of_stop = inventory.reads(first_pose_id=first)
            reads += of_stop
            stop_ids += [stop_id] * len(of_stop)
            rows += list(inventory.antenna_rows(first_pose_id=first))
            first += len(inventory.nominal_track)
    return reads_table(reads, stop_ids), antenna_poses(rows)


def antenna_poses(rows: Sequence[AntennaRow]) -> AntennaPoses:
    """Gather where antennas were believed to be, as a trace keeps it."""
    return AntennaPoses(
        pose_ids=np.array([row.pose_id for row in rows], dtype=np.int64),
        antennas=np.array([row.antenna for row in rows], dtype=np.int64),
        positions_m=np.array([row.position_m for row in rows]).reshape(-1, 3),
        quaternions_xyzw=np.array([_quaternion(row.rotation) for row in rows]).reshape(-1, 4),
    )


def _quaternion(rotation: FloatArray) -> FloatArray:
    return np.asarray(pin.Quaternion(rotation).coeffs())  # x, y, z, w


def _vector(values: FloatArray) -> tuple[float, float, float]:
    x, y, z = values.tolist()
    return x, y, z
