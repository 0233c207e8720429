"""Search a pile for a red thing that no camera sees: scan, map, take off what lies over it, until it is carried off.

A UR5e goes round the table, asks a method where the thing may be and what to take next, and grasps in a physics
simulation: twice on the same pile, FuseBot's way and ours. You will see every action of both, what came of it, and how
much space is left where the target could be; and get, for ours, `search.html`, a film with a slider (arm, pile, map,
grasps), and `report.html` with every decision. Needs MuJoCo (`pip install -c constraints.txt '.[piles]'`). Takes 40 s.
"""

import sys
from pathlib import Path

from rfcompass.simulation.piles import PileFamily, make_pile
from rfcompass.studies.search_film import film_of
from rfcompass.studies.search_methods import search_method
from rfcompass.studies.searching import SearchRun, SearchTask, tagged_items_of
from rfcompass.types import SearchResult
from rfcompass.viz.search_film import draw_search
from rfcompass.viz.search_report import write_search_report

SMALL = PileFamily("small", "covered", (4,))


def tell(name: str, result: SearchResult) -> None:
    """Print a line for each action."""
    print(f"{name}: {result.outcome}, {result.actions} actions, {result.elapsed_s:.0f} s of the arm")
    for number, step in enumerate(result.steps, start=1):
        what = "the target" if step.on_target else "an object"
        print(f"  {number}: goes for {what}, {step.attempt.outcome}; {1000 * step.hidden_m3:.1f} l are hidden")


def main(fast: bool = False, out: Path = Path("runs/23_search")) -> int:
    """Search one pile in two ways; return the actions that ours took."""
    # Set up: a pile, four tagged things in it, and what the database says about them.
    seed = 1 if fast else 3
    scene = make_pile(SMALL if fast else "poured_1p10", seed, "hidden")
    tags = tagged_items_of(scene, "any", 2 if fast else 4, seed)
    task = SearchTask(scene, tags, seed)

    # Search: the same pile and the same noise for both.
    runs = {name: SearchRun.of(task, search_method(name, tags.target_size, seed)) for name in ("fusebot", "ours")}
    results = {name: run.run() for name, run in runs.items()}
    for name, result in results.items():
        tell(name, result)

    # Show.
    out.mkdir(parents=True, exist_ok=True)
    run, result = runs["ours"], results["ours"]
    facts = (("policy", "ours"), ("outcome", result.outcome), ("actions", str(result.actions)))
    draw_search(run.robot.arm.ik.robot, film_of(run, result), facts).save(out / "search.html")
    write_search_report(out / "report.html", result, facts)
    print(f"pictures: {out / 'search.html'}, {out / 'report.html'}")
    return result.actions


if __name__ == "__main__":
    main(fast="--fast" in sys.argv)
