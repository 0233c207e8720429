"""A robot over a socket: the same loop drives a robot that is no Python object.

A real robot stands behind `rfcompass-robot-link/1`: lines of JSON over TCP, which a node of ROS 2 or a few lines in any
language can speak (docs/robot_link.md). Here `rfcompass robots serve` plays the robot, in a process of its own; with
`--device HOST:PORT` the loop talks to whatever listens there.

You will see what the robot says about itself, each stop of the loop, a drive whose answer is lost and that is done once
all the same, and get `fetched.html`. Takes 15 s.
"""

import json
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from planners.fetch import Fetch, FetchStep
from rfcompass import ConsistencyLocalizer, PartDatabase, Pose2, YouBot, view
from rfcompass.errors import RobotLost
from rfcompass.recordings.robot_link import RemoteRobot

PART = "table_leg_3"


@contextmanager
def a_served_robot() -> Iterator[tuple[str, int]]:
    """Start `rfcompass robots serve` in another process; say where it listens."""
    arguments = ["robots", "serve", PART, "--no-radio", "--seed", "1", "--port", "0", "--json"]
    code = f"import sys; from rfcompass.cli import main; sys.argv[1:] = {arguments}; main()"
    with subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, text=True) as process:
        try:
            told = json.loads(process.stdout.readline() if process.stdout else "{}")
            yield told["host"], told["port"]
        finally:
            process.terminate()


def fetch(device: RemoteRobot, robot: YouBot) -> list[FetchStep]:
    """Find the part; nothing here knows that the robot is elsewhere."""
    steps = []
    for step in Fetch(robot, device, ConsistencyLocalizer(), robot.posture("scan")).steps():
        steps.append(step)
        x_m, y_m = step.estimate.centre_m
        print(f"{step.phase:<9} stop {step.observation.stop_id}: part at {x_m:5.2f}, {y_m:5.2f} m from the base")
    return steps


def drive_once(host: str, port: int, device: RemoteRobot) -> Pose2:
    """Lose the answer to a drive, come back, and ask for it again."""
    before = device.state().base
    device.close()  # one client at a time
    leg = PartDatabase().part(PART)
    with RemoteRobot(host, port, YouBot(), leg, leg.layout(4), command_s=0.0) as hasty:  # waits for no answer at all
        try:
            hasty.move_base(Pose2(-0.10, 0.0, 0.0))
        except RobotLost as lost:
            print(f"lost: {lost.message}")
        hasty.reconnect()
        hasty.repeat_unanswered(wait_s=10.0)
        driven = before.inverse() @ hasty.state().base
    print(f"asked for twice, driven once: {driven.x_m:.2f} m")
    return driven


def run(host: str, port: int, out: Path) -> Pose2:
    """Fetch, then drive back by ten centimetres."""
    robot, leg = YouBot(), PartDatabase().part(PART)
    with RemoteRobot(host, port, robot, leg, leg.layout(4)) as device:
        print(f"{device.greeting.robot} can {', '.join(device.greeting.capabilities)}")
        last = fetch(device, robot)[-1]
        driven = drive_once(host, port, device)
    out.mkdir(parents=True, exist_ok=True)
    page = out / "fetched.html"
    view(robot, last.estimate, part=leg, at=robot.configuration(last.configuration.joints)).save(page)
    print(f"page: {page}")
    return driven


def main(fast: bool = False, out: Path = Path("runs/17_over_a_socket"), device: str | None = None) -> Pose2:  # noqa: ARG001
    """Talk to a device that is there, or to one of our own; return how far it drove in the end."""
    if device is not None:
        host, _, port = device.rpartition(":")
        return run(host, int(port), out)
    with a_served_robot() as (host, port):
        return run(host, port, out)


if __name__ == "__main__":
    main(device=sys.argv[sys.argv.index("--device") + 1] if "--device" in sys.argv else None)
