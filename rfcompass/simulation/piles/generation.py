"""Makes pile scenes from a family, a class of target and a seed; the same three give the same scene, bit for bit.

A pile is poured until its target is of the wanted class: hidden from all eight scan views, partly covered, or in the
open. Where the piles end is thus selected, and how often a pour was good enough is part of the answer.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from zlib import crc32

import numpy as np

from rfcompass.arrays import FloatArray
from rfcompass.errors import NoPile, PileError, PileUnsettled
from rfcompass.simulation.piles.camera import scan_poses
from rfcompass.simulation.piles.engine import PilePhysics
from rfcompass.simulation.piles.families import PLACES_M, PileFamily, family
from rfcompass.simulation.piles.one_pile import OnePile, other_pile, target_pile
from rfcompass.simulation.piles.scene import PileScene
from rfcompass.simulation.piles.visibility import TARGET_CLASSES, sights
from rfcompass.simulation.piles.world import PileWorld

# How a try can end without a scene: piles that do not come to rest, no item of a target's size of the wanted class in
# its pile, none any more once the other piles stand beside it, and scenes in which something gives way after a while.
STAGES = ("unsettled", "target", "composed", "creeping")
_WHY = {
    "unsettled": "did not come to rest",
    "target": "had no target of that kind",
    "composed": "had none beside the other piles",
    "creeping": "gave way after a while",
}
# Nothing in a scene may move further than this in two seconds in which nobody does anything [m]; ours.
WORST_CREEP_M = 0.002


@dataclass(slots=True)
class PileTally:
    """How tries ended, counted.

    Attributes:
        made: Scenes that came out.
        failed: Tries that ended without one, by stage.
    """

    made: int = 0
    failed: dict[str, int] = field(default_factory=lambda: dict.fromkeys(STAGES, 0))

    @property
    def tries(self) -> int:
        """All tries."""
        return self.made + sum(self.failed.values())


def make_pile(
    of_family: PileFamily | str,
    seed: int,
    target_class: str = "hidden",
    *,
    most_tries: int = 60,
    tally: PileTally | None = None,
    physics: PilePhysics | None = None,
) -> PileScene:
    """Make a scene.

    Args:
        of_family: A family, or the name of one that is shipped.
        seed: Below 1000 for choosing constants, from 1000 on for results.
        target_class: `"hidden"`, `"partly"` or `"open"`.
        most_tries: Give up after so many.
        tally: Counts how the tries end, if one wants to know.
        physics: Constants of the simulation.

    Raises:
        PileError: If family, class or seed cannot be.
        NoPile: If no try gave such a scene; says at which stage they ended.
        MissingExtra: If MuJoCo is not installed.
    """
    kind = family(of_family) if isinstance(of_family, str) else of_family
    if target_class not in TARGET_CLASSES:
        message = f"target class {target_class!r} is none of {', '.join(TARGET_CLASSES)}"
        raise PileError(message, key="target_class", got=target_class)
    if seed < 0:
        raise PileError(f"seed {seed} is below 0", key="seed", got=seed)
    count = PileTally() if tally is None else tally
    here = PileTally()
    for number in range(most_tries):
        start = (crc32(kind.name.encode()), TARGET_CLASSES.index(target_class), seed, number)
        rng = np.random.default_rng(start)
        made = _try(kind, target_class, rng, PilePhysics() if physics is None else physics)
        if isinstance(made, PileScene):
            count.made += 1
            return replace(made, seed=seed, tries=number + 1)
        for tallied in (count, here):
            tallied.failed[made] += 1
    ended = ", ".join(f"{count} {_WHY[stage]}" for stage, count in here.failed.items() if count)
    message = f"no {target_class} target in {most_tries} tries of {kind.name} with seed {seed}: {ended}"
    raise NoPile(message, tries=most_tries, stage=here.failed, seed=seed)


def _try(kind: PileFamily, wanted: str, rng: np.random.Generator, physics: PilePhysics) -> PileScene | str:
    """Make a scene, or say at which stage it failed."""
    places_m = np.array(PLACES_M[len(kind.distractors)])
    order = [int(i) for i in rng.permutation(len(places_m))]  # the first of them gets the target
    try:
        first = target_pile(kind, wanted, kind.distractors[order[0]], rng, physics)
        if first.target is None:
            return "target"
        piles, taken = [first], len(first.items)
        for index in order[1:]:
            piles.append(other_pile(kind, kind.distractors[index], taken + 1, rng, physics))
            taken += len(piles[-1].items)
        return _composed(
            kind, wanted, [_placed(*pair) for pair in zip(piles, places_m[order], strict=True)], rng, physics
        )
    except PileUnsettled:
        return "unsettled"


def _composed(
    kind: PileFamily, wanted: str, piles: Sequence[OnePile], rng: np.random.Generator, physics: PilePhysics
) -> PileScene | str:
    """Take piles that are at rest beside each other, the first with the target, and look once more.

    Numbers are dealt anew: the labels of true masks must not tell the target, or the order in which things were poured.
    """
    count = sum(len(pile.items) for pile in piles)
    dealt = dict(zip(range(1, count + 1), (int(n) for n in rng.permutation(count) + 1), strict=True))
    items = [replace(item, number=dealt[item.number]) for pile in piles for item in pile.items]
    states = {dealt[number]: state for pile in piles for number, state in pile.states.items()}
    target, world = dealt[piles[0].with_target], PileWorld(items, states, physics)
    if sights(world, [target], scan_poses())[target].target_class != wanted:
        return "composed"
    if max(world.creep_m().values()) > WORST_CREEP_M:
        return "creeping"
    belongs = {dealt[item.number]: index for index, pile in enumerate(piles) for item in pile.items}
    return PileScene(kind.name, 0, wanted, world.items, world.states, belongs, target, physics=physics)


def _placed(pile: OnePile, place_m: FloatArray) -> OnePile:
    """Move a pile along the table, x and y [m], shape (2,)."""
    moved = {n: state + np.concatenate([place_m, np.zeros(len(state) - 2)]) for n, state in pile.states.items()}
    return OnePile(pile.items, moved, pile.target)
