"""`rfcompass fetch` for several parts: the planned actions, one part after the other, and the folder of the task."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import typer

from rfcompass.cli.output import EXIT_NO_ANSWER, failure_json, messages, plain, print_json
from rfcompass.errors import InputError, NoAnswer

if TYPE_CHECKING:
    from planners.task import Action, PartTask
    from rfcompass.cli.fetch import Fetched
    from rfcompass.geometry.pose2 import Pose2
    from rfcompass.recordings import Run
    from rfcompass.studies.fetching import FetchTask
    from rfcompass.studies.task_fetching import JudgedPutDown, SimulatedTask
    from rfcompass.types.parts import Part
    from rfcompass.viz.grasp_view import View


@dataclass(frozen=True, slots=True)
class Delivered:
    """What came of one part.

    Attributes:
        wanted: What was to be done with it.
        fetched: The fetch.
        put: How it was put down; None if it never was in the hand.
        run: Its run folder; None if nothing was heard.
    """

    wanted: "PartTask"
    fetched: "Fetched"
    put: "JudgedPutDown | None" = None
    run: "Run | None" = None

    @property
    def delivered(self) -> bool:
        """True if the part is where it was to go, as the robot believes."""
        return self.put is not None and self.fetched.failure is None

    def has_done(self, verb: str) -> bool:
        """True if an action came to its end."""
        steps = self.fetched.steps
        return {
            "navigate": any(judged.step.in_reach for judged in steps),
            "localise": (bool(steps) and self.fetched.located) or self.put is not None,
            "grasp": self.fetched.held,
            "deliver": self.delivered,
        }[verb]


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
    done = _fetched(task, planned, options.silent, asked)
    _write(done, {**asked, "deliver": _pose(first), "silent": options.silent}, options)
    count = sum(one.delivered for one in done)
    messages().print(f"{count} of {len(done)} parts delivered; folder of the task: {options.target}", markup=False)
    if options.show:
        webbrowser.open((options.target / "view.html").resolve().as_uri())
    if options.as_json:
        print_json({"parts": _answers(done, options.target), "actions": _actions_json(done)})
    if count < len(done):
        raise typer.Exit(EXIT_NO_ANSWER)


def _write(done: "Sequence[Delivered]", asked: Mapping[str, object], options: FetchOptions) -> None:
    from rfcompass.recordings import TaskRun, write_task
    from rfcompass.studies.versions import software_versions

    runs = {one.wanted.part.part_id: one.run for one in done if one.run is not None}
    pictures = {}
    if any(one.fetched.steps for one in done):
        pictures["view.html"] = lambda path: _film(done).save(path)
    kept = plain({**asked, "parts": [one.wanted.part.part_id for one in done], "versions": software_versions()})
    task_run = TaskRun(kept, _actions_json(done), _events_json(done), runs, pictures)
    write_task(task_run, options.target, overwrite=options.overwrite)


def _film(done: "Sequence[Delivered]") -> "View":
    """All of the task in one page with a slider for the time."""
    from rfcompass.studies.fetching import JudgedStep
    from rfcompass.studies.task_film import FilmReel
    from rfcompass.viz.task_film import draw_film

    reel = FilmReel(done[0].fetched.run.robot)
    for one in done:
        if one.fetched.steps:
            reel.begin(one.wanted.part, one.fetched.steps[0].step.observation.part.points_m)
        for event in one.fetched.events:
            if isinstance(event, JudgedStep):
                reel.stop(event.step)
            else:
                reel.grasp(event)
        if one.put is not None:
            reel.put_down(one.fetched.trials[-1].plan, one.put.put)
    said = [(one.wanted.part.part_id, "delivered" if one.delivered else "not delivered") for one in done]
    return draw_film(reel.robot, reel.film, said)


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
    task: "FetchTask", planned: "Sequence[PartTask]", silent: Sequence[str], asked: Mapping[str, object]
) -> list[Delivered]:
    """Print what is planned, then fetch and deliver each part; one that ends early leaves the others to be fetched.

    Args:
        task: How to fetch; its part is the first.
        planned: What to do with each part.
        silent: Names of parts whose tags are broken.
        asked: What was asked for, for the run folders.
    """
    from rfcompass.studies.task_fetching import SimulatedTask

    console = messages()
    for action in _actions(planned):
        console.print(f"planned   {action}", markup=False)
    room = SimulatedTask(task, [wanted.part for wanted in planned[1:]], silent)
    return [_one(room, wanted, asked) for wanted in planned]


def _one(room: "SimulatedTask", wanted: "PartTask", asked: Mapping[str, object]) -> Delivered:
    from rfcompass.cli.fetch import as_run, run_fetch

    console, part = messages(), wanted.part
    task = room.task_for(part)
    console.print(f"part      {part.part_id}", markup=False)
    fetched, put = run_fetch(task, grasp=True, job=room.send_for(part)), None
    if fetched.held:
        put = room.deliver(part, fetched.trials[-1].plan, wanted.goal)
        try:
            room.check_delivered(put)
        except NoAnswer as failure:
            fetched.failure = failure
    console.print(_said(wanted, fetched, put), markup=False)
    run = as_run(task, fetched, {**asked, "part": part.part_id}) if fetched.run.stops else None
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


def _actions_json(done: Sequence[Delivered]) -> list[dict[str, Any]]:
    """Every planned action, and whether it came to its end."""
    return [
        plain({"action": action.verb, "part": action.part_id, "tags": action.epcs,
               "goal": None if action.goal is None else _pose(action.goal), "done": one.has_done(action.verb)})
        for one in done for action in one.wanted.actions
    ]  # fmt: skip


def _answers(done: Sequence[Delivered], target: Path) -> list[dict[str, Any]]:
    """One answer for each part: that of a single fetch, and where the part was put."""
    return [plain(_answer(one, target)) for one in done]


def _answer(one: Delivered, target: Path) -> dict[str, Any]:
    from rfcompass.cli.fetch import fetch_answer

    name, fetched = one.wanted.part.part_id, one.fetched
    answer: dict[str, Any] = {"part": name, "delivered": one.delivered}
    if fetched.steps and (fetched.located or one.put is not None):
        last = fetched.steps[-1]
        answer |= fetch_answer(fetched)
        answer["simulated_error"] = {"centre_m": last.centre_error_m, "theta_rad": last.theta_error_rad}
    elif fetched.failure is not None:
        answer |= failure_json(fetched.failure)
    answer |= {"run": str(target / name) if one.run is not None else None, "stops_made": len(fetched.steps)}
    return answer if one.put is None else {**answer, "put_down": _put_json(one.put)}


def _put_json(judged: "JudgedPutDown") -> dict[str, Any]:
    put = judged.put
    return {
        "goal": _pose(put.goal), "part": _pose(put.T_odom_part), "base": _pose(put.T_odom_base),
        "short_m": put.short_m, "carried_over_floor_m": put.carry.floor_m, "drives": put.drives,
        "simulated": {"part": _pose(judged.T_odom_part), "centre_error_m": judged.centre_error_m,
                      "theta_error_rad": judged.theta_error_rad, "drop_m": judged.drop_m},
    }  # fmt: skip


def _events_json(done: Sequence[Delivered]) -> list[dict[str, Any]]:
    """What happened, in order; each localisation as the tuple (φ, D, θ) that a planner gets [Wang2013], section 3.2."""
    return [event for one in done for event in _events(one)]


def _events(one: Delivered) -> list[dict[str, Any]]:
    from planners.task import RelativeLocation

    name, events = one.wanted.part.part_id, list[dict[str, Any]]()
    for judged in one.fetched.steps:
        step, base = judged.step, judged.step.configuration.base
        found = RelativeLocation.of(step.estimate)
        location = {"phi_rad": found.phi_rad, "D_m": found.D_m, "theta_rad": found.theta_rad}
        events.append({"action": step.phase, "part": name, "stop": step.observation.stop_id, "base": _pose(base),
                       "location": location, "in_reach": step.in_reach})  # fmt: skip
    for trial in one.fetched.trials:
        failure = trial.outcome.failure
        why = None if failure is None else failure.kind
        events.append({"action": "grasp", "part": name, "success": trial.outcome.success, "failure": why})
    if one.put is not None:
        put = one.put.put
        events.append({"action": "deliver", "part": name, "base": _pose(put.T_odom_base),
                       "put_at": _pose(put.T_odom_part), "short_m": put.short_m})  # fmt: skip
    if one.fetched.failure is not None:
        events.append({"action": "end", "part": name, **failure_json(one.fetched.failure)})
    return list(plain(events))


def _actions(planned: "Sequence[PartTask]") -> "list[Action]":
    return [action for wanted in planned for action in wanted.actions]


def _pose(pose: "Pose2") -> list[float]:
    return [pose.x_m, pose.y_m, pose.theta_rad]
