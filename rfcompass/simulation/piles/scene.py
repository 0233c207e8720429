"""One pile scene at rest: all there is to know of it, and a hash of that."""

import hashlib
import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field

from rfcompass.arrays import FloatArray, plain, read_only
from rfcompass.errors import PileError
from rfcompass.simulation.piles.engine import PilePhysics
from rfcompass.simulation.piles.items import PileItem
from rfcompass.simulation.piles.world import PileWorld
from rfcompass.types.record import Record, frozen_mapping

# Constants are chosen on seeds below; results are reported on seeds from here on.
FIRST_REPORT_SEED = 1000


@dataclass(frozen=True, slots=True)
class PileScene(Record):
    """Items at rest on a table, one of them the target. Truth: estimators never hold one.

    Attributes:
        family: Name of the pile family it was drawn from.
        seed: Seed it was drawn with.
        target_class: `"hidden"`, `"partly"` or `"open"`.
        items: Everything on the table.
        states: Place, quaternion (w, x, y, z) and hinges of each item, by number [m, -, rad].
        piles: Index of the pile that each item belongs to, by number.
        target: Number of the target.
        tries: How many piles were poured until one was of this class.
        physics: Constants of the simulation.
    """

    family: str
    seed: int
    target_class: str
    items: tuple[PileItem, ...]
    states: Mapping[int, FloatArray]
    piles: Mapping[int, int]
    target: int
    tries: int = 1
    physics: PilePhysics = field(default_factory=PilePhysics)

    def __post_init__(self) -> None:
        """Freeze; check that every item has a state and a pile, and that the target is one of them."""
        set_, numbers = object.__setattr__, [item.number for item in self.items]
        set_(self, "items", tuple(self.items))
        states = {
            number: read_only(state, f"PileScene.states[{number}]", (None,)) for number, state in self.states.items()
        }
        set_(self, "states", frozen_mapping(states))
        set_(self, "piles", frozen_mapping(self.piles))
        for key, known in (("states", self.states), ("piles", self.piles)):
            if sorted(known) != sorted(numbers):
                raise PileError(f"scene: {key} of items {sorted(known)}, not of {sorted(numbers)}", key=key)
        if self.target not in numbers:
            raise PileError(f"scene: the target, {self.target}, is none of {numbers}", key="target", got=self.target)

    @property
    def for_tuning(self) -> bool:
        """Whether constants may be chosen on it; reports must not use it then."""
        return self.seed < FIRST_REPORT_SEED

    def world(self) -> PileWorld:
        """Make a table like this, for things to happen on.

        Raises:
            MissingExtra: If MuJoCo is not installed.
        """
        return PileWorld(self.items, self.states, self.physics)

    @property
    def contents(self) -> dict[str, object]:
        """Everything but the hash, as JSON can hold it; numbers keep all their bits."""
        return {
            "family": self.family,
            "seed": self.seed,
            "target_class": self.target_class,
            "tries": self.tries,
            "target": self.target,
            "physics": asdict(self.physics),
            "items": [
                {
                    "number": item.number,
                    "kind": item.kind,
                    "size_m": plain(item.size_m),
                    "material": item.material,
                    "rgb": list(item.rgb),
                    "pile": self.piles[item.number],
                    "state": plain(self.states[item.number]),
                }
                for item in self.items
            ],
        }

    @property
    def fingerprint(self) -> str:
        """SHA-256 of all contents to the last bit, 64 hexadecimal digits."""
        text = json.dumps(self.contents, sort_keys=True, separators=(",", ":"), allow_nan=False)
        return hashlib.sha256(text.encode()).hexdigest()
