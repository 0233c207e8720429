"""Puts RFID tags on items of a pile, near the target or far from it [Boroushaki2023], Sec. 8.2.2."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from rfcompass.arrays import FloatArray, read_only
from rfcompass.errors import PileError
from rfcompass.simulation.piles.items import PileItem
from rfcompass.simulation.piles.scene import PileScene
from rfcompass.simulation.piles.world import PileWorld
from rfcompass.types.epc import canonical_epc
from rfcompass.types.items import ItemSize
from rfcompass.types.record import Record

PLACEMENTS = ("none", "any", "touching", "same_pile", "opposite", "other_pile", "target")
# Horizontal distance from the target at which an item of its pile counts as on the opposite side [m]; ours.
OPPOSITE_M = 0.08


@dataclass(frozen=True, slots=True)
class ItemTag(Record):
    """A tag glued to an item.

    Attributes:
        epc: Its EPC.
        number: The item's number.
        point_m: Middle of the tag in the item frame, of a cover's middle panel, a cushion's lower half [m], shape (3,).
        dipole: Direction of its antenna in that frame, unit vector, shape (3,).
    """

    epc: str
    number: int
    point_m: FloatArray
    dipole: FloatArray

    def __post_init__(self) -> None:
        """Freeze; write the EPC as everybody does."""
        set_ = object.__setattr__
        set_(self, "epc", canonical_epc(self.epc))
        set_(self, "point_m", read_only(self.point_m, "ItemTag.point_m", (3,)))
        set_(self, "dipole", read_only(self.dipole, "ItemTag.dipole", (3,)))


@dataclass(frozen=True, slots=True)
class TaggedItems(Record):
    """The tags of a scene.

    Attributes:
        tags: One for each tagged item.
        sizes: What the database says of the tagged items; says nothing about where they are.
        target_size: The same of the target.
    """

    tags: tuple[ItemTag, ...]
    sizes: tuple[ItemSize, ...]
    target_size: ItemSize

    def placed(self, world: PileWorld) -> tuple[list[str], FloatArray, FloatArray]:
        """Where the tags of the items that are still there are now: truth.

        Returns:
            EPCs (N), points (N, 3) [m] and dipole directions (N, 3) in the world frame.
        """
        there = {item.number for item in world.items}
        tags = [tag for tag in self.tags if tag.number in there]
        poses = [world.pose(tag.number) for tag in tags]
        points = [T[:3, :3] @ tag.point_m + T[:3, 3] for T, tag in zip(poses, tags, strict=True)]
        dipoles = [T[:3, :3] @ tag.dipole for T, tag in zip(poses, tags, strict=True)]
        return [tag.epc for tag in tags], np.reshape(points, (-1, 3)), np.reshape(dipoles, (-1, 3))


def tag_items(
    scene: PileScene, placement: str, count: int, rng: np.random.Generator, *, only_soft: bool = False
) -> TaggedItems:
    """Choose which items are tagged, and where on them.

    "touching": at least one touches the target. "same_pile": at least one is in the target's pile, and none touches it.
    "opposite": all are on the opposite side of the target's pile or in other piles, at least one is opposite.
    "other_pile": all are in other piles. "target": the target is tagged, too. "any": wherever. "none": no tags.
    The opposite side lies beyond the pile's middle as seen from the target, `OPPOSITE_M` away from it or more.

    Args:
        scene: The scene; items of liquid and metal stay untagged.
        placement: One of `PLACEMENTS`.
        count: Tagged distractors.
        rng: Source of the choice.
        only_soft: Whether only distractors that give way are tagged.

    Raises:
        PileError: If there are not enough such items; says how many there are.
    """
    if placement not in PLACEMENTS or (placement == "none" and count):
        message = f"placement {placement!r} of {count} tags: it is one of {', '.join(PLACEMENTS)}, 'none' of none"
        raise PileError(message, key="placement", got=placement)
    where = _Neighbourhood(scene, scene.world(), only_soft)
    first, rest = where.allowed(placement)
    chosen = _chosen(first, rest, count, placement, rng)
    if placement == "target":
        chosen = [scene.target, *chosen]
    items = {item.number: item for item in scene.items}
    # EPCs are dealt at random: what the database and the reader know must not tell the labels of true masks.
    dealt = [int(number) for number in rng.permutation(np.array(chosen, dtype=np.int64))]
    tags = tuple(_tag(items[number], index, rng) for index, number in enumerate(dealt))
    sizes = tuple(items[tag.number].sized(f"{items[tag.number].kind}_{tag.epc[-3:]}", tag.epc) for tag in tags)
    epc = next((tag.epc for tag in tags if tag.number == scene.target), None)
    return TaggedItems(tags, sizes, items[scene.target].sized("target", epc))


class _Neighbourhood:
    """Where taggable distractors are, as seen from the target."""

    def __init__(self, scene: PileScene, world: PileWorld, only_soft: bool) -> None:
        self._scene = scene
        self._touching = world.touching(scene.target)
        self._centres_m = {item.number: world.pose(item.number)[:2, 3] for item in scene.items}
        self.numbers = [
            item.number
            for item in scene.items
            if item.taggable and item.number != scene.target and (item.deformable or not only_soft)
        ]

    def allowed(self, placement: str) -> tuple[list[int], list[int]]:
        """Items of which one must be tagged, and all that may be."""
        rules: dict[str, tuple[Callable[[int], bool], Callable[[int], bool]]] = {
            "touching": (self._touches, self._anywhere),
            "same_pile": (lambda n: self._beside(n) and not self._touches(n), lambda n: not self._touches(n)),
            "opposite": (self._opposite, lambda n: self._opposite(n) or not self._beside(n)),
            "other_pile": (lambda n: not self._beside(n), lambda n: not self._beside(n)),
        }
        must, may = rules.get(placement, (self._anywhere, self._anywhere))
        return [n for n in self.numbers if must(n)], [n for n in self.numbers if may(n)]

    def _anywhere(self, _: int) -> bool:
        return True

    def _touches(self, number: int) -> bool:
        return number in self._touching

    def _beside(self, number: int) -> bool:
        return self._scene.piles[number] == self._scene.piles[self._scene.target]

    def _opposite(self, number: int) -> bool:
        if not self._beside(number) or self._touches(number):
            return False
        middle_m = np.mean(
            [self._centres_m[item.number] for item in self._scene.items if self._beside(item.number)], axis=0
        )
        target_m, item_m = self._centres_m[self._scene.target], self._centres_m[number]
        beyond = (item_m - middle_m) @ (target_m - middle_m) < 0
        return bool(beyond and np.linalg.norm(item_m - target_m) >= OPPOSITE_M)


def _chosen(must: Sequence[int], may: Sequence[int], count: int, placement: str, rng: np.random.Generator) -> list[int]:
    if count <= 0:
        if count < 0:
            raise PileError(f"{count} tags cannot be", key="count", got=count)
        return []
    if not must or len(may) < count:
        message = f"{placement}: {count} tags wanted, {len(must)} items must and {len(may)} may have one"
        raise PileError(message, key="count", got=count, must=len(must), may=len(may))
    first = int(rng.choice(must))
    others = [number for number in may if number != first]
    return [first, *(int(n) for n in rng.choice(others, count - 1, replace=False))]


def _tag(item: PileItem, index: int, rng: np.random.Generator) -> ItemTag:
    points, _, dipoles = item.tag_places()
    place = int(rng.integers(len(points)))
    return ItemTag(f"5246434f4d50415353f{index:05x}", item.number, points[place], dipoles[place])
