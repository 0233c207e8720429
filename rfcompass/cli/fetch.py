"""`rfcompass fetch PART`: the whole RF-Compass job in a simulated room, or with a robot behind a socket."""

from dataclasses import dataclass, field
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from rfcompass.arrays import plain
from rfcompass.cli.comparator import comparator_json
from rfcompass.cli.estimates import Estimator, estimate_json, localizer, one_line
from rfcompass.cli.output import EXIT_NO_ANSWER, JsonFlag, answering, failure_json, messages, print_json

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence

    from planners.fetch import FetchStep
    from planners.pick_up import GraspTrial
    from rfcompass.cli.fetch_task import FetchOptions
    from rfcompass.errors import NoAnswer
    from rfcompass.recordings import Run, Trace
    from rfcompass.simulation import RecordedStop
    from rfcompass.studies.fetch_job import FetchJob, ReportedStep, Sought
    from rfcompass.studies.fetching import FetchTask


@dataclass
class Fetched:
    """What came of a fetch.

    Attributes:
        run: The job, with all stops.
        steps: Every stop that led to an answer.
        trials: Every closing of the hand.
        failure: Why it ended without what was asked for; None if it did not.
    """

    run: "FetchJob"
    steps: "list[ReportedStep]" = field(default_factory=list)
    trials: "list[GraspTrial]" = field(default_factory=list)
    failure: "NoAnswer | None" = None

    @property
    def held(self) -> bool:
        """True if the part is in the hand."""
        return bool(self.trials) and self.trials[-1].outcome.success

    @property
    def located(self) -> bool:
        """True if the part was located to the end, grasped or not."""
        return self.failure is None or self.failure.kind == "GraspFailed"


class Mode(StrEnum):
    """The paper's rig and estimator end to end, or the best that we have."""

    PAPER = "paper"
    BEST = "best"


