"""Grasps for each pixel of a depth image, from straight above: antipodal closings, and pinches of cloth.

After the image-to-image form of [Morrison2018]; in the place of its network stand geometry and the measured success of
executed grasps, see `docs/grasp_quality.md`.
"""

from dataclasses import dataclass, field

import numpy as np

from planners.grasp_map_kernels import Found, Tries, rate_pixels
from planners.grasp_number_kernels import CLOSING, PINCHING, REACH_M, Claw, Grid
from planners.grasp_success import CLOSING_WEIGHTS, PINCHING_WEIGHTS, success_of
from planners.height_map import height_map
from rfcompass.arrays import BoolArray, FloatArray, IntArray, read_only
from rfcompass.errors import InputError, ShapeError
from rfcompass.mapping.camera import check_from_above, points_image
from rfcompass.types import DepthView, GraspMaps
from rfcompass.types.counts import check_count
from rfcompass.types.record import Record


@dataclass(frozen=True, slots=True, kw_only=True)
class JawSizes(Record):
    """Sizes of the hand of `urdf/ur5e_2f85.urdf` that count for a grasp from above [m].

    Heights are looked at within 6 cm to each side: half the opening and a finger have to fit in. The weights of
    `AntipodalQuality` and the opening that `grasp_at_pixel` commands are those of the default hand.

    Attributes:
        opening_m: Furthest that the jaws open.
        room_m: How much further they open than what they close on, as `grasp_at_pixel` opens them.
        thickness_m: Of a finger, along the closing.
        palm_m: Height of the palm over the tips.
        palm_across_m: Half the palm's edge across the closing.
        palm_along_m: Half its edge along it.
        above_table_m: The tips stay so far above the table; ours.
    """

    opening_m: float = 0.085
    room_m: float = 0.020
    thickness_m: float = 0.012
    palm_m: float = 0.058
    palm_across_m: float = 0.020
    palm_along_m: float = 0.060
    above_table_m: float = 0.004

    def __post_init__(self) -> None:
        """Check that all are lengths."""
        for name in self.__slots__:
            if not (np.isfinite(value := getattr(self, name)) and value > 0):
                raise InputError(f"jaw sizes: {name} is {value!r}, no length", got=value)
        if (reach_m := self.opening_m / 2 + self.thickness_m) > REACH_M:
            message = f"jaw sizes: half the opening and a finger are {reach_m:.4f} m, more than {REACH_M} m"
            raise InputError(message, got=reach_m, most=REACH_M)


def grasp_quality(depth_m: FloatArray, intrinsics: FloatArray, T_world_camera: FloatArray) -> GraspMaps:
    """Rate the grasps of the default hand in a bare depth image: `AntipodalQuality` without records.

    Args:
        depth_m: Distance along the optical axis [m], NaN where nothing was seen, shape (H, W).
        intrinsics: Pinhole matrix [pixel], shape (3, 3).
        T_world_camera: Camera pose, x right, y down, z forward, shape (4, 4). The world's z is up, the table at 0.

    Returns:
        Quality, angle, width and depth of the best grasp at each pixel.

    Raises:
        ShapeError: If a shape is wrong, a depth not positive, or the intrinsics are those of another image size.
        InputError: If the camera does not look down on the table, or the depths are in millimetres.
    """
    return AntipodalQuality().quality(DepthView(depth_m, intrinsics, T_world_camera))


@dataclass(frozen=True, slots=True)
class GraspEvidence(Record):
    """What the qualities of a view come from, for those who fit and who doubt.

    Attributes:
        log_odds: Weighted sum of the numbers, minus infinity where there is no grasp, shape (H, W).
        angle_rad: As in `GraspMaps`.
        width_m: As in `GraspMaps`.
        depth_m: As in `GraspMaps`.
        kind: 0 none, 1 the jaws close on two sides, 2 they pinch, shape (H, W).
        numbers: Those of `grasp_number_kernels.CLOSING` or `PINCHING`, then zeros, shape (H, W, 10).
    """

    log_odds: FloatArray
    angle_rad: FloatArray
    width_m: FloatArray
    depth_m: FloatArray
    kind: IntArray
    numbers: FloatArray


