"""Tags on a moving arm: why forward kinematics runs at every stop.

The robot's hand carries four tags. When the arm moves, so do they, and every comparison cuts the plane along
another line. Assuming that "the placement of the robot's tags does not change", as the paper's text does, puts
those lines decimetres away from where they are.

You will see where the hand's tags are in three postures, how fast they move with each joint, and get `arm.html`,
a page with the robot and its tags moving. Takes 3 s.
"""

import sys
from pathlib import Path

import numpy as np

from rfcompass import YouBot
from rfcompass.viz.meshcat_page import write_scene
from rfcompass.viz.robot_scene import RobotScene


def main(fast: bool = False, out: Path = Path("runs/03_arm")) -> float:
    """Move the arm; return how far the left hand tag travels from folded to scanning [m]."""
    robot = YouBot()
    left = robot.layout.with_role("hand_left")[0]

    print("left hand tag in the base frame [m]")
    for name in ("folded", "candle", "scan"):
        x, y, z = robot.tag_positions(robot.posture(name)).points_m[left]
        print(f"  {name:<8} {x:6.3f} {y:6.3f} {z:6.3f}")

    scan = robot.posture("scan")
    speeds = np.linalg.norm(robot.tag_jacobians(scan)[left], axis=0)
    print("its speed when one joint turns at 1 rad/s [m/s]")
    for joint, speed in zip(robot.joint_names, speeds, strict=True):
        if joint in robot.arm_joints:
            print(f"  {joint:<12} {speed:.3f}")

    between = np.linspace(robot.posture("folded").joints, scan.joints, 3 if fast else 20)
    paths_m = robot.tag_positions_batch(between)[:, left]
    travel_m = float(np.linalg.norm(np.diff(paths_m, axis=0), axis=1).sum())
    print(f"from folded to scan it travels {travel_m:.2f} m")

    scene = RobotScene()
    scene.draw_robot([robot.visual_shapes(robot.configuration(joints)) for joints in between], seconds_per_stop=0.15)
    scene.look_at(np.array([0.2, 0.0, 0.2]), np.array([0.7, -1.1, 0.7]))
    out.mkdir(parents=True, exist_ok=True)
    write_scene(out / "arm.html", scene.window, "Tags on a moving arm")
    print(f"picture: {out / 'arm.html'}")
    return travel_m


if __name__ == "__main__":
    main(fast="--fast" in sys.argv)