def fetch(
    context: typer.Context,
    parts: Annotated[
        list[str] | None, typer.Argument(metavar="PART...", help="Parts to fetch, by their names in the part database.")
    ] = None,
    mode: Annotated[Mode, typer.Option(help="The paper's rig and estimator end to end, or our best.")] = Mode.BEST,
    seed: Annotated[int, typer.Option(min=0, help="Start poses and all noise follow from it.")] = 0,
    tags: Annotated[int, typer.Option(min=1, help="Number of tags on the part.")] = 4,
    estimator: Annotated[Estimator | None, typer.Option(help="How to find the part; by default the mode's.")] = None,
    proximity: Annotated[
        str | None, typer.Option(help="Meter, by default the mode's; noisy_distance: no radio, distances with noise.")
    ] = None,
    scene: Annotated[str | None, typer.Option(help="Room, by name or recipe file; room_los by default.")] = None,
    occluded: Annotated[bool, typer.Option(help="A board before the part, a chair over it: scene room_nlos.")] = False,
    others: Annotated[bool, typer.Option(help="All other tagged parts of its kind lie in the room, too.")] = False,
    on_map: Annotated[
        bool | None,
        typer.Option(
            "--map/--no-map",
            help="Furniture is solid, and driven around; else it only echoes. By default: for one part in sight.",
        ),
    ] = None,
    grasp: Annotated[bool, typer.Option(help="Grasp the part; a single tag tells no orientation to grasp by.")] = True,
    robot: Annotated[str, typer.Option(help="Robot that has a posture 'scan', by name or file.")] = "youbot",
    sigma: Annotated[float, typer.Option(min=0.0, help="Without radio: standard deviation of log m.")] = 0.05,
    all_of: Annotated[str | None, typer.Option(help="Fetch all parts of a product, such as LACK.")] = None,
    deliver: Annotated[
        str | None,
        typer.Option(help="x,y,theta: put the first part down there, the others beside it; odometry frame, m and rad."),
    ] = None,
    silent: Annotated[list[str] | None, typer.Option(help="A part to fetch whose tags are broken.")] = None,
    device: Annotated[
        str | None,
        typer.Option(metavar="HOST:PORT", help="A robot behind rfcompass-robot-link/1, in no simulated room."),
    ] = None,
    out: Annotated[
        Path | None, typer.Option(help="Run folder; by default runs/fetch-PART-SEED, or runs/fetch-PART-device.")
    ] = None,
    overwrite: Annotated[bool, typer.Option(help="Replace a run that is already there.")] = False,
    show: Annotated[bool, typer.Option(help="Open the run's page in a browser.")] = False,
    database: Annotated[Path | None, typer.Option(help="Part database; by default the user's own.")] = None,
    as_json: JsonFlag = False,
) -> None:
    """Navigate to a part, localise it with the hand over it, grasp it; leaves a run folder.

    In a simulated room, or with the robot that listens at --device.

    Several parts, or all of a product, are fetched one after the other and delivered.
    """
    from planners.task import parts_of_task
    from rfcompass.cli.fetch_device import fetch_with_device, refuse_options_of_a_room
    from rfcompass.cli.fetch_task import FetchOptions, fetch_and_deliver
    from rfcompass.recordings import PartDatabase
    from rfcompass.robots import load_robot
    from rfcompass.studies import fetch_modes
    from rfcompass.studies.fetching import FetchTask
    from rfcompass.studies.remote_fetching import RemoteTask

    with answering(as_json):
        _check_radio(mode, proximity, scene, occluded=occluded, others=others)
        if device is not None:
            refuse_options_of_a_room(context, len(parts or ()))
        with PartDatabase(database) as known:
            wanted = parts_of_task(known, parts or (), all_of)
            fetched = {one.part_id for one in wanted}
            near = tuple(other for other in known.parts() if other.part_id not in fetched and others)
        part, several = wanted[0].part_id, len(wanted) > 1 or all_of is not None or bool(deliver or silent)
        names = all_of or "-".join(one.part_id for one in wanted)
        target = out or Path("runs") / f"fetch-{names}-{seed if device is None else 'device'}"
        how = fetch_modes.fetch_mode(
            fetch_modes.Mode(mode), proximity, None if estimator is None else localizer(estimator)
        ).in_scene(scene="room_nlos" if occluded else scene or "room_los", others=near)  # fmt: skip
        asked: dict[str, object] = {"command": "fetch", "part": part, "mode": mode.value, "tags": tags,
                 "estimator": estimator, "proximity": proximity, "grasp": grasp, "robot": robot}  # fmt: skip
        options = FetchOptions(deliver, tuple(silent or ()), target, grasp, overwrite, show, as_json)
        if device is not None:
            remote = RemoteTask(
                robot=load_robot(robot), part=wanted[0], tags=tags, localizer=how.localizer, meter=how.meter,
                active_stops=how.active_stops,
            )  # fmt: skip
            fetch_with_device(device, remote, {**asked, "device": device}, options)
            return
        mapped = on_map or (on_map is None and not occluded and not several)
        task = FetchTask(
            robot=load_robot(robot), part=wanted[0], tags=tags, localizer=how.localizer, seed=seed,
            radio=how.radio, meter=how.meter, near=how.near, active_stops=how.active_stops, sigma=sigma,
            map_pose=how.map_pose if mapped else None, solid=mapped,
        )  # fmt: skip
        asked |= {"seed": seed, "scene": scene, "occluded": occluded, "others": others,
                  "map": task.map_pose is not None, "sigma": sigma}  # fmt: skip
        if several:
            fetch_and_deliver(task, wanted, {**asked, "part": None}, options)
        else:
            _fetch_in_a_room(task, asked, options)


def _fetch_in_a_room(task: "FetchTask", asked: "Mapping[str, object]", options: "FetchOptions") -> None:
    """Fetch a single part in a simulated room."""
    from functools import partial

    from rfcompass.recordings import check_target
    from rfcompass.studies.fetch_trace import fetch_trace
    from rfcompass.studies.fetching import SimulatedFetch

    check_target(options.target, overwrite=options.overwrite)
    fetch_one(SimulatedFetch(task), task, asked, options, partial(fetch_trace, task.robot))


