"""Where a near-field image is computed if nobody says so: axes along the antenna path, and how far from it.

A path cannot tell everything about where a tag is, and what it cannot tell must not be made up:

- The height of a tag is known, or tags and antennas share one plane: the image is a horizontal plane at that height,
  on one side of a straight path, on both sides of any other. A straight path hears a tag and its mirror image alike;
  all tags are taken to be on the same side, so that distances between tags that are stay what they are.
- The height is not known and the path is straight: it hears a tag and all points on a circle about itself alike. The
  image is a half-plane that the path borders, on any side: distances in it are the least that the tags can have.
- The height is not known and the path lies in a plane: the image is the space below it (above hears the same).
- The height is not known and the path fills space: the image is the space around it.
"""

from dataclasses import dataclass

import numpy as np

from rfcompass.arrays import FloatArray
from rfcompass.rf.path_legs import AREA_RATIO, spans_two_directions
from rfcompass.types.volumes import SearchVolume

REACH_M = 4.0  # ours: what a reader hears across a room
SPACE_REACH_M = 1.5  # ours: where all three axes are searched; a plane costs far less
UP = np.array([0.0, 0.0, 1.0])


@dataclass(frozen=True)
class ImageFrame:
    """Axes of an image, and what part of them it covers.

    Attributes:
        axes: Unit vectors of the image's axes in the scan's frame, one per row, shape (3, 3).
        origin_m: Origin of the image in the scan's frame [m], shape (3,).
        volume: What the image covers, in its own axes.
    """

    axes: FloatArray
    origin_m: FloatArray
    volume: SearchVolume

    def into(self, points_m: FloatArray) -> FloatArray:
        """Points of the scan's frame in the image's axes [m], shape (P, 3)."""
        return np.asarray((points_m - self.origin_m) @ self.axes.T)

    def back(self, point_m: FloatArray) -> FloatArray:
        """A point of the image in the scan's frame [m], shape (3,)."""
        return np.asarray(self.origin_m + point_m @ self.axes)


def given_frame(volume: SearchVolume, height_m: float | None) -> ImageFrame:
    """Image over a volume in the scan's frame, or over its cut at a known height [m]."""
    if height_m is not None:
        lower_m, upper_m = [*volume.lower_m[:2], height_m], [*volume.upper_m[:2], height_m]
        volume = SearchVolume(np.array(lower_m), np.array(upper_m))
    return ImageFrame(np.eye(3), np.zeros(3), volume)


def frame_of_path(path_m: FloatArray, height_m: float | None, reach_m: float | None = None) -> ImageFrame:
    """Choose axes and extent from the antenna path.

    Args:
        path_m: All antenna positions in the scan's frame [m], shape (M, 3).
        height_m: Height of the tag in the scan's frame [m]; None if it is not known.
        reach_m: How far from the path a tag may be [m]; None for 4 m in a plane and 1.5 m in space.
    """
    centre_m = path_m.mean(axis=0)
    if height_m is not None:
        return _level(path_m, centre_m, height_m, REACH_M if reach_m is None else reach_m)
    if not spans_two_directions(path_m):
        along = _direction(path_m - centre_m)
        return _framed(path_m, centre_m, _axes_along(along), REACH_M if reach_m is None else reach_m, "half-plane")
    reach_m = SPACE_REACH_M if reach_m is None else reach_m
    spread = np.linalg.svd(path_m - centre_m, full_matrices=False)
    if spread.S[2] >= AREA_RATIO * spread.S[1]:
        return _framed(path_m, centre_m, np.eye(3), reach_m, "space")
    return _framed(path_m, centre_m, _axes_about(spread.Vh[2]), reach_m, "below")


def _level(path_m: FloatArray, centre_m: FloatArray, height_m: float, reach_m: float) -> ImageFrame:
    """Horizontal plane at a height."""
    flat_m = (path_m - centre_m) * [1.0, 1.0, 0.0]
    if spans_two_directions(flat_m):
        frame = _framed(path_m, centre_m, np.eye(3), reach_m, "plane")
    else:
        frame = _framed(path_m, centre_m, _axes_along(_direction(flat_m)), reach_m, "half-plane")
    return ImageFrame(frame.axes, np.array([*centre_m[:2], height_m]), frame.volume)


def _framed(path_m: FloatArray, centre_m: FloatArray, axes: FloatArray, reach_m: float, extent: str) -> ImageFrame:
    own_m = (path_m - centre_m) @ axes.T
    lower_m, upper_m = own_m.min(axis=0) - reach_m, own_m.max(axis=0) + reach_m
    if extent in ("plane", "half-plane"):
        lower_m[2] = upper_m[2] = 0.0
    if extent == "half-plane":
        lower_m[1] = 0.0
    if extent == "below":
        upper_m[2] = 0.0
    return ImageFrame(axes, centre_m, SearchVolume(lower_m, upper_m))


def _direction(centred_m: FloatArray) -> FloatArray:
    return np.asarray(np.linalg.svd(centred_m, full_matrices=False)[2][0])


def _axes_along(along: FloatArray) -> FloatArray:
    """Axes with the first along a line, the second level and at right angles to it."""
    aside = np.cross(UP, along)
    aside = np.array([1.0, 0.0, 0.0]) - along[0] * along if np.linalg.norm(aside) < 1e-6 else aside
    aside = aside / np.linalg.norm(aside)
    return np.stack([along, aside, np.cross(along, aside)])


def _axes_about(normal: FloatArray) -> FloatArray:
    """Axes with the third along a normal, turned upwards, and the first level."""
    normal = normal if normal @ UP >= 0 else -normal
    level = np.cross(UP, normal)
    level = np.array([1.0, 0.0, 0.0]) if np.linalg.norm(level) < 1e-6 else level / np.linalg.norm(level)
    level = level - (level @ normal) * normal
    level = level / np.linalg.norm(level)
    return np.stack([level, np.cross(normal, level), normal])
