"""What a robot over a socket costs: each command through `rfcompass-robot-link/1` beside a direct call.

The robot is the simulated one, in the same process as client and server, on the loopback address. Times are of the
clock on the wall, since a round trip mostly waits, the least of all calls. "Ours" is the command through the socket,
"peer" the same call without; the difference is what the link adds. Differ: by how much the last answers differ.

Run `python -m benchmarks.bench_link`; some seconds.
"""

import argparse
import time
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from benchmarks.timing import Timing, show
from rfcompass.geometry import Pose2
from rfcompass.recordings import PartDatabase
from rfcompass.recordings.robot_link import RemoteRobot, RobotServer
from rfcompass.robots import YouBot
from rfcompass.simulation import NoisyDistances, PlaneRoom, SimulatedRobot
from rfcompass.studies.radio_setup import RadioSetup
from rfcompass.types import Observation

ROBOT, LEG = YouBot(), PartDatabase(":memory:").part("table_leg_3")
LAYOUT = LEG.layout(4)
ROOM = PlaneRoom(T_room_base=Pose2(2.5, 2.5, 0.4), T_room_part=Pose2(3.0, 2.9, 1.2))
JOINTS = ROBOT.posture("scan").joints


def run(fast: bool = False) -> list[Timing]:
    """Time a drive, a motion of the arm, and scans without and with a radio."""
    many, few = (20, 2) if fast else (2000, 20)
    still = Pose2()
    return [
        _line("drive", many, False, lambda robot: robot.move_base(still).theta_rad),
        _line("arm", many, False, lambda robot: robot.move_arm(JOINTS) or 0.0),
        _line("scan, 36 distances", many, False, lambda robot: _sum(robot.scan())),
        _line("scan, 13 tags by radio", few, True, lambda robot: _sum(robot.scan())),
    ]


def _line(name: str, calls: int, radio: bool, command: Callable[[Any], float]) -> Timing:
    direct_s, answer = _least(calls, _robot(radio), command)
    with (
        RobotServer(_robot(radio), ROBOT.name, ROBOT.joint_names) as server,
        RemoteRobot(server.host, server.port, ROBOT, LEG, LAYOUT) as remote,
    ):
        linked_s, through = _least(calls, remote, command)
    return Timing(f"{name}, x {calls}", linked_s, "direct call", direct_s, abs(through - answer))


def _robot(radio: bool) -> SimulatedRobot:
    rng = np.random.default_rng(0)
    sensor = RadioSetup().sensor(ROOM, ROBOT.layout, LAYOUT, rng) if radio else NoisyDistances(0.05)
    return SimulatedRobot(ROBOT, LEG, LAYOUT, ROOM, rng, JOINTS, sensor)


def _least(calls: int, robot: object, command: Callable[[Any], float]) -> tuple[float, float]:
    """Least time of a call on the wall [s], the first one left out, and the last answer."""
    times_s = []
    for _ in range(calls + 1):
        start_s = time.perf_counter()
        answer = command(robot)
        times_s.append(time.perf_counter() - start_s)
    return min(times_s[1:]), answer


def _sum(seen: Observation) -> float:
    """One number that everything heard goes into."""
    heard = sum(complex(trace.channel.sum()) for trace in seen.scan.traces.values())
    return abs(heard) + (0.0 if seen.proximity is None else float(np.nansum(seen.proximity.m)))


def main(argv: Sequence[str] | None = None) -> int:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--fast", action="store_true", help="few calls, to see that it works")
    show(run(parser.parse_args(argv).fast))
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
