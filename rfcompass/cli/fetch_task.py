"""`rfcompass fetch` for several parts: the planned actions, one part after the other, and the folder of the task."""

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import typer

from rfcompass.arrays import plain
from rfcompass.cli.estimates import one_line
from rfcompass.cli.fetch_task_json import Delivered, actions_json, answers_json, events_json, pose_json
from rfcompass.cli.output import EXIT_NO_ANSWER, messages, print_json
from rfcompass.errors import InputError, NoAnswer

if TYPE_CHECKING:
    from planners.task import Action, PartTask
    from rfcompass.cli.fetch import Fetched
    from rfcompass.geometry.pose2 import Pose2
    from rfcompass.robots import Robot
    from rfcompass.studies.fetching import FetchTask
    from rfcompass.studies.task_fetching import JudgedPutDown, SimulatedTask
    from rfcompass.studies.task_film import FilmReel
    from rfcompass.types.parts import Part
    from rfcompass.viz.grasp_view import View


@dataclass(frozen=True, slots=True)
class FetchOptions:
    """Options that only several parts have, or that say what becomes of the answer.

    Attributes:
        deliver: `x,y,theta` as given; a row at the start if None.
        silent: Parts whose tags are broken.
        target: Folder of the task.
        grasp: False where no part is to be grasped, which is refused.
        overwrite: Replace a task that is already there.
        show: Open its page.
        as_json: Print the answer.
    """

    deliver: str | None
    silent: tuple[str, ...]
    target: Path
    grasp: bool
    overwrite: bool
    show: bool
    as_json: bool


def fetch_and_deliver(
    task: "FetchTask", parts: "Sequence[Part]", asked: Mapping[str, object], options: FetchOptions
) -> None:
    """Fetch and deliver several parts, leave the folder of the task, print the answer.

    Raises:
        InputError: If an option cannot be.
        typer.Exit: If one of the parts was not delivered.
    """
    import webbrowser

    from planners.task import plan_task, row_at_the_start
    from rfcompass.recordings import check_task_target

    if not options.grasp or task.tags < 2:
        message = "a part is delivered in the hand: that needs a grasp, and an orientation, which one tag does not tell"
        raise InputError(message, grasp=options.grasp, tags=task.tags)
    _check_silent(options.silent, parts)
    check_task_target(options.target, overwrite=options.overwrite)
    first = row_at_the_start(parts) if options.deliver is None else deliver_pose(options.deliver)
    planned = plan_task(parts, task.tags, first, task.spacing)
    with filming(task.robot, show=options.show) as reel:
        done = _fetched(task, planned, options.silent, asked, reel)
    _write(reel, done, {**asked, "deliver": pose_json(first), "silent": options.silent}, options)
    count = sum(one.delivered for one in done)
    messages().print(f"{count} of {len(done)} parts delivered; folder of the task: {options.target}", markup=False)
    if options.show:
        webbrowser.open((options.target / "view.html").resolve().as_uri())
    if options.as_json:
        print_json({"parts": answers_json(done, options.target), "actions": actions_json(done)})
    if count < len(done):
        raise typer.Exit(EXIT_NO_ANSWER)


def _write(reel: "FilmReel", done: "Sequence[Delivered]", asked: Mapping[str, object], options: FetchOptions) -> None:
    from rfcompass.recordings import TaskRun, write_task
    from rfcompass.studies.versions import software_versions

    runs = {one.wanted.part.part_id: one.run for one in done if one.run is not None}
    pictures = {}
    if reel.film.times_s:
        pictures["view.html"] = lambda path: _film(reel, done).save(path)
    kept = plain({**asked, "parts": [one.wanted.part.part_id for one in done], "versions": software_versions()})
    task_run = TaskRun(kept, actions_json(done), events_json(done), runs, pictures)
    write_task(task_run, options.target, overwrite=options.overwrite)


def _film(reel: "FilmReel", done: "Sequence[Delivered]") -> "View":
    """All of the task in one page with a slider for the time."""
    from rfcompass.viz.task_film import draw_film

    said = [(one.wanted.part.part_id, "delivered" if one.delivered else "not delivered") for one in done]
    return draw_film(reel.robot, reel.film, said)