def fetch_one(
    job: "FetchJob",
    task: "Sought",
    asked: "Mapping[str, object]",
    options: "FetchOptions",
    trace_of: "Callable[[Sequence[RecordedStop]], Trace]",
) -> None:
    """Fetch a single part, leave its run folder, print the answer.

    Args:
        job: The fetch, before its first step.
        task: Who fetches what.
        asked: What was asked for, for the run folder.
        options: What becomes of the answer.
        trace_of: Turns the job's stops into a trace.

    Raises:
        NoAnswer: If the part was not located; the stops until then are in the run folder.
        typer.Exit: If it was located and not grasped.
    """
    import webbrowser

    from rfcompass.cli.fetch_task import filming
    from rfcompass.recordings import write_run

    target = options.target
    with filming(task.robot, show=options.show) as reel:
        reel.begin(task.part, task.part.layout(task.tags, task.spacing).points_m)
        done = run_fetch(
            job, task, grasp=options.grasp and task.tags > 1, watch=reel.event if options.show else _nobody
        )  # fmt: skip
    if job.stops:
        write_run(as_run(task, done, asked, trace_of(job.stops)), target, overwrite=options.overwrite)
        page = f"; look at {target / 'view.html'}" if done.steps else ""
        messages().print(f"run folder: {target}{page}", markup=False)
    if done.failure is not None and not done.located:
        raise done.failure
    messages().print(_outcome(task.part.part_id, done), markup=False)
    if options.show:
        webbrowser.open((target / "view.html").resolve().as_uri())
    if options.as_json:
        error = simulated_error(done.steps[-1])
        print_json({**fetch_answer(done), "run": str(target), "stops_made": len(done.steps), "simulated_error": error})
    if done.failure is not None:
        raise typer.Exit(EXIT_NO_ANSWER)


def simulated_error(told: "ReportedStep") -> dict[str, float | None] | None:
    """How far off an estimate was; None with a real robot, where nobody knows."""
    from rfcompass.studies.fetching import JudgedStep

    if not isinstance(told, JudgedStep):
        return None
    return {"centre_m": told.centre_error_m, "theta_rad": told.theta_error_rad}


def _outcome(part: str, done: Fetched) -> str:
    where = f"{one_line(done.steps[-1].step.estimate)}, base frame of the last stop"
    if done.held:
        return f"{part} is in the hand, after {len(done.trials)} tries: {where}"
    if done.failure is not None:
        return f"{part} was found, not grasped: {done.failure.message}: {where}"
    return f"found {part}: {where}"


def fetch_answer(done: Fetched) -> dict[str, Any]:
    """The answer of `locate` from the last stop, and what came of the grasp."""
    tries = [
        {"success_probability": trial.plan.success_probability, "success": trial.outcome.success,
         "failure": None if trial.outcome.failure is None else trial.outcome.failure.kind}
        for trial in done.trials
    ]  # fmt: skip
    answer = {**_step_json(done.steps[-1].step), "grasp": {"held": done.held, "tries": tries}}
    return answer if done.failure is None else {**answer, **failure_json(done.failure)}


def _check_radio(mode: Mode, proximity: str | None, scene: str | None, *, occluded: bool, others: bool) -> None:
    """Refuse options of which one would be ignored."""
    from rfcompass.errors import InputError
    from rfcompass.studies.fetch_modes import NOISY_DISTANCE

    if occluded and scene is not None:
        raise InputError(f"--occluded is the scene room_nlos, not {scene}; give one of them", scene=scene)
    radio = {"--mode paper": mode is Mode.PAPER, "--scene": scene is not None, "--occluded": occluded,
             "--others": others}  # fmt: skip
    if proximity == NOISY_DISTANCE and any(radio.values()):
        given = ", ".join(name for name, asked in radio.items() if asked)
        raise InputError(f"--proximity {NOISY_DISTANCE} simulates no radio, so that {given} would say nothing")


