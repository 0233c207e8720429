"""From the masks of an image to columns of the map: which object lies on top of which column."""

from dataclasses import dataclass

import numba
import numpy as np

from rfcompass.arrays import FloatArray, IntArray, read_only
from rfcompass.errors import InputError, ShapeError
from rfcompass.mapping.camera import points_image
from rfcompass.types import DepthView, InstanceMasks, VoxelGrid
from rfcompass.types.record import Record

_APART_M = 1.0  # ours: what a view shows so far above or under a map is not what the map is of


@dataclass(frozen=True, slots=True)
class MaskColumns(Record):
    """What lies on top of each column of a grid.

    Attributes:
        owner: Label of the object with the highest surface in a column, 0 where no object is seen, shape (X, Y).
        surface_m: Height of that surface in the world [m], NaN where there is none, shape (X, Y).
    """

    owner: IntArray
    surface_m: FloatArray

    def __post_init__(self) -> None:
        """Freeze the arrays; both are over the same columns."""
        owner = read_only(self.owner, "MaskColumns.owner", (None, None), np.int64)
        object.__setattr__(self, "owner", owner)
        surface_m = read_only(self.surface_m, "MaskColumns.surface_m", owner.shape, finite=False)
        object.__setattr__(self, "surface_m", surface_m)


def project_masks(
    grid: VoxelGrid, view: DepthView, masks: InstanceMasks, points_m: FloatArray | None = None
) -> MaskColumns:
    """Find the object on top of each column.

    A pixel covers the column that its point lies in, and those whose middle lies in the square that the pixel is wide
    at its depth: a map finer than the image has no holes. A column counts once, for the object with the highest surface
    in it; of two as high, for the one whose pixel comes first.

    Args:
        grid: The map.
        view: The image.
        masks: Its objects.
        points_m: Point of the world that each pixel shows [m], shape (H, W, 3); computed if None.

    Raises:
        ShapeError: If masks and view differ in size.
    """
    check_same_image(view, masks.labels, "masks")
    points_m = points_image(view) if points_m is None else points_m
    pixels = (masks.labels > 0) & np.isfinite(view.depth_m)
    places = (points_m[pixels] - grid.origin_m) / grid.spacing_m
    reach = view.depth_m[pixels] / (2 * view.intrinsics[0, 0] * grid.spacing_m)
    owner = np.zeros(grid.values.shape[:2], dtype=np.int64)
    highest = np.full(owner.shape, -np.inf)
    _cover(owner, highest, places, reach, masks.labels[pixels])
    surface_m = grid.origin_m[2] + grid.spacing_m * highest
    return MaskColumns(owner, np.where(owner > 0, surface_m, np.nan))


def check_same_image(view: DepthView, image: IntArray | FloatArray, name: str) -> None:
    """Check that an image has the size of a view.

    Raises:
        ShapeError: If not.
    """
    if image.shape != view.depth_m.shape:
        message = f"{name}: have shape {image.shape}, the view {view.depth_m.shape}"
        raise ShapeError(message, name=name, expected=view.depth_m.shape, got=image.shape)


def check_same_place(grid: VoxelGrid, points_m: FloatArray) -> None:
    """Check that a view shows some of what a map is of.

    Args:
        grid: The map.
        points_m: Point of the world that each pixel shows [m], NaN where none, shape (H, W, 3).

    Raises:
        InputError: If none lies over the map, within 1 m above or under it.
    """
    low_m = grid.origin_m - grid.spacing_m / 2
    high_m = low_m + grid.spacing_m * np.array(grid.values.shape)
    reach_m = np.array([0.0, 0.0, _APART_M])
    with np.errstate(invalid="ignore"):
        inside = (points_m >= low_m - reach_m) & (points_m <= high_m + reach_m)
    if inside.all(axis=-1).any():
        return
    seen_m = points_m[np.isfinite(points_m[..., 2])]
    if not len(seen_m):
        raise InputError("the view shows nothing of the map: no pixel has a depth", shown=[])
    shown = [seen_m.min(axis=0).round(2).tolist(), seen_m.max(axis=0).round(2).tolist()]
    mapped = [low_m.round(2).tolist(), high_m.round(2).tolist()]
    message = f"the view shows {shown[0]} to {shown[1]} m, the map is of {mapped[0]} to {mapped[1]} m: another frame?"
    raise InputError(message, shown=shown, mapped=mapped)


def check_same_columns(grid: VoxelGrid, columns: MaskColumns) -> None:
    """Check that columns are those of a map.

    Raises:
        ShapeError: If not.
    """
    if columns.owner.shape != grid.values.shape[:2]:
        message = f"columns: have shape {columns.owner.shape}, the map {grid.values.shape[:2]}"
        raise ShapeError(message, name="columns", expected=grid.values.shape[:2], got=columns.owner.shape)


@numba.njit(cache=True)
def _cover(owner: IntArray, highest: FloatArray, places: FloatArray, reach: FloatArray, labels: IntArray) -> None:
    """Let each pixel cover columns; places in voxels, reach half a pixel in voxels."""
    for n in range(len(labels)):
        x, y, z = places[n]
        i, j = int(np.floor(x + 0.5)), int(np.floor(y + 0.5))
        for a in range(min(i, int(np.ceil(x - reach[n]))), max(i, int(np.floor(x + reach[n]))) + 1):
            for b in range(min(j, int(np.ceil(y - reach[n]))), max(j, int(np.floor(y + reach[n]))) + 1):
                inside = 0 <= a < owner.shape[0] and 0 <= b < owner.shape[1]
                if inside and z > highest[a, b]:
                    highest[a, b] = z
                    owner[a, b] = labels[n]
