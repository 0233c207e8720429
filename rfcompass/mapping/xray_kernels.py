"""Compiled silhouettes of a box in a pinhole camera, and whether what the camera sees hides them.

A camera is (K, R, e): its intrinsics, its axes in the world, and where it is from the box's middle [m]. A turn is
cosine and sine of the box's yaw.
"""

from typing import TypeAlias

import numba
import numpy as np

from rfcompass.arrays import FloatArray

Camera: TypeAlias = tuple[FloatArray, FloatArray, FloatArray]
Turn: TypeAlias = tuple[float, float]
Rectangle: TypeAlias = tuple[int, int, int, int]

_LEAST = 1e-12  # of a direction


@numba.njit(cache=True)
def inverse_ways(shape: tuple[int, int], camera: Camera, turn: Turn) -> FloatArray:
    """One over each part of every pixel's ray, in the axes of a turned box, with 1 along the optical axis.

    Args:
        shape: Of the image, (H, W).
        camera: Its place does not count.
        turn: Of the box.

    Returns:
        Shape (H, W, 3).
    """
    inverse = np.empty((shape[0], shape[1], 3))
    for v in range(shape[0]):
        for u in range(shape[1]):
            ray = _ray(u, v, camera)
            parts = (turn[0] * ray[0] + turn[1] * ray[1], turn[0] * ray[1] - turn[1] * ray[0], ray[2])
            for axis in range(3):
                inverse[v, u, axis] = 1.0 / (parts[axis] if abs(parts[axis]) > _LEAST else _LEAST)
    return inverse


@numba.njit(cache=True)
def add_silhouettes(
    total: FloatArray,
    depth_m: FloatArray,
    inverse: FloatArray,
    camera: Camera,
    half_m: FloatArray,
    turn: Turn,
    stride: int,
) -> None:
    """Add the silhouettes of a box wherever it would be hidden, over a grid of pixels in which its middle appears.

    Args:
        total: Changed in place, shape (H, W).
        depth_m: What lies behind is hidden, shape (H, W).
        inverse: From `inverse_ways`, shape (H, W, 3).
        camera: Its place is given from the middle of the box where the box stands right below the world's origin.
        half_m: Half the edges of the box, shape (3,).
        turn: Its yaw.
        stride: Of the grid [pixel].
    """
    for v in range(0, depth_m.shape[0], stride):
        for u in range(0, depth_m.shape[1], stride):
            ray = _ray(u, v, camera)
            if ray[2] >= 0.0:
                continue
            eye = camera[2][2] / ray[2] * np.array(ray)
            start = np.array([turn[0] * eye[0] + turn[1] * eye[1], turn[0] * eye[1] - turn[1] * eye[0], eye[2]])
            if depth_m[v, u] > _enters(inverse[v, u], start, half_m):  # seen at its middle: the common case
                continue
            rectangle = _rectangle((camera[0], camera[1], eye), half_m, turn)
            if _inside(rectangle, depth_m) and _hidden(depth_m, inverse, start, half_m, rectangle):
                _add(total, inverse, start, half_m, rectangle)


@numba.njit(cache=True)
def _ray(u: float, v: float, camera: Camera) -> tuple[float, float, float]:
    """Direction of a pixel in the world, 1 along the optical axis."""
    K, R, _ = camera
    y = (v - K[1, 2]) / K[1, 1]
    x = (u - K[0, 2] - K[0, 1] * y) / K[0, 0]
    return (
        R[0, 0] * x + R[0, 1] * y + R[0, 2],
        R[1, 0] * x + R[1, 1] * y + R[1, 2],
        R[2, 0] * x + R[2, 1] * y + R[2, 2],
    )


@numba.njit(cache=True)
def _enters(inverse: FloatArray, start: FloatArray, half_m: FloatArray) -> float:
    """Depth at which a ray enters the box; -1 where it misses it; all in the axes of the box."""
    enter, leave = -np.inf, np.inf
    for axis in range(3):
        one = (-half_m[axis] - start[axis]) * inverse[axis]
        other = (half_m[axis] - start[axis]) * inverse[axis]
        enter, leave = max(enter, min(one, other)), min(leave, max(one, other))
    return enter if 0.0 < enter <= leave else -1.0


@numba.njit(cache=True)
def _rectangle(camera: Camera, half_m: FloatArray, turn: Turn) -> Rectangle:
    """First and last column, first and last row of the box in the image; negative if it reaches behind the camera."""
    K, R, eye = camera
    low_u, high_u, low_v, high_v = np.inf, -np.inf, np.inf, -np.inf
    for corner in range(8):
        x = half_m[0] * (1 - 2 * (corner & 1))
        y = half_m[1] * (1 - (corner & 2))
        off = np.array([turn[0] * x - turn[1] * y, turn[1] * x + turn[0] * y, half_m[2] * (1 - (corner & 4) / 2)]) - eye
        depth = R[0, 2] * off[0] + R[1, 2] * off[1] + R[2, 2] * off[2]
        if depth <= 1e-6:
            return -1, -1, -1, -1
        right = (R[0, 0] * off[0] + R[1, 0] * off[1] + R[2, 0] * off[2]) / depth
        down = (R[0, 1] * off[0] + R[1, 1] * off[1] + R[2, 1] * off[2]) / depth
        u, v = K[0, 0] * right + K[0, 1] * down + K[0, 2], K[1, 1] * down + K[1, 2]
        low_u, high_u, low_v, high_v = min(low_u, u), max(high_u, u), min(low_v, v), max(high_v, v)
    return int(np.ceil(low_u)), int(np.floor(high_u)), int(np.ceil(low_v)), int(np.floor(high_v))


@numba.njit(cache=True)
def _inside(rectangle: Rectangle, image: FloatArray) -> bool:
    first_u, last_u, first_v, last_v = rectangle
    return first_u >= 0 and last_u < image.shape[1] and first_v >= 0 and last_v < image.shape[0]


@numba.njit(cache=True)
def _hidden(
    depth_m: FloatArray, inverse: FloatArray, start: FloatArray, half_m: FloatArray, rectangle: Rectangle
) -> bool:
    """Whether no pixel of the box lies before what the camera sees."""
    for v in range(rectangle[2], rectangle[3] + 1):
        for u in range(rectangle[0], rectangle[1] + 1):
            at_m = _enters(inverse[v, u], start, half_m)
            if at_m > 0.0 and depth_m[v, u] > at_m:
                return False
    return True


@numba.njit(cache=True)
def _add(total: FloatArray, inverse: FloatArray, start: FloatArray, half_m: FloatArray, rectangle: Rectangle) -> None:
    """Add the silhouette of the box."""
    for v in range(rectangle[2], rectangle[3] + 1):
        for u in range(rectangle[0], rectangle[1] + 1):
            if _enters(inverse[v, u], start, half_m) > 0.0:
                total[v, u] += 1.0
