"""Kinds of pile scenes: how many piles of how many items, poured or aimed at the target."""

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

from rfcompass.errors import PileError
from rfcompass.types.record import Record

# Middle of each pile on the table, for one, two and three piles [m]; ours.
PLACES_M: Mapping[int, tuple[tuple[float, float], ...]] = MappingProxyType(
    {
        1: ((0.0, 0.0),),
        2: ((-0.24, 0.0), (0.24, 0.0)),
        3: ((-0.26, -0.15), (0.26, -0.15), (0.0, 0.24)),
    }
)
WAYS = ("poured", "covered")


@dataclass(frozen=True, slots=True)
class PileFamily(Record):
    """A kind of scene.

    In a poured pile nothing is aimed: a few items of a target's size are poured among the rest, and one of them that is
    as hidden as wanted becomes the target. In a covered one the target is laid first and covers are let go above it.

    Attributes:
        name: What it is called.
        way: `"poured"` or `"covered"`.
        distractors: Distractors in each pile; the target comes on top of that, in a pile drawn anew.
        cover_share: Probability that a distractor is a cover.
        cushion_share: Probability that a distractor is a cushion; in a poured pile.
        candidates: Items of a target's size poured with the target's pile, of its distractors and the target.
    """

    name: str
    way: str
    distractors: tuple[int, ...]
    cover_share: float = 0.35
    candidates: int = 3
    cushion_share: float = 0.0

    def __post_init__(self) -> None:
        """Check that such scenes can be."""
        object.__setattr__(self, "distractors", tuple(self.distractors))
        for fine, key, what in (
            (self.way in WAYS, "way", f"is none of {', '.join(WAYS)}"),
            (len(self.distractors) in PLACES_M, "distractors", "are not of one, two or three piles"),
            (all(n >= 1 for n in self.distractors), "distractors", "leave a pile without one"),
            (0 <= self.cover_share <= 1, "cover_share", "is no probability"),
            (0 <= self.cushion_share <= 1 - self.cover_share, "cushion_share", "is no probability beside the covers'"),
            (self.candidates >= 1, "candidates", "are not at least one"),
        ):
            if not fine:
                got = getattr(self, key)
                raise PileError(f"family {self.name}: {key} {got!r} {what}", key=key, got=got)


# The paper's levels of complexity: 20, 25 and 42 distractors in two, three and three piles; the smallest is ours.
_LEVELS = {"1p10": (10,), "2p20": (10, 10), "3p25": (9, 8, 8), "3p42": (14, 14, 14)}
# Of soft things, for the paper's deformable kernel: about two thirds of the distractors are covers or cushions.
_SOFT = tuple(
    PileFamily(f"soft_{level}", "poured", _LEVELS[level], cover_share=0.2, cushion_share=0.45)
    for level in ("1p10", "3p25")
)
FAMILIES: Mapping[str, PileFamily] = MappingProxyType(
    {f"{way}_{level}": PileFamily(f"{way}_{level}", way, counts) for way in WAYS for level, counts in _LEVELS.items()}
    | {kind.name: kind for kind in _SOFT}
)


def family(name: str) -> PileFamily:
    """Return a shipped family by its name.

    Raises:
        PileError: If there is none; carries those that are `known`.
    """
    if name not in FAMILIES:
        known = list(FAMILIES)
        raise PileError(f"no pile family {name!r}; there are {', '.join(known)}", key="family", got=name, known=known)
    return FAMILIES[name]
