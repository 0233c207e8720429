"""A robot that counts what it does and can be made slow, and a line client that says whatever one likes."""

import json
import socket
import threading

import numpy as np

from rfcompass.errors import JointLimitError
from rfcompass.geometry import Pose2
from rfcompass.recordings import PartDatabase
from rfcompass.robots import YouBot
from rfcompass.types import Failure, GraspOutcome, Observation, RobotState

ROBOT = YouBot()
LEG = PartDatabase(":memory:").part("table_leg_3")
LAYOUT = LEG.layout(4)
JOINTS = ROBOT.joint_names


class ScriptedRobot:
    """Believes what it is told; `hold` stops it in the middle of a drive until `go` is set."""

    def __init__(self):
        self.moves, self.arm_moves, self.scans = [], 0, 0
        self.base, self.joints = Pose2(), ROBOT.posture("scan").joints
        self.hold, self.go, self.driving = False, threading.Event(), threading.Event()

    def state(self):
        return RobotState(self.joints, self.base, np.diag([1e-4, 2e-4, 3e-5]))

    def move_base(self, T_base_goal):
        self.moves.append(T_base_goal)
        self.driving.set()
        if self.hold:
            assert self.go.wait(20.0)
        self.base = self.base @ T_base_goal
        return T_base_goal

    def move_arm(self, joints):
        if np.abs(joints).max() > 6.0:
            raise JointLimitError("too far", joint="arm_joint_1", value=float(np.abs(joints).max()), upper=np.inf)
        self.joints, self.arm_moves = np.array(joints), self.arm_moves + 1

    def close_hand(self):
        return GraspOutcome(False, Failure("nothing_held", "the jaws met", (("width_m", 0.0), ("side", "left"))))

    def scan(self):
        self.scans += 1
        if self.scans == 3:
            raise ZeroDivisionError("the reader's driver is broken")
        anchors = ROBOT.tag_positions(ROBOT.configuration(self.joints))
        heights_m = LAYOUT.points_m[:, 2] + LEG.resting_height_m
        return Observation(self.scans - 1, anchors, LAYOUT, heights_m, base_pose=self.base)


class LineClient:
    """A socket that sends bytes and reads lines."""

    def __init__(self, server):
        self.socket = socket.create_connection((server.host, server.port), 10.0)
        self.lines = self.socket.makefile("rb")

    def say(self, content):
        self.socket.sendall(content if isinstance(content, bytes) else json.dumps(content).encode() + b"\n")

    def hear(self):
        """The next frame, None once the server has hung up."""
        line = self.lines.readline()
        return json.loads(line) if line else None

    def ask(self, content):
        self.say(content)
        return self.hear()

    def hello(self, session="a", schema="rfcompass-robot-link/1"):
        return self.ask({"id": 0, "command": "hello", "schema": schema, "session": session})

    def close(self):
        self.lines.close()
        self.socket.close()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()
