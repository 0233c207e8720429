"""A task as it happens, in a browser: the robot, its way, and what is known at each stop."""

import time
from dataclasses import dataclass, field

import numpy as np

from rfcompass.arrays import FloatArray
from rfcompass.geometry.pose2 import Pose2
from rfcompass.robots import Robot
from rfcompass.types.configuration import Configuration
from rfcompass.types.estimate import PartEstimate
from rfcompass.types.parts import Part
from rfcompass.viz.grasp_layers import draw_belief
from rfcompass.viz.live_window import LiveView, follow
from rfcompass.viz.robot_scene import RobotScene

_CAMERA_M = np.array([-1.6, -2.6, 2.6])  # ours: wide enough for the paper's room


@dataclass(eq=False)
class LiveTask:
    """Draws a task while it runs, in the odometry frame.

    Args:
        robot: Who does it.
        at: Where it stands at the start.
        open_browser: Open the page; without, whoever wants to look goes to the address.
        pace_s: Rest after each picture, so that a simulated robot does not jump [s].
    """

    robot: Robot
    at: Configuration
    open_browser: bool = True
    pace_s: float = 0.05
    _scene: RobotScene = field(init=False, default_factory=RobotScene)
    _way_m: list[FloatArray] = field(init=False, default_factory=list)
    _drawn: set[str] = field(init=False, default_factory=set)

    def __post_init__(self) -> None:
        """Draw the start and serve it."""
        self._scene.draw_robot([self.robot.visual_shapes(self.at)])
        self._scene.look_at(np.zeros(3), _CAMERA_M)
        self.live: LiveView = follow(self._scene.window, open_browser=self.open_browser)

    def robot_at(self, at: Configuration) -> None:
        """The robot is somewhere else; a drive adds to its way."""
        self._scene.move_robot(self.robot.visual_shapes(at))
        here_m = at.base.translation_m
        if not self._way_m or not np.array_equal(here_m, self._way_m[-1]):
            self._way_m.append(here_m)
            self._scene.draw_path("base", np.array(self._way_m))
        time.sleep(self.pace_s)

    def known(self, estimate: PartEstimate, base: Pose2) -> None:
        """A stop has led to an estimate, in the frame of a base: its region and draws replace those before."""
        self._scene.clear("region", "belief")
        draw_belief(self._scene, estimate.in_frame(base))

    def part_at(self, part: Part, tags_m: FloatArray, T_odom_part: FloatArray) -> None:
        """A part is believed to be somewhere: lying, or in the hand; pose homogeneous, shape (4, 4)."""
        node = f"parts/{part.part_id}"
        if node not in self._drawn:
            self._scene.draw_part(part, Pose2(), tags_m, node)
            self._drawn.add(node)
        self._scene.move_part([T_odom_part], name=node)

    def close(self) -> None:
        """End the server."""
        self.live.close()
