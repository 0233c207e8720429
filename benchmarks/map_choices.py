"""Which map and which reading of Eq. 4 would take the thing that lies over the target, at each decision of a search?

    RFCOMPASS_PILE_SCENES=FOLDER python -m benchmarks.map_choices --seeds 0:16 --family covered_3p25

Hidden targets, no tags. `fusebot_equal` (Eq. 4 on the paper's map) searches; at each of its decisions all rules are
asked the same question, and the simulator tells which object lies over the target's middle. Decisions where nothing in
sight does are left out. Printed for each rule, at the first decision and at later ones: how often that object has the
largest score, and -log2 of its share of all scores, the mean over decisions. So states are those that the paper's map
leads to, and a thing beside may bring the target to light as well: this says what maps know, not how searches go.
"""

import argparse
import json
import sys
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import asdict, dataclass, field, replace

import numpy as np

from benchmarks.search_sensitivity import tuning_seeds
from planners.extraction.projection import MaskColumns, project_masks
from planners.extraction.scores import GAMMA, mask_scores
from planners.search_beliefs import Belief, Fixes, PaperBelief, PosteriorBelief, XRayBelief
from rfcompass.arrays import FloatArray, IntArray
from rfcompass.errors import NoPile
from rfcompass.interfaces import ExtractionPolicy
from rfcompass.mapping import VisualMap
from rfcompass.simulation.piles import PileScene
from rfcompass.studies.pile_robot import SimulatedPileRobot
from rfcompass.studies.pile_scenes import FAMILIES, pile_scene
from rfcompass.studies.search_methods import search_method
from rfcompass.studies.searching import SearchRun, SearchTask, tagged_items_of
from rfcompass.types import DepthView, ExtractionAction, GraspMaps, InstanceMasks, ItemSize, VoxelGrid
from rfcompass.types.record import Record

LEAST_SHARE = 1e-4  # a share below counts as this: a rule that gives the right thing nothing would cost infinitely much


@dataclass(frozen=True, slots=True, kw_only=True)
class Rule(Record):
    """A map, and how Eq. 4 reads it.

    Attributes:
        name: What the table calls it.
        belief: The map.
        power: Power that the map is taken to first; below 1 it is trusted less.
        gamma: Discount for each 2.5 cm.
        per_column: Measure depth under the surface of each column.
    """

    name: str
    belief: Belief
    power: float = 1.0
    gamma: float = GAMMA
    per_column: bool = False

    def shares(self, grid: VoxelGrid, columns: MaskColumns, labels: IntArray) -> FloatArray:
        """Share of each label in the sum of all scores, shape (K,)."""
        trusted = replace(grid, values=np.maximum(grid.values, 0.0) ** self.power)
        scores = mask_scores(trusted, columns, labels, self.gamma, per_column=self.per_column)
        return np.asarray(scores / max(scores.sum(), np.finfo(float).tiny))


RULES = (
    Rule(name="paper", belief=PaperBelief()),
    Rule(name="paper, per column", belief=PaperBelief(), per_column=True),
    Rule(name="posterior", belief=PosteriorBelief()),
    Rule(name="posterior, per column", belief=PosteriorBelief(), per_column=True),
    Rule(name="posterior, per column, γ 0.3", belief=PosteriorBelief(), gamma=0.3, per_column=True),
    Rule(name="posterior^0.3, per column", belief=PosteriorBelief(), power=0.3, per_column=True),
    Rule(name="X-Ray, all views", belief=XRayBelief()),
    Rule(name="X-Ray, all views, γ 1", belief=XRayBelief(), gamma=1.0),
)


@dataclass(frozen=True, slots=True)
class Asked(Record):
    """What one rule said at one decision.

    Attributes:
        family: Of the pile, and its `seed`.
        later: Whether it was not the search's first decision.
        rule: Which one.
        first: Whether the thing over the target had the largest score.
        share: Its share of all scores.
        height_m: How high over the world's origin the thing with the largest score reaches.
    """

    family: str
    seed: int
    later: bool
    rule: str
    first: bool
    share: float
    height_m: float


