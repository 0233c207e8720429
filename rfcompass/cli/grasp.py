"""`rfcompass grasp ESTIMATE`: choose a grasp for an estimate and plan every motion of it."""

import json
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from rfcompass.arrays import plain
from rfcompass.cli.grasp_advice import advice_json, advice_line, with_advice
from rfcompass.cli.grasp_json import grasp_failure_json, plan_json, world_around
from rfcompass.cli.output import EXIT_NO_ANSWER, JsonFlag, answering, messages, print_json, print_table

if TYPE_CHECKING:
    from rfcompass.recordings import PlanSetting
    from rfcompass.types import GraspFailure, GraspPlan, Part, PartEstimate
    from rfcompass.types.scene import Scene


def grasp_command(
    estimate: Annotated[Path, typer.Argument(help="What locate printed, as a file; or a run folder.")],
    part: Annotated[str | None, typer.Option(help="Part to grasp; by default what the estimate says.")] = None,
    robot: Annotated[str, typer.Option(help="Robot with a hand, by name or file.")] = "youbot",
    scene: Annotated[Path | None, typer.Option(help="Scene file: what stands around.")] = None,
    base: Annotated[
        tuple[float, float, float], typer.Option(help="Pose of the base in the scene: x, y [m], heading [rad].")
    ] = (0.0, 0.0, 0.0),
    start: Annotated[str | None, typer.Option(help="Posture to start from; scan, or at rest, by default.")] = None,
    drive: Annotated[bool, typer.Option(help="Drive first, if the part is out of reach.")] = False,
    measure_again: Annotated[
        bool, typer.Option("--measure-again", help="Say whether another stop would raise the chance; takes seconds.")
    ] = False,
    tags: Annotated[
        int | None, typer.Option(min=1, help="Of --measure-again: tags heard on the part, by default the most it has.")
    ] = None,
    seed: Annotated[int, typer.Option(min=0, help="Of samples and searches.")] = 0,
    out: Annotated[Path | None, typer.Option(help="Write the plan to this JSON file.")] = None,
    page: Annotated[Path | None, typer.Option(help="Draw the plan, or what was tried, into this HTML file.")] = None,
    show: Annotated[bool, typer.Option(help="Show the same live in a browser, until Ctrl-C.")] = False,
    overwrite: Annotated[bool, typer.Option(help="Replace a file that is already there.")] = False,
    database: Annotated[Path | None, typer.Option(help="Part database; by default the user's own.")] = None,
    as_json: JsonFlag = False,
) -> None:
    """Plan a grasp in the base frame of the estimate; say why, if there is none."""
    import numpy as np

    from planners.grasp import GraspPlanner, GraspRules
    from rfcompass.errors import InputError
    from rfcompass.geometry import Pose2
    from rfcompass.recordings import PlanSetting
    from rfcompass.robots import load_robot
    from rfcompass.types import GraspPlan
    from rfcompass.viz.grasp_view import view

    with answering(as_json):
        if out is not None and out.exists() and not overwrite:
            raise InputError(f"{out} is there already; --overwrite replaces it", file=str(out))
        wanted, seen = _asked(estimate, part, database)
        machine = load_robot(robot)
        posture = None if start is None else machine.posture(start)
        planner = GraspPlanner(machine, rules=GraspRules(drive=drive))
        setting = PlanSetting(robot, _read_scene(scene), Pose2(*base))
        around = world_around(setting)
        answer = planner.plan(wanted, seen, around, posture, np.random.default_rng(seed))
        if measure_again and isinstance(answer, GraspPlan):
            rng = np.random.default_rng(seed)
            answer = with_advice(answer, (wanted, seen, around), machine, posture, tags, rng)
        drawn = view(machine, seen, answer, part=wanted, world=around, at=posture) if page or show else None
        if drawn is not None and page is not None:
            messages().print(f"page: {drawn.save(page)}", markup=False)
        if isinstance(answer, GraspPlan):
            _hand_out(answer, setting, out, as_json=as_json, advised=measure_again)
        else:
            _say_why(answer, as_json=as_json)
        if drawn is not None and show:
            drawn.show().wait()
        if not isinstance(answer, GraspPlan):
            raise typer.Exit(EXIT_NO_ANSWER)


def _asked(estimate: Path, part: str | None, database: Path | None) -> tuple["Part", "PartEstimate"]:
    """The part that an estimate is about, and where that seems to lie."""
    from rfcompass.errors import EstimateError
    from rfcompass.recordings import PartDatabase, read_estimate

    seen = read_estimate(estimate, height_m=0.0)  # only for the part's name: it knows how high it lies
    if part is not None and part != seen.part_id:
        raise EstimateError(f"{estimate}: is about {seen.part_id}, not {part}", file=str(estimate), key="part")
    with PartDatabase(database) as parts:
        wanted = parts.part(seen.part_id)
    return wanted, read_estimate(estimate, height_m=wanted.resting_height_m)


def _hand_out(plan: "GraspPlan", setting: "PlanSetting", out: Path | None, *, as_json: bool, advised: bool) -> None:
    """Write and print a plan."""
    from rfcompass.files import write_text_atomic

    found = plan_json(plan, setting) | ({"measure_again": advice_json(plan.advice)} if advised else {})
    if out is not None:
        write_text_atomic(out, json.dumps(plain(found), allow_nan=False, indent=2) + "\n")
    if as_json:
        print_json(found)
        return
    _show(plan)
    if advised:
        typer.echo(advice_line(plan))


def _read_scene(file: Path | None) -> "Scene | None":
    """What stands around, in its own frame."""
    from rfcompass.errors import SceneError
    from rfcompass.files import read_json
    from rfcompass.types.scene_json import scene_from_json

    if file is None:
        return None
    return scene_from_json(read_json(file, SceneError))


def _say_why(failure: "GraspFailure", *, as_json: bool) -> None:
    console = messages()
    console.print(f"[bold red]{failure.kind}[/]: ", end="")
    console.print(failure.message, markup=False)
    if as_json:
        print_json(grasp_failure_json(failure))


def _show(plan: "GraspPlan") -> None:
    chance = "not known" if plan.success_probability is None else f"{plan.success_probability:.2f}"
    x, y, z = 100 * plan.T_base_hand[:3, 3]
    typer.echo(f"{plan.part_id}: success {chance}, hand at x {x:.1f} cm  y {y:.1f} cm  z {z:.1f} cm")
    typer.echo(f"nothing comes nearer than {1e3 * plan.clearance_m:.1f} mm; {plan.duration_s:.1f} s in all")
    rows = [
        (
            row.stage,
            f"{stage.duration_s:.2f}",
            len(stage.times_s),
            row.pairs,
            row.fcl_checks,
            f"{1e3 * row.at_least_m:.1f}",
        )
        for stage, row in zip(plan.stages, plan.certificates, strict=True)
    ]
    print_table("stages", ("name", "s", "waypoints", "pairs", "fcl looks", "at least mm"), rows)
    counts = ", ".join(f"{count} {kind}" for kind, count in plan.reasons.items())
    messages().print(f"{len(plan.candidates)} grasps looked at; rejected: {counts or 'none'}", markup=False)
