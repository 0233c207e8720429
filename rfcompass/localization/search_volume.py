"""Where to look for a tag if nobody says so."""

import numpy as np

from rfcompass.arrays import FloatArray
from rfcompass.errors import UnsuitablePath
from rfcompass.types.reads import Scan
from rfcompass.types.volumes import SearchVolume

# All ours: what a reader antenna on a rail or an arm sees at arm's length.
MARGIN_M = 0.3
NEAREST_M = 0.2
FARTHEST_M = 1.5
BESIDE_LINE_M = 0.5
STRAIGHT_RATIO = 0.1  # a path is a line if it is less than this wide for its length


def default_volume(scan: Scan) -> SearchVolume:
    """Choose a search volume from the antenna path alone.

    A line of positions cannot tell a tag from its mirror image, a plane of positions neither; the choice of the side is
    part of the choice of the volume:

    - two dimensions, straight path: the path's extent ± 0.3 m along it and 0.2 to 1.5 m beside it, on the side of +y
      if the path runs along x, of +x if it runs along y;
    - two dimensions, any other path: the path's extent ± 1.5 m in x and y;
    - three dimensions, straight path: as in two, and ± 0.5 m in height;
    - three dimensions, any other path: the path's extent ± 0.3 m in x and y, and 1.5 m down from its lowest
      position, since an antenna on a wrist looks down [Boroushaki2023].

    In two dimensions the height of the antenna is the tag's. For anything else, give a `SearchVolume`.

    Args:
        scan: Scan whose antenna positions, of all tags together, are the path.

    Raises:
        UnsuitablePath: If the scan holds no antenna position.
    """
    path_m = np.concatenate([np.empty((0, 3)), *(trace.antenna_positions_m for trace in scan.traces.values())])
    if not len(path_m):
        raise UnsuitablePath("no tag was heard, so that there is no antenna path to search beside", tags=0)
    lower_m, upper_m = path_m.min(axis=0), path_m.max(axis=0)
    straight = _is_straight(path_m)
    if straight:
        _widen_beside(lower_m, upper_m, along=int(np.argmax((upper_m - lower_m)[:2])))
    else:
        around_m = FARTHEST_M if scan.dimensions == 2 else MARGIN_M
        lower_m[:2], upper_m[:2] = lower_m[:2] - around_m, upper_m[:2] + around_m
    lower_m[2], upper_m[2] = _heights(path_m[:, 2], straight, scan.dimensions)
    return SearchVolume(lower_m, upper_m)


def _widen_beside(lower_m: FloatArray, upper_m: FloatArray, along: int) -> None:
    """Turn the extent of a path along x (0) or y (1) into a field beside it, in place."""
    across = 1 - along
    lower_m[along], upper_m[along] = lower_m[along] - MARGIN_M, upper_m[along] + MARGIN_M
    lower_m[across], upper_m[across] = upper_m[across] + NEAREST_M, upper_m[across] + FARTHEST_M


def _heights(path_z_m: FloatArray, straight: bool, dimensions: int) -> tuple[float, float]:
    if dimensions == 2:
        return float(path_z_m.mean()), float(path_z_m.mean())
    if straight:
        return float(path_z_m.min()) - BESIDE_LINE_M, float(path_z_m.max()) + BESIDE_LINE_M
    return float(path_z_m.min()) - FARTHEST_M, float(path_z_m.min())


def _is_straight(path_m: FloatArray) -> bool:
    spread = np.linalg.svd(path_m - path_m.mean(axis=0), compute_uv=False)
    return bool(spread[1] <= STRAIGHT_RATIO * spread[0])
