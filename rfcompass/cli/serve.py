"""`rfcompass robots serve PART`: a simulated robot in a room, behind a socket."""

import signal
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated

import typer

from rfcompass.cli.output import JsonFlag, answering, messages, print_json


def serve(
    part: Annotated[str, typer.Argument(help="Part that lies in the room, by its name in the part database.")],
    seed: Annotated[int, typer.Option(min=0, help="Start poses and all noise follow from it.")] = 0,
    tags: Annotated[int, typer.Option(min=1, help="Number of tags on the part.")] = 4,
    scene: Annotated[str, typer.Option(help="Room, by name or recipe file.")] = "room_los",
    radio: Annotated[bool, typer.Option(help="Hear by radio; else distances with noise.")] = True,
    robot: Annotated[str, typer.Option(help="Robot that has a posture 'scan', by name or file.")] = "youbot",
    host: Annotated[str, typer.Option(help="Address to listen on; whoever reaches it moves the robot.")] = "127.0.0.1",
    port: Annotated[int, typer.Option(min=0, max=65535, help="TCP port; any free one if 0.")] = 5090,
    database: Annotated[Path | None, typer.Option(help="Part database; by default the user's own.")] = None,
    as_json: JsonFlag = False,
) -> None:
    """Put a simulated robot behind rfcompass-robot-link/1, as a bridge does with a real one; Ctrl-C ends it."""
    from rfcompass.recordings import PartDatabase
    from rfcompass.recordings.robot_link import RobotServer
    from rfcompass.robots import load_robot
    from rfcompass.studies.fetch_modes import NOISY_DISTANCE, Mode, fetch_mode
    from rfcompass.studies.fetching import FetchTask, SimulatedFetch

    with answering(as_json):
        how = fetch_mode(Mode.BEST, None if radio else NOISY_DISTANCE).in_scene(scene=scene)
        with PartDatabase(database) as parts:
            task = FetchTask(
                robot=load_robot(robot), part=parts.part(part), tags=tags, localizer=how.localizer, seed=seed,
                radio=how.radio,
            )  # fmt: skip
        name, device = task.robot.name, SimulatedFetch(task).device
        with _signal() as ended, RobotServer(device, name, task.robot.joint_names, host=host, port=port) as server:
            messages().print(f"{name} listens on {server.host}:{server.port}; Ctrl-C ends it", markup=False)
            if as_json:
                print_json({"robot": name, "host": server.host, "port": server.port})
                sys.stdout.flush()
            ended.wait()


@contextmanager
def _signal() -> Iterator[threading.Event]:
    """An event that the first Ctrl-C or SIGTERM sets, so that the robot ends what it does."""
    ended = threading.Event()
    before = {number: signal.signal(number, lambda *_: ended.set()) for number in (signal.SIGINT, signal.SIGTERM)}
    try:
        yield ended
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
