"""Casts a camera's rays into a pile: depth, item and normal of every pixel, without graphics."""

from dataclasses import dataclass

import numpy as np

from rfcompass.arrays import FloatArray, IntArray
from rfcompass.errors import PileError
from rfcompass.simulation.piles.engine import load_mujoco
from rfcompass.simulation.piles.world import PileWorld
from rfcompass.types.record import Record

# Rays meet groups of geoms; a single item can be moved to a group of its own.
_ALL, _ALONE = 0, 1
FAR_M = 3.0  # beyond that nothing is looked for


@dataclass(frozen=True, slots=True)
class CameraModel(Record):
    """A pinhole camera.

    Attributes:
        width: Columns [pixel].
        height: Rows [pixel].
        across_rad: Field of view along a row [rad].
        down_rad: Field of view along a column [rad].
    """

    width: int = 320
    height: int = 180
    across_rad: float = float(np.radians(65.0))
    down_rad: float = float(np.radians(40.0))

    def __post_init__(self) -> None:
        """Check that there are pixels, and that the view is narrower than a half-space."""
        for key in ("width", "height"):
            if (got := getattr(self, key)) < 1:
                raise PileError(f"camera: {key} is {got!r}, not at least 1 pixel", key=key, got=got)
        for key in ("across_rad", "down_rad"):
            if not 0 < (got := getattr(self, key)) < np.pi:
                raise PileError(f"camera: {key} is {got!r}, not between 0 and pi", key=key, got=got)

    @property
    def intrinsics(self) -> FloatArray:
        """Pinhole matrix; the middle of the image is its principal point [pixel], shape (3, 3)."""
        fx = self.width / 2 / np.tan(self.across_rad / 2)
        fy = self.height / 2 / np.tan(self.down_rad / 2)
        return np.array([[fx, 0, (self.width - 1) / 2], [0, fy, (self.height - 1) / 2], [0, 0, 1.0]])

    def directions(self) -> FloatArray:
        """Direction of each pixel in the camera frame, 1 along the optical axis, shape (H, W, 3)."""
        K = self.intrinsics
        u, v = np.meshgrid(np.arange(self.width), np.arange(self.height))
        return np.stack([(u - K[0, 2]) / K[0, 0], (v - K[1, 2]) / K[1, 1], np.ones_like(u)], axis=-1)

    def pixels(self, points_m: FloatArray) -> FloatArray:
        """Column and row where points in front of the camera appear; camera frame [m], (P, 3) to (P, 2)."""
        K = self.intrinsics
        return points_m[:, :2] / points_m[:, 2:] * [K[0, 0], K[1, 1]] + [K[0, 2], K[1, 2]]


# The depth camera of the paper's wrist, D415: field of view and least range as its maker states them, at a quarter of
# its columns [D400].
D415 = CameraModel()


@dataclass(frozen=True, slots=True)
class TrueImage(Record):
    """What the rays met: truth, which no estimator may see.

    Attributes:
        depth_m: Distance along the optical axis, NaN where a ray met nothing [m], shape (H, W).
        numbers: Number of the item, 0 for the table, -1 for nothing, shape (H, W).
        facing: Cosine between ray and surface normal, 1 where the surface faces the camera, shape (H, W).
    """

    depth_m: FloatArray
    numbers: IntArray
    facing: FloatArray


def cast_image(world: PileWorld, camera: CameraModel, T_world_camera: FloatArray) -> TrueImage:
    """Cast the ray of every pixel.

    Args:
        world: What there is.
        camera: Its pixels.
        T_world_camera: True pose, x right, y down, z forward, homogeneous, shape (4, 4).
    """
    rays = camera.directions().reshape(-1, 3) @ T_world_camera[:3, :3].T
    length = np.linalg.norm(rays, axis=1)
    distance_m, geoms, normals = cast(world, T_world_camera[:3, 3], rays / length[:, None], _ALL)
    hit, shape = geoms >= 0, (camera.height, camera.width)
    numbers = np.where(hit, world.geom_numbers[geoms], -1)
    facing = np.abs(np.einsum("ij,ij->i", normals, rays / length[:, None]))
    depth_m = np.where(hit, distance_m / length, np.nan)
    return TrueImage(depth_m.reshape(shape), numbers.reshape(shape), np.where(hit, facing, 0.0).reshape(shape))


def count_alone(world: PileWorld, number: int, camera: CameraModel, T_world_camera: FloatArray) -> int:
    """Pixels that an item would cover if nothing stood before it; arguments as for `cast_image`."""
    R, eye_m = T_world_camera[:3, :3], T_world_camera[:3, 3]
    corners_m = (world.corners_m(number) - eye_m) @ R
    if (corners_m[:, 2] <= 0).any():
        return 0
    pixels = camera.pixels(corners_m)
    low = np.clip(np.floor(pixels.min(axis=0)).astype(int), 0, [camera.width, camera.height])
    high = np.clip(np.ceil(pixels.max(axis=0)).astype(int) + 1, 0, [camera.width, camera.height])
    rays = camera.directions()[low[1] : high[1], low[0] : high[0]].reshape(-1, 3) @ R.T
    if not len(rays):
        return 0
    mine = world.geom_numbers == number
    world.model.geom_group[mine] = _ALONE
    try:
        _, geoms, _ = cast(world, eye_m, rays / np.linalg.norm(rays, axis=1)[:, None], _ALONE)
    finally:
        world.model.geom_group[mine] = _ALL
    return int((geoms >= 0).sum())


def cast(
    world: PileWorld, eye_m: FloatArray, directions: FloatArray, group: int
) -> tuple[FloatArray, IntArray, FloatArray]:
    """Cast rays from a point at the geoms of a group.

    Args:
        world: What there is.
        eye_m: Where they start [m], shape (3,).
        directions: Unit vectors, in the world, shape (R, 3).
        group: Group of geoms.

    Returns:
        Distance [m], shape (R,), geom or -1, shape (R,), and outward normal, shape (R, 3), of what each met first.
    """
    count = len(directions)
    geoms, distance_m, normals = np.empty(count, dtype=np.int32), np.empty(count), np.zeros(3 * count)
    groups = np.array([index == group for index in range(6)], dtype=np.uint8)
    flat = np.ascontiguousarray(directions, dtype=np.float64).reshape(-1)
    load_mujoco().mj_multiRay(
        world.model, world.data, np.array(eye_m), flat, groups, 1, -1, geoms, distance_m, normals, count, FAR_M
    )
    return distance_m, geoms.astype(np.int64), normals.reshape(-1, 3)
