"""A robot over a socket: `rfcompass-robot-link/1`, see `docs/robot_link.md`."""

from rfcompass.recordings.robot_link.frames import SCHEMA, decode_frame, encode_frame
from rfcompass.recordings.robot_link.heard import reads_json
from rfcompass.recordings.robot_link.link import Greeting, RobotLink
from rfcompass.recordings.robot_link.remote_robot import RemoteRobot
from rfcompass.recordings.robot_link.served_device import Device, ServedDevice
from rfcompass.recordings.robot_link.server import RobotServer

__all__ = [
    "SCHEMA",
    "Device",
    "Greeting",
    "RemoteRobot",
    "RobotLink",
    "RobotServer",
    "ServedDevice",
    "decode_frame",
    "encode_frame",
    "reads_json",
]
