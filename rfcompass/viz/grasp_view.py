"""One call that draws a grasp: the robot on its way, the part in the hand, what is known, and what was rejected.

view(robot, estimate, plan, part=leg).save("grasp.html")
"""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from rfcompass.arrays import FloatArray
from rfcompass.errors import InputError
from rfcompass.geometry.pose2 import Pose2, as_pose2
from rfcompass.robots import Robot
from rfcompass.types.configuration import Configuration
from rfcompass.types.estimate import PartEstimate
from rfcompass.types.grasps import Failure, GraspFailure, GraspPlan, ReachMap
from rfcompass.types.parts import Part
from rfcompass.types.placed_shape import PlacedShape
from rfcompass.types.world import World
from rfcompass.viz import colours, grasp_layers
from rfcompass.viz.live_window import LiveView, show_live
from rfcompass.viz.meshcat_page import RecordingWindow, scene_html, write_scene
from rfcompass.viz.overlay import Layer, Overlay, StageMark
from rfcompass.viz.played_motion import homogeneous, play
from rfcompass.viz.robot_scene import RobotScene

# Where the camera stands, seen from what it looks at, for a robot that gets so far away from there [m]; ours.
_CAMERA_M, _FAR_M = np.array([0.4, -0.65, 0.45]), 0.65


@dataclass(frozen=True, eq=False)
class View:
    """A drawn scene with what is said beside it; equal input gives equal pages.

    Attributes:
        window: What was drawn.
        overlay: What is said.
    """

    window: RecordingWindow
    overlay: Overlay

    def html(self) -> str:
        """One page with the motion, which needs no server, no other file and no address."""
        return scene_html(self.window, self.overlay.title, self.overlay)

    def save(self, path: str | Path) -> Path:
        """Write the page atomically; return where it is."""
        write_scene(Path(path), self.window, self.overlay.title, self.overlay)
        return Path(path)

    def show(self, *, open_browser: bool = True) -> LiveView:
        """Show the scene live, on a meshcat server of its own that ends with this process."""
        return show_live(self.window, open_browser=open_browser)


def view(
    robot: Robot,
    estimate: PartEstimate | None = None,
    plan: GraspPlan | Failure | None = None,
    *,
    part: Part | None = None,
    world: World | None = None,
    reach: ReachMap | None = None,
    at: Configuration | None = None,
) -> View:
    """Draw a grasp.

    Args:
        robot: Robot; with a tool where candidates are to be drawn.
        estimate: Where the part is, in the present base frame, which is the scene's world.
        plan: What is to be done, or why nothing can be; a failure's candidates are drawn as well.
        part: What is grasped.
        world: Obstacles, in the present base frame.
        reach: What the arm reaches, drawn from where the base stands at the grasp.
        at: The robot where there is no motion; in its posture "scan", or at rest, if None.

    Raises:
        InputError: If the plan was made for another robot or part, or the part for another estimate.
    """
    _check_same_part(estimate, plan, part)
    scene, layers = RobotScene(), [Layer("robot", "robot", None)]
    sound = plan if isinstance(plan, GraspPlan) else None
    T_world_part = _where_part(estimate, sound, part)
    if part is not None and T_world_part is not None:
        scene.draw_part(part, Pose2(), part.tags.points_m)
        scene.move_part([T_world_part])
        layers.append(Layer("part", "part", colours.PART))
    stages = () if sound is None else _draw_motion(scene, robot, sound)
    still = robot.visual_shapes(at or _at_rest(robot))
    if not stages:
        scene.draw_robot([still])
    if estimate is not None:
        layers += grasp_layers.draw_belief(scene, estimate)
    if world is not None:
        layers += grasp_layers.draw_obstacles(scene, world)
    if reach is not None:
        base = Pose2() if sound is None else sound.base
        layers.append(grasp_layers.draw_reach_layer(scene, reach, base, shown=plan is None))
    candidates = plan.candidates if isinstance(plan, GraspPlan | GraspFailure) else ()
    if sound is not None:
        T_world_hand = homogeneous(sound.base) @ sound.T_base_hand
        layers.append(grasp_layers.draw_chosen(scene, robot.tool, sound.aperture_m, T_world_hand))
    if candidates and T_world_part is not None:
        layers += grasp_layers.draw_candidates(scene, robot.tool, candidates, T_world_part, shown=sound is None)
    _aim(scene, still, T_world_part)
    graded = any(row.score is not None for row in candidates)
    title = robot.name if part is None else f"{robot.name}: {part.part_id}"
    return View(scene.window, Overlay(title, facts(estimate, plan), tuple(layers), stages, success_scale=graded))


