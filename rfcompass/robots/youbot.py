"""The KUKA youBot of RF-Compass, and the numbers of it that a URDF has no place for."""

from rfcompass.robots.description import load_description
from rfcompass.robots.layouts import data_folder
from rfcompass.robots.robot import Robot

# [Wang2013]: footprint, speed limits and payload of the robot in the experiments.
BASE_LENGTH_M = 0.58
BASE_WIDTH_M = 0.38
MAX_SPEED_M_S = 0.8
MAX_TURN_RAD_S = 1.0
PAYLOAD_KG = 0.5

# What the driver's odometry assumes: rolling radius of a wheel, and half the distances between wheel contacts.
# The URDF draws wheels of radius 0.050; a mecanum wheel rolls on a smaller one.
WHEEL_ROLLING_RADIUS_M = 0.0475
HALF_WHEELBASE_M = 0.235
HALF_TRACK_M = 0.150


def YouBot(layout: str = "x4") -> Robot:
    """Make the youBot: planar base, five arm joints, two fingers, tags.

    Postures: "folded", "candle" (arm upright) and "scan" (tool straight down, tips 0.10 m above the floor and
    0.42 m ahead of the base centre, hand open).

    Args:
        layout: "x4" (nine tags, default), "l0" (nine tags, as the paper's text suggests), "skew6" (six tags), another
            of `known_layouts()`, or the path of a JSON file.

    Raises:
        UnknownRobot: If there is no such layout; lists those that there are.
        RobotModelError: If the layout does not fit the robot.
    """
    return Robot(load_description(data_folder() / "robots" / "youbot.json", layout))