@dataclass(eq=False)
class Onlooker:
    """Belief and policy of a search: the paper's map, and what `policy` chooses. Asks all rules in passing."""

    robot: SimulatedPileRobot
    policy: ExtractionPolicy
    family: str
    asked: list[Asked] = field(default_factory=list)
    _grids: dict[str, VoxelGrid] = field(default_factory=dict)
    _decisions: int = 0

    def believe(self, seen: VisualMap, target: ItemSize, fixes: Fixes, sizes: Sequence[ItemSize]) -> VoxelGrid:
        """The paper's map; those of all rules are kept for the choice."""
        grids = {belief: belief.believe(seen, target, fixes, sizes) for belief in {rule.belief for rule in RULES}}
        self._grids = {rule.name: grids[rule.belief] for rule in RULES}
        self._decisions += 1
        return grids[PaperBelief()]

    def choose(
        self,
        grid: VoxelGrid,
        view: DepthView,
        masks: InstanceMasks,
        grasps: GraspMaps,
        failed_m: Sequence[FloatArray] = (),
    ) -> ExtractionAction:
        """The policy's choice. A choice that is asked for again, without what is out of reach, is no new decision."""
        if self._grids:
            self._ask_all(grid, view, masks)
            self._grids = {}
        return self.policy.choose(grid, view, masks, grasps, failed_m)

    def _ask_all(self, grid: VoxelGrid, view: DepthView, masks: InstanceMasks) -> None:
        columns = project_masks(grid, view, masks)
        middle_m = self.robot.world.pose(self.robot.scene.target)[:3, 3]
        i, j, _ = np.rint((middle_m - grid.origin_m) / grid.spacing_m).astype(int)
        over = int(columns.owner[i, j])
        if over == 0:
            return
        labels = np.unique(columns.owner[columns.owner > 0])
        for rule in RULES:
            shares = rule.shares(self._grids[rule.name], columns, labels)
            best = int(labels[shares.argmax()])
            height_m = float(np.nanmax(columns.surface_m[columns.owner == best]))
            share = float(shares[labels == over][0])
            seed = self.robot.scene.seed
            self.asked.append(Asked(self.family, seed, self._decisions > 1, rule.name, best == over, share, height_m))


def asked_in(family: str, scene: PileScene) -> list[Asked]:
    """Search one pile, and ask."""
    tags = tagged_items_of(scene, "none", 0, scene.seed)
    task, method = SearchTask(scene, tags, scene.seed), search_method("fusebot_equal", tags.target_size)
    robot = task.robot()
    onlooker = Onlooker(robot, method.policy, family)
    SearchRun(task, replace(method, policy=onlooker, belief=onlooker), robot).run()
    return onlooker.asked


def gathered(families: Iterable[str], seeds: Iterable[int]) -> Iterator[Asked]:
    """Ask in every pile that can be made."""
    for family in families:
        for seed in seeds:
            try:
                yield from asked_in(family, pile_scene(family, seed))
            except NoPile as none:
                print(none, file=sys.stderr)


def line(rule: str, rows: Sequence[Asked]) -> str:
    """A line of the table: the first decision, later ones, all."""
    cells = []
    for of in ((False,), (True,), (False, True)):
        these = [row for row in rows if row.rule == rule and row.later in of]
        if not these:
            cells.append("–")
            continue
        first = np.mean([row.first for row in these])
        bits = -np.log2([max(row.share, LEAST_SHARE) for row in these]).mean()
        height_m = np.mean([row.height_m for row in these])
        cells.append(f"{first:.2f} · {bits:.2f} · {100 * height_m:.1f}, {len(these)}")
    return f"| {rule} | {' | '.join(cells)} |"


HEAD = """{family}: how often it comes first · bits · height of what comes first [cm], decisions

| map | first decision | later ones | all |
| --- | ---: | ---: | ---: |"""


def main(argv: Sequence[str] | None = None) -> int:
    """Print a table for each family, or JSON."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seeds", default="0:16", help="first:last, below 1000")
    parser.add_argument("--family", nargs="+", default=list(FAMILIES), help="families of piles")
    parser.add_argument("--json", action="store_true", help="print every answer as JSON")
    asked = parser.parse_args(argv)
    rows = list(gathered(asked.family, tuning_seeds(asked.seeds)))
    if asked.json:
        print(json.dumps([asdict(row) for row in rows]))
        return 0
    for family in asked.family:
        these = [row for row in rows if row.family == family]
        print("\n".join([HEAD.format(family=family), *(line(rule.name, these) for rule in RULES)]), end="\n\n")
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