@contextmanager
def filming(robot: "Robot", *, show: bool) -> Iterator["FilmReel"]:
    """Collect what happens; show it live in a browser while it happens, if that is wanted."""
    from rfcompass.studies.fetching import SCAN_POSTURE
    from rfcompass.studies.task_film import FilmReel
    from rfcompass.viz.live_task import LiveTask

    screen = LiveTask(robot, robot.posture(SCAN_POSTURE)) if show else None
    try:
        yield FilmReel(robot, screen)
    finally:
        if screen is not None:
            screen.close()


def deliver_pose(text: str) -> "Pose2":
    """Read `x,y,theta`.

    Raises:
        InputError: If these are no three finite numbers.
    """
    import math

    from rfcompass.geometry.pose2 import Pose2

    try:
        x_m, y_m, theta_rad = map(float, text.split(","))
    except ValueError as cause:
        raise InputError(f"--deliver {text}: expected x,y,theta in metres and radians", got=text) from cause
    if not all(map(math.isfinite, (x_m, y_m, theta_rad))):
        raise InputError(f"--deliver {text}: not finite", got=text)
    return Pose2(x_m, y_m, theta_rad)


def _check_silent(silent: Sequence[str], parts: "Sequence[Part]") -> None:
    """Refuse silent parts that nobody fetches."""
    if unknown := sorted(set(silent) - {part.part_id for part in parts}):
        raise InputError(f"--silent {', '.join(unknown)}: not among the parts to fetch", parts=unknown)


def _fetched(
    task: "FetchTask",
    planned: "Sequence[PartTask]",
    silent: Sequence[str],
    asked: Mapping[str, object],
    reel: "FilmReel",
) -> list[Delivered]:
    """Print what is planned, then fetch and deliver each part; one that ends early leaves the others to be fetched.

    Args:
        task: How to fetch; its part is the first.
        planned: What to do with each part.
        silent: Names of parts whose tags are broken.
        asked: What was asked for, for the run folders.
        reel: Collects what happens.
    """
    from rfcompass.studies.task_fetching import SimulatedTask

    console = messages()
    for action in _actions(planned):
        console.print(f"planned   {action}", markup=False)
    parts = [wanted.part for wanted in planned]
    room = SimulatedTask(task, parts[1:], silent)
    for name, seen in room.survey(parts).items() if len(parts) > 1 else ():
        console.print(f"survey    {name}: {one_line(seen)}, from the start", markup=False)
    return [_one(room, wanted, asked, reel) for wanted in planned]


def _one(room: "SimulatedTask", wanted: "PartTask", asked: Mapping[str, object], reel: "FilmReel") -> Delivered:
    from rfcompass.cli.fetch import as_run, run_fetch
    from rfcompass.studies.fetch_trace import fetch_trace

    console, part = messages(), wanted.part
    task = room.task_for(part)
    console.print(f"part      {part.part_id}", markup=False)
    reel.begin(part, task.part.layout(task.tags, task.spacing).points_m)
    fetched, put = run_fetch(room.send_for(part), task, grasp=True, watch=reel.event), None
    if fetched.held:
        plan = fetched.trials[-1].plan
        put = room.deliver(part, plan, wanted.goal)
        reel.put_down(plan, put.put)
        try:
            room.check_delivered(put)
        except NoAnswer as failure:
            fetched.failure = failure
    else:
        room.left(part, fetched.steps[-1].step if fetched.steps else None)
    console.print(_said(wanted, fetched, put), markup=False)
    run = None
    if stops := fetched.run.stops:
        run = as_run(task, fetched, {**asked, "part": part.part_id}, fetch_trace(task.robot, stops))
    return Delivered(wanted, fetched, put, run)


def _said(wanted: "PartTask", fetched: "Fetched", put: "JudgedPutDown | None") -> str:
    name = wanted.part.part_id
    if put is None:
        why = "it was not grasped" if fetched.failure is None else fetched.failure.message
        return f"deliver   {name} stays where it is: {why}"
    truly = f"(true error {100 * put.centre_error_m:.1f} cm)"
    if fetched.failure is not None:
        return f"deliver   {name}: {fetched.failure.message} {truly}"
    return f"deliver   {name} was put down, carried {100 * put.put.carry.floor_m:.0f} cm over the floor {truly}"


def _actions(planned: "Sequence[PartTask]") -> "list[Action]":
    return [action for wanted in planned for action in wanted.actions]
