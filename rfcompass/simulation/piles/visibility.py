"""How much of an item a scan sees, and what class of target that makes it; the thresholds are ours."""

from dataclasses import dataclass

import numpy as np

from rfcompass.arrays import FloatArray, IntArray, read_only
from rfcompass.errors import PileError
from rfcompass.simulation.piles.rays import D415, CameraModel, cast_image, count_alone
from rfcompass.simulation.piles.world import PileWorld
from rfcompass.types.record import Record

TARGET_CLASSES = ("hidden", "partly", "open")
# Hidden: no view has a pixel of it. Partly: the view that sees most of it sees this share. Open: at least this share.
PARTLY, OPEN = (0.3, 0.7), 0.95


@dataclass(frozen=True, slots=True)
class Sight(Record):
    """What a scan sees of one item.

    Attributes:
        seen_px: Pixels of it in each view, shape (V,).
        alone_px: Pixels it would have if nothing else were there, shape (V,).
    """

    seen_px: IntArray
    alone_px: IntArray

    def __post_init__(self) -> None:
        """Freeze the counts."""
        for name in ("seen_px", "alone_px"):
            object.__setattr__(self, name, read_only(getattr(self, name), f"Sight.{name}", (None,), np.int64))

    @property
    def share(self) -> float:
        """Seen share in the view that sees most of it, of what that view would see if nothing else were there; 0 to 1.

        Only views that would see at least half as much as the best count: a corner at an image's edge is no view of it.
        """
        if not self.alone_px.size or self.alone_px.max() == 0:
            return 0.0
        good = 2 * self.alone_px >= self.alone_px.max()
        return float(min(1.0, (self.seen_px[good] / self.alone_px[good]).max()))

    @property
    def target_class(self) -> str | None:
        """One of `TARGET_CLASSES`, or None if it is between two of them, or no view could see it at all."""
        if not self.alone_px.size or self.alone_px.max() == 0:
            return None
        if not self.seen_px.any():
            return "hidden"
        if PARTLY[0] <= self.share <= PARTLY[1]:
            return "partly"
        return "open" if self.share >= OPEN else None


def sights(world: PileWorld, numbers: list[int], poses: FloatArray, camera: CameraModel = D415) -> dict[int, Sight]:
    """Look at a pile from several places without noise.

    Args:
        world: The pile.
        numbers: Items of interest.
        poses: Camera poses in the world, shape (V, 4, 4).
        camera: Pixels and field of view.

    Returns:
        What the views see of each of the items, by number.
    """
    poses = np.asarray(poses, dtype=np.float64)
    if poses.ndim != 3 or poses.shape[1:] != (4, 4):
        raise PileError(f"poses are of shape {poses.shape}, not (V, 4, 4)", key="poses", got=poses.shape)
    images = [cast_image(world, camera, T).numbers for T in poses]
    return {
        number: Sight(
            np.array([(image == number).sum() for image in images], dtype=np.int64),
            np.array([count_alone(world, number, camera, T) for T in poses], dtype=np.int64),
        )
        for number in numbers
    }
