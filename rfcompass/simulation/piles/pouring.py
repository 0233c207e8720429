"""Builds one pile: items are let go one by one above it, in a drag, and drawn to the middle as hands would."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from rfcompass.arrays import FloatArray
from rfcompass.errors import PileError, PileUnsettled
from rfcompass.simulation.piles.engine import GRAVITY_M_S2, PilePhysics, flat_state, panel_order
from rfcompass.simulation.piles.items import PileItem
from rfcompass.simulation.piles.world import PileWorld
from rfcompass.types.record import Record


@dataclass(frozen=True, slots=True)
class Pouring(Record):
    """How items are let go; all ours.

    Attributes:
        spread_m: Standard deviation of the place where an item is let go, along x and y [m].
        gap_m: Height between the pile's top and the item that is let go [m].
        interval_s: Time between one item and the next [s].
        drag_per_s: Drag that slows the fall, over mass and speed; without it a tall pour scatters [1/s].
        pull: Force to the middle, as a part of the weight at 10 cm from it.
    """

    spread_m: float = 0.035
    gap_m: float = 0.03
    interval_s: float = 0.25
    drag_per_s: float = 8.0
    pull: float = 0.3

    def __post_init__(self) -> None:
        """Check that nothing is negative."""
        for name in self.__slots__:
            if not (np.isfinite(value := getattr(self, name)) and value >= 0):
                raise PileError(f"pouring: {name} is {value!r}, not a finite number >= 0", key=name, got=value)


def pour(
    items: Sequence[PileItem],
    rng: np.random.Generator,
    *,
    aimed: dict[int, FloatArray] | None = None,
    pouring: Pouring | None = None,
    physics: PilePhysics | None = None,
) -> PileWorld:
    """Pour items about the origin in their order, and let them come to rest.

    Args:
        items: What to pour, first one first.
        rng: Source of places and turns.
        aimed: Where some of them are let go all the same, x and y [m], shape (2,), by number.
        pouring: How.
        physics: Constants of the simulation.

    Raises:
        PileUnsettled: If they do not come to rest.
    """
    pouring = Pouring() if pouring is None else pouring
    places = {} if aimed is None else aimed
    world = PileWorld(physics=physics)
    for item in items:
        drawn_m = rng.normal(size=2) * pouring.spread_m
        T = _let_go(item, places.get(item.number, drawn_m), _top_m(world) + pouring.gap_m, rng)
        world.add(item, flat_state(item, T))
        world.drag(pouring.drag_per_s)
        world.step(pouring.interval_s, _pulls(world, pouring.pull))
    world.drag(0.0)
    rest = world.settle()
    if not rest.at_rest:
        message = (
            f"after {rest.passed_s:.1f} s something still moves {1e3 * rest.moved_m:.2f} mm in a quarter of a second"
        )
        raise PileUnsettled(message, simulated_s=rest.passed_s, creep_m=rest.moved_m)
    return world


def _top_m(world: PileWorld) -> float:
    return max((float(world.corners_m(item.number)[:, 2].max()) for item in world.items), default=0.0)


def _pulls(world: PileWorld, pull: float) -> dict[int, FloatArray]:
    forces = {}
    for item in world.items:
        x, y, _ = world.pose(item.number)[:3, 3]
        weight_n = GRAVITY_M_S2 * item.mass_kg / len(panel_order(item))
        forces[item.number] = -pull * weight_n * np.array([x, y, 0.0]) / 0.1
    return forces


def _let_go(item: PileItem, place_m: FloatArray, above_m: float, rng: np.random.Generator) -> FloatArray:
    """Pose at which an item is let go: covers and cushions flat, any heading, cushions either way up, others anyhow."""
    T = np.eye(4)
    if item.deformable:
        yaw = rng.uniform(0.0, np.pi)
        T[:2, :2] = [[np.cos(yaw), -np.sin(yaw)], [np.sin(yaw), np.cos(yaw)]]
        if item.kind == "cushion" and rng.random() < 0.5:
            T[:3, 1:3] *= -1.0
        reach_m = float(item.size_m[2]) / 2
    else:
        T[:3, :3] = random_rotation(rng)
        reach_m = item.radius_m
    T[:3, 3] = *place_m, above_m + reach_m
    return T


def random_rotation(rng: np.random.Generator) -> FloatArray:
    """Draw a rotation, all equally likely, shape (3, 3)."""
    w, x, y, z = (q := rng.normal(size=4)) / np.linalg.norm(q)
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )
