"""From a recorded trace to what an estimator sees at each stop: forward kinematics puts the robot's tags in place."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from rfcompass.errors import JointLimitError, TagNeverHeard, TraceError
from rfcompass.geometry.pose2 import as_pose2
from rfcompass.recordings.stops import STOPS_FILE, Stops
from rfcompass.types.observation import Observation
from rfcompass.types.parts import Part
from rfcompass.types.tags import TagLayout

if TYPE_CHECKING:
    from rfcompass.recordings.trace import Trace
    from rfcompass.robots import Robot  # pinocchio is slow to import, and only names are needed here


def observations(
    trace: "Trace", robot: "Robot", part: Part, epcs: Sequence[str] | None = None
) -> tuple[Observation, ...]:
    """Read every stop of a trace as an observation of one part.

    Args:
        trace: Recorded reads, or ready-made proximities, at one stop or several.
        robot: "Robot" that the trace's stops belong to; its base frame must lie on the floor.
        part: What is looked for; it lies on the floor.
        epcs: Tags of the part that are used; those that occur in the trace if None.

    Returns:
        One observation for each stop, in the order of `stops.csv`.

    Raises:
        TraceError: If the trace has no stops, or they name joints that the robot does not have.
        JointLimitError: If a joint value lies outside the robot's limits; carries `stop`.
        TagNeverHeard: If no tag of the part occurs in the trace.
    """
    if trace.stops is None:
        raise TraceError(f"the trace has no {STOPS_FILE}: no robot carried tags", file=STOPS_FILE)
    _check_joints(trace.stops, robot)
    layout = part.tagged(epcs) if epcs is not None else _layout_in_use(trace, part)
    return tuple(_observation(trace, trace.stops, row, robot, part, layout) for row in range(len(trace.stops.stop_ids)))


def _layout_in_use(trace: "Trace", part: Part) -> TagLayout:
    """Layout of the part's tags that occur in the trace, with its counterparts where the part has such a selection."""
    occurring = set(trace.epcs)
    for matrix in trace.proximity.values():
        occurring |= set(matrix.target_epcs)
    found = tuple(epc for epc in part.tags.epcs if epc in occurring)
    if not found:
        tags = ", ".join(part.tags.epcs) or "none"
        raise TagNeverHeard(f"no tag of {part.part_id} occurs in the trace (its tags: {tags})", part=part.part_id)
    for selection in part.selections:
        if set(selection.epcs) == set(found):
            return part.tagged(selection.epcs, selection.counterparts)
    return part.tagged(found)


def _check_joints(stops: Stops, robot: "Robot") -> None:
    if unknown := sorted(set(stops.joint_names) - set(robot.joint_names)):
        message = f"joint {unknown[0]} is none of robot {robot.name}: {', '.join(robot.joint_names)}"
        raise TraceError(message, file=STOPS_FILE, column=unknown[0])


def _observation(trace: "Trace", stops: Stops, row: int, robot: "Robot", part: Part, layout: TagLayout) -> Observation:
    stop_id = int(stops.stop_ids[row])
    base = as_pose2(stops.base_poses[row])
    joints = dict(zip(stops.joint_names, stops.joints[row].tolist(), strict=True))
    configuration = robot.configuration(joints, base)
    try:
        robot.check_limits(configuration)
    except JointLimitError as error:
        raise error.with_numbers(stop=stop_id) from error
    return Observation(
        stop_id=stop_id,
        anchors=robot.tag_positions(configuration),
        part=layout,
        part_tag_heights_m=layout.points_m[:, 2] + part.resting_height_m,
        scan=trace.scan(stop_id),
        proximity=trace.proximity.get(stop_id),
        base_pose=base,
        base_covariance=np.zeros((3, 3)) if stops.covariances is None else stops.covariances[row],
    )
