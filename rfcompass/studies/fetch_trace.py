"""A simulated fetch as a trace: the same records that a file or a reader would give."""

from collections.abc import Sequence

import numpy as np

from planners.fetch import FetchStep
from rfcompass.recordings import AntennaPoses, Stops, Trace, TraceMeta, TraceTag, reads_table
from rfcompass.studies.fetching import FetchTask


def fetch_trace(task: FetchTask, steps: Sequence[FetchStep]) -> Trace:
    """Record what was believed and heard at every stop. Proximities are ready-made, so there are no reads."""
    robot = task.robot.layout
    tags = [
        TraceTag(epc, "robot", robot.frames[i], _vector(robot.points_m[i]), _vector(robot.dipoles[i]))
        for i, epc in enumerate(robot.epcs)
    ]
    part = steps[-1].observation.part
    tags += [
        TraceTag(epc, task.part.part_id, None, _vector(part.points_m[k]), _vector(part.dipoles[k]))
        for k, epc in enumerate(part.epcs)
    ]
    bases = [step.observation.base_pose for step in steps]
    return Trace(
        meta=TraceMeta(
            frame="odom",
            tags=tuple(tags),
            source="simulated: distances with noise",
            license="Apache-2.0",
            reader="simulated",
            robot=task.robot.name,
            tag_layout=task.robot.description.layout_name,
        ),
        reads=reads_table((), ()),
        antenna_poses=AntennaPoses.along(np.zeros((0, 3))),
        stops=Stops(
            stop_ids=np.array([step.observation.stop_id for step in steps]),
            base_poses=np.array([[base.x_m, base.y_m, base.theta_rad] for base in bases]),
            joint_names=task.robot.joint_names,
            joints=np.array([step.configuration.joints for step in steps]),
            covariances=np.array([step.observation.base_covariance for step in steps]),
        ),
        proximity={
            step.observation.stop_id: step.observation.proximity
            for step in steps
            if step.observation.proximity is not None
        },
    )


def _vector(values: np.ndarray) -> tuple[float, float, float]:
    x, y, z = values.tolist()
    return x, y, z