def facts(estimate: PartEstimate | None, plan: GraspPlan | Failure | None) -> tuple[tuple[str, str], ...]:
    """What a page says of an estimate and a plan, in words and numbers: rows of name and value."""
    rows: list[tuple[str, str]] = []
    if estimate is not None:
        x, y = 100 * estimate.centre_m
        turn = "unknown" if estimate.theta_rad is None else f"{np.rad2deg(estimate.theta_rad):.1f}°"
        rows.append(("estimate", f"x {x:.1f} cm, y {y:.1f} cm, θ {turn}, by {estimate.method}"))
    if isinstance(plan, Failure):
        rows.append(("no grasp", f"{plan.kind.replace('_', ' ')}: {plan.message}"))
    elif plan is not None:
        rows += _plan_facts(plan)
    if isinstance(plan, GraspPlan | GraspFailure) and plan.candidates:
        rejected = sum(row.rejection is not None for row in plan.candidates)
        rows.append(("grasps looked at", f"{len(plan.candidates)}, {rejected} of them rejected"))
    return tuple(rows)


def _plan_facts(plan: GraspPlan) -> list[tuple[str, str]]:
    chance = plan.success_probability
    rows = [] if chance is None else [("success", f"{chance:.2f} ± {plan.success_sd:.2f}")]
    rows += [(f"fails: {kind.replace('_', ' ')}", f"{share:.1%}") for kind, share in plan.risks if share > 0]
    rows.append(("jaws", f"{1e3 * plan.aperture_m:.0f} mm open, {1e3 * plan.closed_m:.0f} mm closed"))
    rows.append(("clearance", f"{1e3 * plan.clearance_m:.1f} mm at least"))
    rows.append(("time", f"{plan.duration_s:.1f} s"))
    return rows if plan.advice is None else [*rows, ("advice", plan.advice.message)]


def _draw_motion(scene: RobotScene, robot: Robot, plan: GraspPlan) -> tuple[StageMark, ...]:
    """Play the plan; a plan without stages is shown at the grasp."""
    if not plan.stages:
        at_grasp = robot.configuration(plan.configuration, plan.base)
        scene.draw_robot([robot.visual_shapes(at_grasp)])
        return (StageMark("grasp", 0.0),)
    motion = play(plan, robot)
    pictures = [robot.visual_shapes(configuration) for configuration in motion.configurations]
    scene.draw_robot(pictures, times_s=motion.times_s)
    scene.move_part(motion.parts, motion.times_s)
    return motion.stages


def _at_rest(robot: Robot) -> Configuration:
    return robot.posture("scan") if "scan" in robot.description.postures else robot.configuration()


def _aim(scene: RobotScene, robot: Sequence[PlacedShape], T_world_part: FloatArray | None) -> None:
    """Look at the part, or at the ground before the robot, from far enough to see both."""
    target_m = np.array([0.3, 0.0, 0.1]) if T_world_part is None else T_world_part[:3, 3]
    far_m = max((float(np.linalg.norm(shape.T_world_shape[:3, 3] - target_m)) for shape in robot), default=0.0)
    scene.look_at(target_m, _CAMERA_M * max(1.0, far_m / _FAR_M))


def _where_part(estimate: PartEstimate | None, plan: GraspPlan | None, part: Part | None) -> FloatArray | None:
    """Where the part is believed to lie, in the world: the plan's own word for it if there is one."""
    if plan is not None:
        return np.asarray(homogeneous(plan.base) @ plan.T_base_hand @ np.linalg.inv(plan.T_part_hand))
    if estimate is None or estimate.theta_rad is None:
        return None
    height_m = estimate.height_m if part is None else part.resting_height_m
    return homogeneous(as_pose2([*estimate.centre_m, estimate.theta_rad]), height_m)


def _check_same_part(estimate: PartEstimate | None, plan: GraspPlan | Failure | None, part: Part | None) -> None:
    named = {
        "estimate": "" if estimate is None else estimate.part_id,
        "plan": plan.part_id if isinstance(plan, GraspPlan) else "",
        "part": "" if part is None else part.part_id,
    }
    if len({name for name in named.values() if name}) > 1:
        told = ", ".join(f"the {what} is of {name}" for what, name in named.items() if name)
        raise InputError(f"these do not belong together: {told}", **named)
