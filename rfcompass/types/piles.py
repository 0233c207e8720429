"""Records of the pile search: views, masks, voxel maps and actions."""

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from rfcompass.arrays import FloatArray, IntArray, read_only
from rfcompass.errors import ShapeError
from rfcompass.types.record import Record, frozen_mapping


@dataclass(frozen=True, slots=True)
class DepthView(Record):
    """One depth image and where it was taken.

    Attributes:
        depth_m: Distance along the optical axis [m], NaN where the camera saw nothing, shape (H, W).
        intrinsics: Pinhole matrix of this image [pixel], shape (3, 3). Its principal point lies in the image: that
            tells a matrix made for another image size. What is cut out beside it needs NaN around it.
        T_world_camera: Camera pose, x right, y down, z forward, homogeneous, shape (4, 4).
        colour: Red, green, blue, 0..255, shape (H, W, 3); None for a camera without colour.
    """

    depth_m: FloatArray
    intrinsics: FloatArray
    T_world_camera: FloatArray
    colour: IntArray | None = None

    def __post_init__(self) -> None:
        """Freeze the arrays; check that there are pixels, and that the matrix, the pose and the depths can be."""
        set_ = object.__setattr__
        set_(self, "depth_m", read_only(self.depth_m, "DepthView.depth_m", (None, None), finite=False))
        set_(self, "intrinsics", read_only(self.intrinsics, "DepthView.intrinsics", (3, 3)))
        set_(self, "T_world_camera", read_only(self.T_world_camera, "DepthView.T_world_camera", (4, 4)))
        if self.colour is not None:
            set_(self, "colour", read_only(self.colour, "DepthView.colour", (*self.depth_m.shape, 3), np.int64))
        if self.intrinsics[0, 0] <= 0 or self.intrinsics[1, 1] <= 0:
            raise ShapeError("DepthView.intrinsics: focal lengths must be positive", name="intrinsics")
        if self.intrinsics[2].tolist() != [0, 0, 1]:
            raise ShapeError("DepthView.intrinsics: the last row must be 0, 0, 1", name="intrinsics")
        _check_size(self.depth_m.shape, self.intrinsics)
        _check_rigid(self.T_world_camera)
        if np.isinf(self.depth_m).any() or (self.depth_m <= 0).any():
            raise ShapeError("DepthView.depth_m: must be positive, or NaN where nothing was seen", name="depth_m")


def _check_size(shape: tuple[int, ...], intrinsics: FloatArray) -> None:
    rows, columns = shape
    if not (rows and columns):
        raise ShapeError(f"DepthView.depth_m: an image of {shape} has no pixel", name="depth_m", got=shape)
    u, v = float(intrinsics[0, 2]), float(intrinsics[1, 2])
    # Half a pixel more to the right, so that it holds as well for every other pixel of an image.
    if not (-0.5 <= u <= columns and -0.5 <= v <= rows):
        message = (
            f"DepthView.intrinsics: the principal point ({u:g}, {v:g}) lies outside the image of "
            f"{columns} x {rows} pixels: a matrix for another image size?"
        )
        raise ShapeError(message, name="intrinsics", got=(u, v), expected=(columns, rows))


def _check_rigid(T_world_camera: FloatArray) -> None:
    R = T_world_camera[:3, :3]
    turns = np.abs(R @ R.T - np.eye(3)).max() < 1e-6 and np.linalg.det(R) > 0
    if not (turns and T_world_camera[3].tolist() == [0, 0, 0, 1]):
        raise ShapeError("DepthView.T_world_camera: is no rigid transform", name="T_world_camera")


@dataclass(frozen=True, slots=True)
class InstanceMasks(Record):
    """Which object each pixel belongs to.

    Attributes:
        labels: 0 for background, otherwise the number of the object, shape (H, W).
    """

    labels: IntArray

    def __post_init__(self) -> None:
        """Freeze the array; labels are not negative."""
        object.__setattr__(self, "labels", read_only(self.labels, "InstanceMasks.labels", (None, None), np.int64))
        if (self.labels < 0).any():
            raise ShapeError("InstanceMasks.labels: must not be negative", name="labels")

    @property
    def count(self) -> int:
        """Number of objects."""
        return int(np.unique(self.labels[self.labels > 0]).size)


@dataclass(frozen=True, slots=True)
class VoxelGrid(Record):
    """A value for each voxel of a box.

    Attributes:
        origin_m: Centre of the first voxel in the world frame [m], shape (3,).
        spacing_m: Edge of a voxel [m].
        values: One value for each voxel, shape (X, Y, Z).
    """

    origin_m: FloatArray
    spacing_m: float
    values: FloatArray

    def __post_init__(self) -> None:
        """Freeze the arrays; check the spacing, and that there are voxels."""
        object.__setattr__(self, "origin_m", read_only(self.origin_m, "VoxelGrid.origin_m", (3,)))
        object.__setattr__(self, "values", read_only(self.values, "VoxelGrid.values", (None, None, None)))
        if not self.spacing_m > 0:
            raise ShapeError(f"VoxelGrid.spacing_m: {self.spacing_m} is not positive", name="spacing_m")
        if not self.values.size:
            raise ShapeError(f"VoxelGrid.values: {self.values.shape} holds no voxel", name="values")


@dataclass(frozen=True, slots=True)
class ExtractionAction(Record):
    """One removal from the pile.

    Attributes:
        mask_label: Which object of the masks to take.
        T_world_hand: Hand pose at the grasp, homogeneous, shape (4, 4).
        aperture_m: Opening of the jaws [m].
        score: Score of the rule that chose it.
        scores: Score of each object that could be chosen, by its label; empty where the rule compares no objects.
    """

    mask_label: int
    T_world_hand: FloatArray
    aperture_m: float
    score: float
    scores: Mapping[int, float] = field(default_factory=dict)

    def __post_init__(self) -> None:
        """Freeze the pose and the scores."""
        object.__setattr__(self, "scores", frozen_mapping(self.scores))
        object.__setattr__(self, "T_world_hand", read_only(self.T_world_hand, "ExtractionAction.T_world_hand", (4, 4)))
