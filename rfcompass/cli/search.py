"""`rfcompass search`: the whole FuseBot job on a simulated pile."""

from dataclasses import replace
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from rfcompass.cli.output import EXIT_NO_ANSWER, JsonFlag, answering, messages, print_json

if TYPE_CHECKING:
    from rfcompass.recordings.search_folder import StoredSearch
    from rfcompass.studies.searching import SearchRun
    from rfcompass.types import SearchResult, SearchStep


class Way(StrEnum):
    """How the pile comes about."""

    POURED = "poured"
    COVERED = "covered"


class TargetClass(StrEnum):
    """How much of the target the first views see."""

    HIDDEN = "hidden"
    PARTLY = "partly"
    OPEN = "open"


def search_command(
    policy: Annotated[
        str, typer.Option(help="Method: ours, fusebot, xray, naive, random, ...: docs/search.md.")
    ] = "ours",
    piles: Annotated[int, typer.Option(min=1, max=3, help="Number of piles.")] = 1,
    items: Annotated[int, typer.Option(min=3, max=60, help="Number of distractors, over all piles.")] = 10,
    tagged: Annotated[int, typer.Option(min=0, help="How many distractors carry a tag.")] = 0,
    tag_target: Annotated[bool, typer.Option(help="The target carries a tag, too.")] = False,
    seed: Annotated[int, typer.Option(min=0, help="The pile and all noise follow from it.")] = 0,
    way: Annotated[Way, typer.Option(help="Nothing is aimed, or covers are let go over the target.")] = Way.POURED,
    target: Annotated[TargetClass, typer.Option(help="How much of the target is seen.")] = TargetClass.HIDDEN,
    absent: Annotated[bool, typer.Option(help="Take the target away before: it is sought in vain.")] = False,
    true_masks: Annotated[bool, typer.Option(help="Objects told apart by the simulator, without mistakes.")] = False,
    out: Annotated[Path | None, typer.Option(help="Folder; by default runs/search-POLICY-SEED.")] = None,
    overwrite: Annotated[bool, typer.Option(help="Replace a search that is already there.")] = False,
    show: Annotated[bool, typer.Option(help="Open the film in a browser.")] = False,
    as_json: JsonFlag = False,
) -> None:
    """Search a simulated pile for a red thing: scan, map, take off what lies over it; leaves a folder with the film."""
    import webbrowser

    from rfcompass.recordings.search_folder import FILM_FILE, REPORT_FILE, check_search_target, write_search
    from rfcompass.simulation.piles import make_pile
    from rfcompass.studies.search_methods import check_search_method, search_method
    from rfcompass.studies.searching import SearchRun, SearchTask, tagged_items_of

    with answering(as_json):
        check_search_method(policy)
        folder = out or Path("runs") / f"search-{policy}-{seed}"
        check_search_target(folder, overwrite=overwrite)
        asked = {"command": "search", "policy": policy, "piles": piles, "items": items, "tagged": tagged,
                 "tag_target": tag_target, "seed": seed, "way": way.value, "target": target.value, "absent": absent,
                 "true_masks": true_masks}  # fmt: skip
        messages().print("making the pile", markup=False)
        scene = make_pile(_family(way.value, piles, items), seed, target.value)
        tags = tagged_items_of(scene, "target" if tag_target else "any", tagged, seed)
        asked["tags_dealt"] = carry = sum(tag.number != scene.target for tag in tags.tags)
        if carry < tagged:
            messages().print(f"only {carry} distractors can carry a tag", markup=False)
        method = search_method(policy, tags.target_size, seed)
        task = SearchTask(scene, tags, seed, absent=absent)
        run = SearchRun.of(replace(task, segmenter=None) if true_masks else task, method)
        result = run.run(_told)
        write_search(as_folder(run, result, asked), folder, overwrite=overwrite)
        film, report = folder / FILM_FILE, folder / REPORT_FILE
        ending = f"{_ending(result)}; {result.elapsed_s:.0f} s of the arm"
        messages().print(f"{ending}; look at {film} and {report}", markup=False)
        if show:
            webbrowser.open(film.resolve().as_uri())
        if as_json:
            print_json({**answer_json(result), "policy": policy, "tagged": carry, "run": str(folder)})
        if not result.found:
            raise typer.Exit(EXIT_NO_ANSWER)


def _ending(result: "SearchResult") -> str:
    """How it ended, with the map's verdict on a target that was not found."""
    if result.found or result.room_m3 is None:
        return result.message
    return f"{result.message}; {1000 * result.room_m3:.2f} l are left in which it could lie"


