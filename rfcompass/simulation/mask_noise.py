"""What segmentation gets wrong: objects run together, fall apart, or are not seen."""

from dataclasses import dataclass

import numpy as np
from scipy import ndimage

from rfcompass.arrays import IntArray
from rfcompass.errors import InputError
from rfcompass.types.piles import InstanceMasks
from rfcompass.types.record import Record

_TOUCH = np.ones((5, 5), dtype=bool)  # masks that are at most two pixels apart are neighbours


@dataclass(frozen=True, slots=True)
class MaskNoise(Record):
    """Chances that a mask is wrong; ours, no paper prints any.

    Attributes:
        merge: Chance that an object is joined with a neighbour, where it has one.
        split: Chance that an object is cut in two, through its middle.
        drop: Chance that an object becomes background.
    """

    merge: float = 0.15
    split: float = 0.08
    drop: float = 0.12

    def __post_init__(self) -> None:
        """Check the chances."""
        for name in ("merge", "split", "drop"):
            if not 0 <= (chance := getattr(self, name)) <= 1:
                raise InputError(f"MaskNoise.{name}: {chance} is no chance", name=name, got=chance)

    def apply(self, masks: InstanceMasks, rng: np.random.Generator) -> InstanceMasks:
        """Return masks with errors: each object is merged, then split, then dropped, or not.

        Objects that are merged keep the smaller of their numbers, the second half of a split one gets a new number.
        """
        labels = masks.labels.copy()
        objects = np.unique(labels[labels > 0])
        chances = rng.random((objects.size, 4))
        for label, (merge, _, _, pick) in zip(objects, chances, strict=True):
            if merge < self.merge:
                _merge(labels, int(label), pick)
        for label, (_, split, _, turn) in zip(objects, chances, strict=True):
            if split < self.split:
                _split(labels, int(label), np.pi * turn)
        for label, (_, _, drop, _) in zip(objects, chances, strict=True):
            if drop < self.drop:
                labels[labels == label] = 0
        return InstanceMasks(labels)


def _merge(labels: IntArray, label: int, pick: float) -> None:
    around = ndimage.binary_dilation(labels == label, structure=_TOUCH)
    neighbours = np.setdiff1d(labels[around], [0, label])
    if neighbours.size:
        other = int(neighbours[int(pick * neighbours.size)])
        labels[(labels == label) | (labels == other)] = min(label, other)


def _split(labels: IntArray, label: int, turn_rad: float) -> None:
    rows, columns = np.nonzero(labels == label)
    if rows.size:
        side = (rows - rows.mean()) * np.cos(turn_rad) + (columns - columns.mean()) * np.sin(turn_rad)
        labels[rows[side > 0], columns[side > 0]] = labels.max() + 1