@dataclass(frozen=True, kw_only=True)
class AntipodalQuality:
    """Scores the best grasp at each pixel; a `GraspQuality`.

    Attributes:
        jaws: The hand.
        table_m: Height of the table in the world [m].
        standing_m: What is lower than this over the table is table [m]; ours.
        friction: Between finger and thing; ours; a side that is more skew than its cone is not gripped [Nguyen1988].
        angles: Number of directions of the jaws; ours.
        depths_m: How far the tips go below the surface; ours [m].
        cell_m: Edge of a cell of the height map; ours [m].
        closing: Weights of the numbers of a closing, the constant last, shape (11,).
        pinching: Weights of the numbers of a pinch, the constant last, shape (7,).

    Raises:
        InputError: If there is no angle or depth to try, or no friction, or a number is none or not finite.
        ShapeError: If there are more or fewer weights than numbers, or one is not finite.
    """

    jaws: JawSizes = field(default_factory=JawSizes)
    table_m: float = 0.0
    standing_m: float = 0.008
    friction: float = 0.6
    angles: int = 8
    depths_m: tuple[float, ...] = (0.010, 0.020, 0.030, 0.040)
    cell_m: float = 0.0025
    closing: tuple[float, ...] = CLOSING_WEIGHTS
    pinching: tuple[float, ...] = PINCHING_WEIGHTS

    def __post_init__(self) -> None:
        """Check that each number has a weight, and that there is something to try."""
        check_count(self.angles, "AntipodalQuality.angles", 1)
        for name in ("table_m", "standing_m", "friction", "cell_m"):
            if not np.isfinite(value := getattr(self, name)):
                raise InputError(f"AntipodalQuality.{name}: {value!r} is not finite", name=name, got=value)
        if not (self.depths_m and self.friction > 0 and self.cell_m > 0):
            message = "AntipodalQuality: without a depth, friction or an edge of cells there is no grasp"
            raise InputError(message, got=[list(self.depths_m), self.friction, self.cell_m])
        if not all(np.isfinite(depth_m) and depth_m > 0 for depth_m in self.depths_m):
            raise InputError(f"AntipodalQuality.depths_m: {self.depths_m} are no lengths", got=list(self.depths_m))
        for name, numbers in (("closing", CLOSING), ("pinching", PINCHING)):
            if len(weights := getattr(self, name)) != len(numbers) + 1:
                message = f"AntipodalQuality.{name}: {len(weights)} weights, expected {len(numbers)} and the constant"
                raise ShapeError(message, name=name, expected=len(numbers) + 1, got=len(weights))
            read_only(weights, f"AntipodalQuality.{name}", (None,))

    def quality(self, view: DepthView) -> GraspMaps:
        """Say how likely the best grasp at each pixel holds, and how the jaws would stand."""
        seen = self.evidence(view)
        return GraspMaps(success_of(seen.log_odds, seen.kind), seen.angle_rad, seen.width_m, seen.depth_m)

    def evidence(
        self, view: DepthView, pixels: BoolArray | None = None, angles_rad: FloatArray | None = None
    ) -> GraspEvidence:
        """Find the best grasp at each pixel, with what speaks for it.

        Args:
            view: A depth image.
            pixels: Where to look, shape (H, W); everywhere above the table if None.
            angles_rad: Directions to try [rad], shape (A,); `angles` even ones over half a turn if None.

        Raises:
            InputError: If the camera does not look down on the table, if its depths are in millimetres, if there are
                too many cells, or no direction to try.
            ShapeError: If pixels or directions have another shape, or a direction is not finite.
        """
        check_from_above(view, self.table_m)
        shape, points_m = view.depth_m.shape, points_image(view)
        with np.errstate(invalid="ignore"):
            standing = points_m[..., 2] > self.table_m + self.standing_m
        wanted = standing if pixels is None else standing & read_only(pixels, "pixels", shape, np.bool_)
        angles = self._directions_rad(angles_rad)
        found = Found(
            np.full(shape, -np.inf),
            np.zeros(shape),
            np.zeros(shape),
            np.zeros(shape),
            np.zeros(shape, np.int64),
            np.zeros((*shape, len(CLOSING))),
        )
        heights = height_map(view, standing, self.cell_m)
        if heights is not None:
            tries = Tries(angles, np.sort(self.depths_m), np.array(self.closing), np.array(self.pinching))
            grid = Grid(
                heights.heights_m,
                heights.seen,
                float(heights.corner_m[0]),
                float(heights.corner_m[1]),
                1 / heights.cell_m,
            )
            rate_pixels(points_m, wanted, grid, self._claw(), tries, found)
        return GraspEvidence(*found)

    def _directions_rad(self, asked_rad: FloatArray | None) -> FloatArray:
        """Directions to try [rad], shape (A,)."""
        if asked_rad is None:
            return np.arange(self.angles) * np.pi / self.angles
        angles_rad = read_only(asked_rad, "angles_rad", (None,))
        if not angles_rad.size:
            raise InputError("angles_rad: without a direction there is no grasp", got=0)
        return angles_rad.copy()  # writable, as the kernel is compiled for

    def _claw(self) -> Claw:
        jaws = self.jaws
        return Claw(
            jaws.opening_m,
            jaws.room_m,
            jaws.thickness_m,
            jaws.palm_m,
            jaws.palm_across_m,
            jaws.palm_along_m,
            float(np.arctan(self.friction)),
            self.table_m + jaws.above_table_m,
        )
