"""How much the constants of FuseBot's search matter: each at a low and a high value about its default, on tuning seeds.

    RFCOMPASS_PILE_SCENES=FOLDER python -m benchmarks.search_sensitivity --seeds 0:12 --family covered_1p10

Hidden targets, the literal FuseBot (`fusebot` with 8 tags), one constant moved at a time. Every value searches the same
piles as the default; what is printed is the mean difference of actions, moved less default, a lost target counting 16,
with its 95 % bootstrap interval over piles. The paper prints none of these constants; the values tried here are ours.

    gamma      discount of Eq. 4 for each 2.5 cm
    tau        grasp quality from which on objects are compared, Eq. 5
    tau_xyz    the paper's thresholds on the box about a tag below which its place counts, as a multiple of ours
    cluster    share of the largest column from which on columns of the map belong to a cluster
    spacing_m  edge of a voxel [m]
    amplitude  how much a tag takes off the map at its own place; 1 is all, and the most there is: both values are lower
"""

import argparse
import json
import sys
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, replace

import numpy as np

from planners.extraction.clusters import THRESHOLD
from planners.extraction.scores import GAMMA, TAU
from planners.search_method import SearchMethod
from rfcompass.errors import NoPile, StudyError
from rfcompass.evaluation.statistics import bootstrap_interval
from rfcompass.mapping import RfKernels
from rfcompass.simulation.piles import PileScene
from rfcompass.studies.pile_scan import PILE_SAR
from rfcompass.studies.pile_scenes import FAMILIES, pile_scene
from rfcompass.studies.search_methods import search_method
from rfcompass.studies.searches import LOST, TAGS
from rfcompass.studies.searching import SPACING_M, SearchRun, SearchTask, tagged_items_of
from rfcompass.types import ItemSize, SearchResult
from rfcompass.types.record import Record
from rfcompass.types.search import ARM_STOPPED

FIRST_REPORTED = 1000  # seeds from here on are for results, and no constant may be looked at there


@dataclass(frozen=True, slots=True, kw_only=True)
class Constants(Record):
    """What is moved; see the top of this module. By default what every study of searches uses."""

    gamma: float = GAMMA
    tau: float = TAU
    tau_xyz: float = 1.0
    cluster: float = THRESHOLD
    spacing_m: float = SPACING_M
    amplitude: float = RfKernels.amplitude


DEFAULT = Constants()
VALUES: Mapping[str, tuple[float, ...]] = {
    "gamma": (0.3, 0.95),
    "tau": (0.25, 0.75),
    "tau_xyz": (0.5, 2.0),
    "cluster": (0.1, 0.6),
    "spacing_m": (0.005, 0.02),
    "amplitude": (0.25, 0.5),
}
Row = Mapping[str, object]


@dataclass(frozen=True, slots=True)
class Moved(Record):
    """What moving one constant does.

    Attributes:
        family: Of the piles, or `all`.
        constant: Which one.
        value: Where to.
        default: Where from.
        pairs: Piles that both searched.
        actions: Mean, a lost target counting 16; `default_actions` the same with the default.
        difference: Mean of the differences, with the limits `low` and `high`; one pile has none.
        changed: Share of piles that took another number of actions.
        found: Share of targets found; `default_found` the same with the default.
    """

    family: str
    constant: str
    value: float
    default: float
    pairs: int
    actions: float
    default_actions: float
    difference: float
    low: float | None
    high: float | None
    changed: float
    found: float
    default_found: float


def tuning_seeds(text: str) -> range:
    """Read `first:last`, without the last.

    Raises:
        StudyError: If it is no such range, an empty one, or one that reaches the seeds of the report.
    """
    try:
        first, last = (int(part) for part in text.split(":"))
    except ValueError as error:
        raise StudyError(f"seeds {text!r} are not first:last", seeds=text) from error
    if not 0 <= first < last <= FIRST_REPORTED:
        message = (
            f"seeds {first} to {last - 1}: at least one, from 0 on, and below {FIRST_REPORTED}, which is for results"
        )
        raise StudyError(message, seeds=[first, last], below=FIRST_REPORTED)
    return range(first, last)


def method_of(constants: Constants, target: ItemSize) -> SearchMethod:
    """The literal FuseBot with other constants."""
    literal = search_method("fusebot", target)
    return replace(
        literal,
        policy=replace(literal.policy, gamma=constants.gamma, tau=constants.tau),
        belief=replace(literal.belief, kernels=RfKernels(amplitude=constants.amplitude)),
        cluster_threshold=constants.cluster,
    )


