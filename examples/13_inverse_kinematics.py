"""Inverse kinematics of a five-joint arm: where the hand can be, where it cannot, and why.

Five joints cannot hold a tool in any pose. A grasp task asks only for what a grasp needs: the tool's place, the
direction that it points in and the direction that the jaws close along, each of which may be free.

You will see the hand placed around a table leg, lifted with it along a straight line, four tasks that fail and the
reason of each, where the base must stand for a leg that is 1.5 m away and only roughly known, and get `grasp.html`,
a page with the robot lifting the leg over a map of where it can grasp. Takes 10 s.
"""

import sys
from pathlib import Path

import numpy as np

from planners import IkRules, InverseKinematics, MapMaker, PartGrasp, TaskMap, best_base_pose, move_straight, top_down
from rfcompass import PartDatabase, PartEstimate, Pose2, Robot, YouBot
from rfcompass.robots import CollisionModel
from rfcompass.types import Body, GraspTask, SearchVolume, World
from rfcompass.viz.meshcat_page import write_scene
from rfcompass.viz.robot_scene import RobotScene

DOWN, FORE_AFT, SIDEWAYS = np.array([0, 0, -1.0]), np.array([1.0, 0, 0]), np.array([0, 1.0, 0])
HAND = ("gripper_palm_link", "gripper_finger_link_l", "gripper_finger_link_r", "floor")


def main(fast: bool = False, out: Path = Path("runs/13_grasp")) -> float:
    """Grasp, lift, fail and drive; return the probability that the far leg is in reach from the best place."""
    robot, leg = YouBot(), PartDatabase().part("table_leg_3")
    scan = robot.posture("scan")
    pose = Pose2(0.42, 0.0, np.pi / 2)  # the leg lies across, in front of the base
    T_world_leg = np.eye(4)
    T_world_leg[:2, :2], T_world_leg[:3, 3] = pose.rotation, (0.42, 0.0, 0.025)
    world = World((Body("leg", leg.shape, T_world_leg),))

    grasp = GraspTask([0.42, 0.0, 0.03], DOWN, FORE_AFT)
    around = InverseKinematics(robot, world)
    solution = around.solve(grasp, scan)
    near = solution.clearance
    print(f"around the leg by {solution.method}: {np.rad2deg(solution.configuration.joints[:5]).round(1)} degrees")
    print(f"  nearest: {near.first} and {near.second}, {near.distance_m * 1e3:.1f} mm apart")

    T_tool_leg = np.linalg.inv(robot.tool_pose(solution.configuration).homogeneous) @ T_world_leg
    held = world.attach("leg", "gripper_tool_link", T_tool_leg, HAND)
    carrying = InverseKinematics(robot, model=CollisionModel(robot, held))
    lift = move_straight(carrying, grasp, solution.configuration, np.array([0.0, 0.0, 0.10]))
    print(f"lifted by 10 cm in {len(lift.path)} waypoints, {lift.deviation_m * 1e3:.2f} mm off the line at most")

    print("what fails, and why")
    for task in (
        GraspTask([0.42, 0.0, 0.03], DOWN, SIDEWAYS),
        GraspTask([0.55, 0.0, 0.08], FORE_AFT),
        GraspTask([0.80, 0.0, 0.30], FORE_AFT),
        GraspTask([0.30, 0.0, 0.03], DOWN, FORE_AFT),
    ):
        failure = around.solve(task, scan)
        print(f"  {failure.kind}: {failure.message}")

    reach = ahead(robot, fast)
    probability = drive(reach)

    scene = RobotScene()
    scene.draw_reach(reach.reach_map, Pose2())
    ends = [robot.configuration(q) for q in (scan.joints, *lift.reversed_path, *lift.path)]
    scene.draw_robot([robot.visual_shapes(configuration) for configuration in ends], seconds_per_stop=0.2)
    scene.draw_part(leg, pose, leg.tags.points_m[:2])
    scene.look_at(np.array([0.3, 0.0, 0.1]), np.array([0.6, -0.8, 0.5]))
    out.mkdir(parents=True, exist_ok=True)
    write_scene(out / "grasp.html", scene.window, "Inverse kinematics of a grasp")
    print(f"picture: {out / 'grasp.html'}")
    return probability


def ahead(robot: Robot, fast: bool) -> TaskMap:
    """Which grasps from above the arm can do in front of the base, at two heights of the tool."""
    spacing_m = 0.04 if fast else 0.02
    quick = InverseKinematics(robot, rules=IkRules(certify=False, explain=False))
    volume = SearchVolume([0.24, -0.2, 0.03], [0.56, 0.2, 0.03 + spacing_m])
    reach = MapMaker(ik=quick, spacing_m=spacing_m).make(volume, top_down(12), robot.posture("scan"))
    print(f"a map of {reach.reached.size} grasps from above: the arm can do {reach.reached.mean():.0%}")
    return reach


def drive(reach: TaskMap) -> float:
    """Where to drive for a leg 1.5 m away that is known to 3 cm and 10 degrees."""
    covariance = np.diag([0.03**2, 0.03**2, np.deg2rad(10) ** 2])
    estimate = PartEstimate("table_leg_3", np.array([1.2, 0.9]), 0.4, "told", 1, covariance=covariance)
    along = [PartGrasp([u, 0.0], np.pi / 2, 0.03) for u in (-0.1, 0.0, 0.1)]
    place = best_base_pose(estimate, reach, along, rng=np.random.default_rng(0))
    x, y, theta = place.base.x_m, place.base.y_m, np.rad2deg(place.base.theta_rad)
    print(f"drive to x {x:.2f} m, y {y:.2f} m, {theta:.0f} degrees: in reach with probability {place.probability:.2f}")
    return place.probability


if __name__ == "__main__":
    main(fast="--fast" in sys.argv)