def _told(step: "SearchStep") -> None:
    """Say what came of an action as soon as it is over."""
    goal = "the target" if step.on_target else f"object {step.action.mask_label}"
    messages().print(f"{step.elapsed_s:.0f} s: {goal}: {step.attempt.outcome}", markup=False)


def _family(way: str, piles: int, items: int) -> Any:  # noqa: ANN401 - its type would import the simulation
    """A family with that many piles and distractors, the first piles getting what does not divide."""
    from rfcompass.simulation.piles import PileFamily

    counts = tuple(items // piles + (pile < items % piles) for pile in range(piles))
    return PileFamily(f"{way}_{piles}p{items}", way, counts)


def answer_json(result: "SearchResult") -> dict[str, Any]:
    """How a search ended, as JSON."""
    answer = {
        "outcome": result.outcome,
        "found": result.found,
        "actions": result.actions,
        "failed_grasps": result.failed_grasps,
        "elapsed_s": result.elapsed_s,
        "hidden_m3": result.hidden_m3,
        "room_m3": result.room_m3,
        "tags_located": result.tags_located,
    }
    if result.found:
        return answer
    numbers = {"actions": result.actions, "hidden_m3": result.hidden_m3, "room_m3": result.room_m3}
    return {**answer, "failure": {"kind": result.outcome, "message": result.message, **numbers}}


def step_json(number: int, step: "SearchStep") -> dict[str, Any]:
    """One action, as JSON."""
    return {
        "action": number,
        "at_s": step.elapsed_s,
        "on_target": step.on_target,
        "point_m": step.action.T_world_hand[:3, 3].tolist(),
        "aperture_m": step.action.aperture_m,
        "score": step.action.score,
        "chance": step.chance,
        "outcome": step.attempt.outcome,
        "message": step.attempt.message,
        "gap_m": step.attempt.gap_m,
        "shows_target": step.attempt.shows_target,
        "tags_removed": list(step.attempt.epcs),
        "hidden_m3": step.hidden_m3,
    }


def as_folder(run: "SearchRun", result: "SearchResult", asked: dict[str, Any]) -> "StoredSearch":
    """All that a search leaves behind."""
    from rfcompass.recordings.search_folder import FILM_FILE, PILE_FILE, REPORT_FILE, StoredSearch
    from rfcompass.simulation.piles import write_pile
    from rfcompass.studies.pile_scan import pile_trace
    from rfcompass.studies.search_film import film_of
    from rfcompass.studies.versions import software_versions
    from rfcompass.viz.search_film import draw_search
    from rfcompass.viz.search_report import write_search_report

    steps = [step_json(number, step) for number, step in enumerate(result.steps, start=1)]
    facts = _facts(result, asked)
    scanned = run.robot.scanned
    view = draw_search(run.robot.arm.ik.robot, film_of(run, result), facts)
    return StoredSearch(
        {**asked, "versions": software_versions()},
        {**answer_json(result), "steps": steps},
        steps,
        {
            FILM_FILE: view.save,
            REPORT_FILE: lambda path: write_search_report(path, result, facts),
            PILE_FILE: lambda path: write_pile(run.task.scene, path),
        },
        pile_trace(scanned) if scanned is not None and len(scanned.inventory) else None,
    )


def _facts(result: "SearchResult", asked: dict[str, Any]) -> tuple[tuple[str, str], ...]:
    """What film and report say beside the pictures: what was asked, and what came of it."""
    return (
        ("policy", str(asked["policy"])),
        (
            "pile",
            f"simulated, {asked['way']}, {asked['items']} distractors, {asked['piles']} pile(s), seed {asked['seed']}",
        ),
        ("target", "taken away before" if asked["absent"] else str(asked["target"])),
        ("tags", f"{asked['tags_dealt']} on other things{', one on the target' if asked['tag_target'] else ''}"),
        ("told by the simulator", "masks" if asked["true_masks"] else "nothing"),
        ("outcome", result.outcome),
        ("actions", str(result.actions)),
        ("failed grasps", str(result.failed_grasps)),
        ("time of the arm", f"{result.elapsed_s:.0f} s"),
        ("where nobody looked", f"{1000 * result.hidden_m3:.1f} l"),
        ("where the target fits", "–" if result.room_m3 is None else f"{1000 * result.room_m3:.2f} l"),
    )