def task_of(constants: Constants, scene: PileScene, seed: int) -> SearchTask:
    """A pile with 8 tags, as far as there are things for them, the same ones for all constants."""
    x_m, y_m, z_m = (constants.tau_xyz * edge_m for edge_m in PILE_SAR.max_box_m)
    surveyor = replace(PILE_SAR, max_box_m=(x_m, y_m, z_m))
    tags = tagged_items_of(scene, "any", TAGS, seed)
    return SearchTask(scene, tags, seed, spacing_m=constants.spacing_m, surveyor=surveyor)


def search(constants: Constants, scene: PileScene, seed: int) -> SearchResult:
    """Search one pile."""
    task = task_of(constants, scene, seed)
    return SearchRun.of(task, method_of(constants, task.tags.target_size)).run()


def actions(constants: Constants, scene: PileScene, seed: int) -> float | None:
    """Actions until the target is found, 16 if it is not; None if the simulation blew up."""
    result = search(constants, scene, seed)
    if result.outcome == ARM_STOPPED:
        return None
    return float(result.actions) if result.found else LOST


def gathered(families: Iterable[str], seeds: Iterable[int], only: Sequence[str]) -> Iterator[Row]:
    """Search every pile with the default and with each value; one row for each pile and value, both actions in it."""
    for family in families:
        for seed in seeds:
            try:
                scene = pile_scene(family, seed)
            except NoPile as none:
                print(none, file=sys.stderr)
                continue
            default = actions(DEFAULT, scene, seed)
            if default is None:
                print(f"{family} {seed}: blew up with the default, nothing to compare with", file=sys.stderr)
                continue
            for name in only:
                for value in VALUES[name]:
                    moved = actions(replace(DEFAULT, **{name: value}), scene, seed)
                    yield {
                        "family": family, "seed": seed, "constant": name, "value": value,
                        "default_actions": default, "actions": moved,
                    }  # fmt: skip


def judged(rows: Sequence[Row], family: str, name: str, value: float) -> Moved | None:
    """What one value does in one family, or in `all`; None where no pile was searched with both."""
    pairs = np.array([
        (row["actions"], row["default_actions"])
        for row in rows
        if (row["constant"], row["value"]) == (name, value)
        and family in ("all", row["family"])
        and row["actions"] is not None
    ], dtype=np.float64)  # fmt: skip
    if not len(pairs):
        return None
    moved, default = pairs.T
    less = moved - default
    limits = bootstrap_interval(less, "mean", np.random.default_rng(0)) if len(pairs) > 1 else None
    return Moved(
        family, name, value, getattr(DEFAULT, name), len(pairs), float(moved.mean()), float(default.mean()),
        float(less.mean()), limits and limits.low, limits and limits.high, float((less != 0).mean()),
        float((moved < LOST).mean()), float((default < LOST).mean()),
    )  # fmt: skip


def all_judged(rows: Sequence[Row], families: Sequence[str], only: Sequence[str]) -> list[Moved]:
    """Every value, family by family, then in all of them if there are several."""
    groups = [*families, "all"] if len(families) > 1 else families
    found = [judged(rows, group, name, value) for group in groups for name in only for value in VALUES[name]]
    return [moved for moved in found if moved is not None]


def line(moved: Moved) -> str:
    """One line of the table."""
    interval = "" if moved.low is None else f" ({moved.low:.2f} … {moved.high:.2f})"
    return (
        f"| {moved.family} | {moved.constant} | {moved.default:g} → {moved.value:g} | {moved.pairs} | "
        f"{moved.default_actions:.2f} → {moved.actions:.2f} | "
        f"{moved.difference:.2f}{interval} | {100 * moved.changed:.0f} | "
        f"{100 * moved.default_found:.0f} → {100 * moved.found:.0f} |"
    )


HEAD = """| piles | constant | value | pairs | actions, 16 where lost | less the default | changed, % | found, % |
| --- | --- | --- | ---: | ---: | ---: | ---: | ---: |"""


def main(argv: Sequence[str] | None = None) -> int:
    """Print a table, or JSON."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seeds", default="0:12", help="first:last, below 1000")
    parser.add_argument("--family", nargs="+", default=list(FAMILIES), help="families of piles")
    parser.add_argument("--only", nargs="+", choices=list(VALUES), default=list(VALUES), help="constants to move")
    parser.add_argument("--json", action="store_true", help="print every search and every difference as JSON")
    asked = parser.parse_args(argv)
    seeds, rows = tuning_seeds(asked.seeds), []
    for row in gathered(asked.family, seeds, asked.only):
        rows.append(row)
        print(*row.values(), file=sys.stderr, flush=True)
    found = all_judged(rows, asked.family, asked.only)
    if asked.json:
        print(json.dumps({"seeds": asked.seeds, "searches": rows, "moved": [asdict(moved) for moved in found]}))
    else:
        print("\n".join([HEAD, *map(line, found)]))
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
