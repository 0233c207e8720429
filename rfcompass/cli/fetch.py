"""`rfcompass fetch PART`: the whole RF-Compass job in a simulated room."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from rfcompass.cli.estimates import Estimator, estimate_json, localizer, one_line
from rfcompass.cli.output import JsonFlag, answering, failure_json, messages, plain, print_json

if TYPE_CHECKING:
    from rfcompass.errors import NoAnswer
    from rfcompass.recordings import Run
    from rfcompass.studies.fetching import FetchTask, JudgedStep


def fetch(
    part: Annotated[str, typer.Argument(help="Part to fetch, by its name in the part database.")],
    seed: Annotated[int, typer.Option(min=0, help="Start poses and all noise follow from it.")] = 0,
    tags: Annotated[int, typer.Option(min=1, help="Number of tags on the part.")] = 4,
    estimator: Annotated[Estimator, typer.Option(help="How to find the part.")] = Estimator.PARTITION,
    robot: Annotated[str, typer.Option(help="Robot that has a posture 'scan', by name or file.")] = "youbot",
    sigma: Annotated[float, typer.Option(min=0.0, help="Noise of the proximities: deviation of log m.")] = 0.05,
    out: Annotated[Path | None, typer.Option(help="Run folder; by default runs/fetch-PART-SEED.")] = None,
    overwrite: Annotated[bool, typer.Option(help="Replace a run that is already there.")] = False,
    show: Annotated[bool, typer.Option(help="Open the run's page in a browser.")] = False,
    database: Annotated[Path | None, typer.Option(help="Part database; by default the user's own.")] = None,
    as_json: JsonFlag = False,
) -> None:
    """Navigate to a part in a simulated room, localise it with the hand over it, and leave a run folder."""
    import webbrowser

    from rfcompass.recordings import PartDatabase, check_target, write_run
    from rfcompass.robots import load_robot
    from rfcompass.simulation import RoomNoise
    from rfcompass.studies.fetching import FetchTask

    with answering(as_json):
        target = out or Path("runs") / f"fetch-{part}-{seed}"
        check_target(target, overwrite=overwrite)
        with PartDatabase(database) as parts:
            wanted = parts.part(part)
        task = FetchTask(
            robot=load_robot(robot), part=wanted, tags=tags, localizer=localizer(estimator), seed=seed,
            noise=RoomNoise(distance_sigma=sigma),
        )  # fmt: skip
        steps, failure = _run(task)
        asked = {"command": "fetch", "part": part, "seed": seed, "tags": tags, "estimator": estimator.value,
                 "robot": robot, "sigma": sigma}  # fmt: skip
        if steps:
            write_run(_as_run(task, steps, failure, asked), target, overwrite=overwrite)
            messages().print(f"run folder: {target}; look at {target / 'view.html'}", markup=False)
        if failure is not None:
            raise failure
        last = steps[-1]
        messages().print(f"found {part}: {one_line(last.step.estimate)}, base frame of the last stop", markup=False)
        if show:
            webbrowser.open((target / "view.html").resolve().as_uri())
        if as_json:
            error = {"centre_m": last.centre_error_m, "theta_rad": last.theta_error_rad}
            answer = estimate_json(last.step.estimate, "noisy_distance")
            print_json({**answer, "run": str(target), "stops_made": len(steps), "simulated_error": error})


def _run(task: "FetchTask") -> "tuple[list[JudgedStep], NoAnswer | None]":
    """Run the loop and say what it does, stop by stop; return the steps, and how it failed if it did."""
    from rfcompass.errors import NoAnswer
    from rfcompass.studies.fetching import simulate_fetch

    console, steps = messages(), []
    with console.status(f"fetching {task.part.part_id}") as status:
        try:
            for judged in simulate_fetch(task):
                steps.append(judged)
                status.update(f"{judged.step.phase}: stop {judged.step.observation.stop_id}")
                console.print(_line(judged), markup=False)
        except NoAnswer as failure:
            return steps, failure
    return steps, None


def _line(judged: "JudgedStep") -> str:
    step = judged.step
    reach = "  in reach" if step.in_reach and step.phase == "navigate" else ""
    error = f"(true error {100 * judged.centre_error_m:.1f} cm)"
    return f"{step.phase:<9} stop {step.observation.stop_id:>2}  {one_line(step.estimate)}  {error}{reach}"


def _as_run(
    task: "FetchTask", steps: "list[JudgedStep]", failure: "NoAnswer | None", asked: dict[str, object]
) -> "Run":
    from rfcompass.recordings import Run
    from rfcompass.studies.fetch_pictures import draw_approach, draw_last_partition, draw_scene
    from rfcompass.studies.fetch_trace import fetch_trace
    from rfcompass.studies.versions import software_versions

    estimate = steps[-1].step.estimate
    events = [
        plain({"stop": s.step.observation.stop_id, "phase": s.step.phase, "in_reach": s.step.in_reach,
               "base": [s.step.configuration.base.x_m, s.step.configuration.base.y_m,
                        s.step.configuration.base.theta_rad],
               "estimate": estimate_json(s.step.estimate, "noisy_distance")})
        for s in steps
    ]  # fmt: skip
    return Run(
        asked={**asked, "versions": software_versions()},
        events=events,
        trace=fetch_trace(task, [judged.step for judged in steps]),
        estimate=plain(estimate_json(estimate, "noisy_distance") if failure is None else failure_json(failure)),
        samples=estimate.samples,
        pictures={
            "partition.png": lambda path: draw_last_partition(task, steps).savefig(path, dpi=130),
            "approach.png": lambda path: draw_approach(task, steps).savefig(path, dpi=130),
            "view.html": lambda path: draw_scene(task, steps, path),
        },
    )
