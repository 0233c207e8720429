"""Builds one pile about the origin: one with a target of the wanted class, or one of distractors alone."""

from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from rfcompass.arrays import FloatArray
from rfcompass.errors import PileError, PileUnsettled
from rfcompass.simulation.piles.camera import scan_poses
from rfcompass.simulation.piles.catalogue import draw_distractor, draw_item, draw_target
from rfcompass.simulation.piles.engine import PilePhysics
from rfcompass.simulation.piles.families import PileFamily
from rfcompass.simulation.piles.items import PileItem
from rfcompass.simulation.piles.pouring import pour
from rfcompass.simulation.piles.visibility import sights
from rfcompass.types.record import Record

# Covers that are let go above a target, and how far off its middle, as a share of the cover's length; ours.
_COVERS = {"hidden": (3, 0.08), "partly": (1, 0.45), "open": (0, 0.0)}
# How far from the middle of a covered target the other items are let go [m]; ours.
_AROUND_M = (0.07, 0.12)
# How often a pile of distractors is poured until it comes to rest.
_POURS = 6


@dataclass(frozen=True, slots=True)
class OnePile(Record):
    """A pile in its own place.

    Attributes:
        items: What is in it.
        states: State of each item, by number.
        target: Number of the target, if there is one.
    """

    items: tuple[PileItem, ...]
    states: dict[int, FloatArray]
    target: int | None = None

    @property
    def with_target(self) -> int:
        """Number of the target.

        Raises:
            PileError: If there is none.
        """
        if self.target is None:
            raise PileError("the pile has no target", key="target")
        return self.target


def target_pile(kind: PileFamily, wanted: str, count: int, rng: np.random.Generator, physics: PilePhysics) -> OnePile:
    """Build the pile with the target about the origin, its items numbered from 1.

    Args:
        kind: The family.
        wanted: Class of target.
        count: Distractors in this pile.
        rng: Source of everything.
        physics: Constants of the simulation.

    Returns:
        The pile; without a target if none came out as wanted.

    Raises:
        PileUnsettled: If it does not come to rest.
    """
    way = _covered_pile if kind.way == "covered" else partial(_poured_pile, kind)
    return way(wanted, count, rng, physics)


def _poured_pile(kind: PileFamily, wanted: str, count: int, rng: np.random.Generator, physics: PilePhysics) -> OnePile:
    candidates = min(kind.candidates, count + 1)
    items = [draw_target(number, rng) for number in range(1, candidates + 1)]
    items += [
        draw_distractor(number, kind.cover_share, rng, kind.cushion_share)
        for number in range(candidates + 1, count + 2)
    ]
    # Poured in any order: a target may be the first or the last to go in.
    world = pour([items[i] for i in rng.permutation(len(items))], rng, physics=physics)
    seen = sights(world, list(range(1, candidates + 1)), scan_poses())
    fits = [number for number, sight in seen.items() if sight.target_class == wanted]
    if not fits:
        return OnePile(world.items, world.states)
    target = int(rng.choice(fits))
    # All candidates were drawn red; those not chosen get another colour, as nothing but the target may be red.
    spare = {n: draw_item(n, "box", rng).rgb for n in range(1, candidates + 1) if n != target}
    dyed = [replace(item, rgb=spare.get(item.number, item.rgb)) for item in world.items]
    return OnePile(tuple(dyed), world.states, target)


def _covered_pile(wanted: str, count: int, rng: np.random.Generator, physics: PilePhysics) -> OnePile:
    target = draw_target(1, rng)
    covers, off = min(_COVERS[wanted][0], count), _COVERS[wanted][1]
    aimed = [draw_item(number, "cover", rng) for number in range(2, covers + 2)]
    rest = [draw_distractor(number, 0.0, rng) for number in range(covers + 2, count + 2)]
    middle_m = rng.normal(size=2) * 0.02
    places = {target.number: middle_m}
    for cover in aimed:
        places[cover.number] = middle_m + off * cover.size_m[0] * _direction(rng)
    for item in rest:
        places[item.number] = middle_m + rng.uniform(*_AROUND_M) * _direction(rng)
    below, above = rest[: len(rest) // 2], rest[len(rest) // 2 :]
    order = [*below, *above, target] if wanted == "open" else [target, *below, *aimed, *above]
    world = pour(order, rng, aimed=places, physics=physics)
    sight = sights(world, [target.number], scan_poses())[target.number]
    return OnePile(world.items, world.states, target.number if sight.target_class == wanted else None)


def _direction(rng: np.random.Generator) -> FloatArray:
    angle = rng.uniform(0.0, 2 * np.pi)
    return np.array([np.cos(angle), np.sin(angle)])


def other_pile(kind: PileFamily, count: int, first: int, rng: np.random.Generator, physics: PilePhysics) -> OnePile:
    """Build a pile of distractors about the origin, numbered from `first`; arguments as for `target_pile`.

    Poured again if it does not come to rest, as it has no say in where the target is.
    """
    for pour_again in reversed(range(_POURS)):
        items = [
            draw_distractor(number, kind.cover_share, rng, kind.cushion_share) for number in range(first, first + count)
        ]
        try:
            world = pour(items, rng, physics=physics)
        except PileUnsettled:
            if not pour_again:
                raise
        else:
            break
    return OnePile(world.items, world.states)