def _nobody(event: "ReportedStep | GraspTrial") -> None:
    """Nobody watches."""


def run_fetch(
    job: "FetchJob",
    task: "Sought",
    *,
    grasp: bool,
    watch: "Callable[[ReportedStep | GraspTrial], None]" = _nobody,
) -> Fetched:
    """Run the loop and say what it does, stop by stop and try by try.

    Args:
        job: The fetch, before its first step.
        task: Who fetches what.
        grasp: Grasp the part as well.
        watch: Is told of everything as it happens.
    """
    from rfcompass.errors import NoAnswer
    from rfcompass.studies.fetch_job import ReportedStep

    console, done = messages(), Fetched(job)
    with console.status(f"fetching {task.part.part_id}") as status:
        try:
            for told in job.steps():
                done.steps.append(told)
                watch(told)
                status.update(f"{told.step.phase}: stop {told.step.observation.stop_id}")
                console.print(_line(told), markup=False)
            for event in job.pick_up(done.steps[-1]) if grasp else ():
                watch(event)
                if isinstance(event, ReportedStep):
                    done.steps.append(event)
                    console.print(_line(event), markup=False)
                else:
                    done.trials.append(event)
                    console.print(_try_line(event), markup=False)
        except NoAnswer as failure:
            done.failure = failure
    return done


def _try_line(trial: "GraspTrial") -> str:
    chance, failure = trial.plan.success_probability, trial.outcome.failure
    said = "the part is in the hand" if failure is None else failure.message
    return f"grasp     success expected {'not known' if chance is None else f'{chance:.2f}'}: {said}"


def _step_json(step: "FetchStep") -> dict[str, Any]:
    answer = estimate_json(step.estimate, step.proximity.kind)
    return {**answer, "comparator": comparator_json(step.proximity, step.observation.anchors)}


def _line(told: "ReportedStep") -> str:
    step, error = told.step, simulated_error(told)
    reach = "  in reach" if step.in_reach and step.phase == "navigate" else ""
    truly = "" if error is None else f"  (true error {100 * (error['centre_m'] or 0.0):.1f} cm)"
    return f"{step.phase:<9} stop {step.observation.stop_id:>2}  {one_line(step.estimate)}{truly}{reach}"


def as_run(task: "Sought", done: Fetched, asked: "Mapping[str, object]", trace: "Trace") -> "Run":
    """All that a fetch leaves behind.

    Args:
        task: Who fetched what.
        done: What came of it.
        asked: What was asked for.
        trace: What was heard.
    """
    import numpy as np

    from rfcompass.recordings import Run
    from rfcompass.studies.fetch_pictures import draw_approach, draw_last_partition, draw_scene
    from rfcompass.studies.versions import software_versions

    steps = done.steps
    events = [
        plain({"stop": s.step.observation.stop_id, "phase": s.step.phase, "in_reach": s.step.in_reach,
               "base": [s.step.configuration.base.x_m, s.step.configuration.base.y_m,
                        s.step.configuration.base.theta_rad],
               "estimate": _step_json(s.step)})
        for s in steps
    ]  # fmt: skip
    pictures = {
        "partition.png": lambda path: draw_last_partition(task, steps).savefig(path, dpi=130),
        "approach.png": lambda path: draw_approach(task, steps).savefig(path, dpi=130),
        "view.html": lambda path: draw_scene(task, steps, path),
    }
    return Run(
        asked={**asked, "versions": software_versions()},
        events=events,
        trace=trace,
        estimate=plain(failure_json(done.failure) if done.failure and not done.located else fetch_answer(done)),
        samples=steps[-1].step.estimate.samples if steps else np.zeros((0, 3)),
        pictures=pictures if steps else {},
    )
