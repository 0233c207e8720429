"""`rfcompass fetch PART --device HOST:PORT`: the same job with a robot behind a socket in place of a simulated one."""

from collections.abc import Mapping
from functools import partial
from typing import TYPE_CHECKING

import typer

from rfcompass.cli.output import messages
from rfcompass.errors import InputError

if TYPE_CHECKING:
    from rfcompass.cli.fetch_task import FetchOptions
    from rfcompass.studies.remote_fetching import RemoteTask

# What only the room of a simulation has, and what needs more than the link can command, by parameter of `fetch`.
_OF_A_ROOM = ("seed", "scene", "occluded", "others", "on_map", "sigma", "all_of", "deliver", "silent")


def fetch_with_device(device: str, task: "RemoteTask", asked: Mapping[str, object], options: "FetchOptions") -> None:
    """Fetch a part with the robot that listens there, leave the run folder, print the answer.

    Args:
        device: `HOST:PORT`.
        task: What to fetch.
        asked: What was asked for, for the run folder.
        options: What becomes of the answer.

    Raises:
        InputError: If the address is none.
        RobotLinkError: If the robot cannot be reached, is busy, or lacks a command.
        RobotModelError: If it is another robot.
        NoAnswer: If the part was not located; what was heard until then is in the run folder.
        typer.Exit: If it was located and not grasped.
    """
    from rfcompass.cli.fetch import fetch_one
    from rfcompass.recordings import check_target
    from rfcompass.recordings.robot_link import RemoteRobot
    from rfcompass.studies.remote_fetching import RemoteFetch, check_able
    from rfcompass.studies.remote_trace import remote_trace

    host, port = address_of(device)
    check_target(options.target, overwrite=options.overwrite)
    with RemoteRobot(host, port, task.robot, task.part, task.layout) as remote:
        check_able(remote, grasp=options.grasp and task.tags > 1)
        name = remote.greeting.robot
        messages().print(f"{name} at {device}: the antenna drives its own track, the base straight", markup=False)
        trace_of = partial(remote_trace, task.robot, robot_name=name)
        fetch_one(RemoteFetch(task, remote), task, asked, options, trace_of)


def refuse_options_of_a_room(context: typer.Context, parts: int) -> None:
    """Refuse what a robot behind a socket cannot be asked for.

    Args:
        context: Tells which options were given.
        parts: How many parts.

    Raises:
        InputError: If one of these options was given, or there are several parts; carries the `options`.
    """
    given = [
        parameter.opts[0]
        for parameter in context.command.params
        if parameter.name in _OF_A_ROOM and _was_given(context, parameter.name)
    ]
    if given:
        message = f"{', '.join(given)}: only in a simulated room, not with --device"
        raise InputError(message, options=given)
    if parts > 1:
        raise InputError(f"--device fetches one part, not {parts}: nothing tells it to open its hand", parts=parts)


def _was_given(context: typer.Context, name: str) -> bool:
    source = context.get_parameter_source(name)
    return source is not None and source.name != "DEFAULT"


def address_of(device: str) -> tuple[str, int]:
    """Read `HOST:PORT`; an IPv6 address may stand in brackets.

    Raises:
        InputError: If it is something else; carries what was `got`.
    """
    host, _, port = device.rpartition(":")
    if not host or not port.isdecimal() or not 0 < int(port) < 1 << 16:
        raise InputError(f"--device {device}: expected HOST:PORT, such as 127.0.0.1:5090", got=device)
    return host.removeprefix("[").removesuffix("]"), int(port)
