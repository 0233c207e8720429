"""Where an arm can do which grasps: a volume of voxels, and for each voxel the tool directions that can be had."""

from dataclasses import dataclass
from pathlib import Path
from zipfile import BadZipFile

import numpy as np

from rfcompass.arrays import BoolArray, FloatArray, IntArray, read_only
from rfcompass.errors import InputError, ShapeError
from rfcompass.files import write_atomic
from rfcompass.types.grasp_task import GraspTask
from rfcompass.types.grasps import ReachMap
from rfcompass.types.record import Record

SCHEMA = "rfcompass-task-map/1"
_FIELDS = ("origin_m", "spacing_m", "approach", "closing", "reached")


@dataclass(frozen=True, slots=True)
class ToolDirections(Record):
    """Directions of a tool in the base frame.

    Attributes:
        approach: Unit vectors, shape (D, 3).
        closing: Unit vectors, NaN where the jaws may close along any direction, shape (D, 3).
    """

    approach: FloatArray
    closing: FloatArray

    def __post_init__(self) -> None:
        """Freeze the arrays and check that they are as many."""
        approach = read_only(self.approach, "ToolDirections.approach", (None, 3))
        closing = read_only(self.closing, "ToolDirections.closing", (len(approach), 3), finite=False)
        object.__setattr__(self, "approach", approach)
        object.__setattr__(self, "closing", closing)

    def task(self, point_m: FloatArray, d: int) -> GraspTask:
        """The task of direction `d` at a point [m], shape (3,)."""
        closing = None if np.isnan(self.closing[d]).any() else self.closing[d]
        return GraspTask(point_m, self.approach[d], closing)


def top_down(count: int = 12) -> ToolDirections:
    """Straight down, with the jaws closing along `count` headings: multiples of π / count from 0 on."""
    headings = np.arange(count) * np.pi / count
    closing = np.column_stack([np.cos(headings), np.sin(headings), np.zeros(count)])
    return ToolDirections(np.tile([0.0, 0.0, -1.0], (count, 1)), closing)


@dataclass(frozen=True, slots=True)
class TaskMap(Record):
    """Which tasks an arm can do, in its base frame.

    Attributes:
        origin_m: Centre of the first voxel [m], shape (3,).
        spacing_m: Edge of a voxel [m].
        directions: Directions of the tool (D).
        reached: True where the task at the voxel's centre can be done, shape (X, Y, Z, D).
    """

    origin_m: FloatArray
    spacing_m: float
    directions: ToolDirections
    reached: BoolArray

    def __post_init__(self) -> None:
        """Freeze the arrays and check the spacing."""
        D, set_ = len(self.directions.approach), object.__setattr__
        set_(self, "origin_m", read_only(self.origin_m, "TaskMap.origin_m", (3,)))
        set_(self, "reached", read_only(self.reached, "TaskMap.reached", (None, None, None, D), np.bool_))
        if not (np.isfinite(self.spacing_m) and self.spacing_m > 0):
            raise ShapeError(f"TaskMap.spacing_m: {self.spacing_m} is not above 0", name="spacing_m")

    @property
    def reach_map(self) -> ReachMap:
        """Share of the directions that can be reached in each voxel."""
        return ReachMap(self.origin_m, self.spacing_m, self.reached.mean(axis=3))

    def centres_m(self, indices: IntArray) -> FloatArray:
        """Centres of voxels [m], shape (P, 3), for indices (P, 3)."""
        return np.asarray(self.origin_m + self.spacing_m * indices)

    def can(self, points_m: FloatArray, direction: IntArray) -> BoolArray:
        """Look tasks up: True if every voxel around the point can do it, False outside the map.

        The eight voxels around a point are asked: a task counts only where its surroundings can be done too.

        Args:
            points_m: Tool positions in the base frame [m], shape (P, 3).
            direction: Index of the direction of each, shape (P,).
        """
        place = (np.asarray(points_m) - self.origin_m) / self.spacing_m
        low, high = np.floor(place + 1e-9).astype(np.int64), np.ceil(place - 1e-9).astype(np.int64)
        size = np.array(self.reached.shape[:3])
        inside = (low >= 0).all(axis=1) & (high < size).all(axis=1)
        low, high = np.clip(low, 0, size - 1), np.clip(high, 0, size - 1)
        for corner in np.ndindex(2, 2, 2):
            x, y, z = np.where(corner, high, low).T
            inside &= self.reached[x, y, z, direction]
        return np.asarray(inside)

    def save(self, path: str | Path) -> None:
        """Write the map as one npz file, all of it or nothing.

        Raises:
            InputError: If the file cannot be written.
        """

        def write(draft: Path) -> None:
            with draft.open("wb") as file:
                np.savez_compressed(
                    file, schema=SCHEMA, origin_m=self.origin_m, spacing_m=self.spacing_m, reached=self.reached,
                    approach=self.directions.approach, closing=self.directions.closing,
                )  # fmt: skip

        try:
            write_atomic(Path(path), write)
        except OSError as cause:
            raise InputError(f"{path}: cannot be written: {cause.strerror}", file=str(path)) from cause


def load_task_map(path: str | Path) -> TaskMap:
    """Read a map that `TaskMap.save` wrote.

    Raises:
        InputError: If the file cannot be read, or is no such map; names the file.
    """
    try:
        with np.load(path, allow_pickle=False) as content:
            schema = str(content["schema"])
            values = {name: content[name] for name in _FIELDS}
    except OSError as cause:
        raise InputError(f"{path}: cannot be read: {cause.strerror or cause}", file=str(path)) from cause
    except (ValueError, KeyError, BadZipFile, EOFError) as cause:
        raise InputError(f"{path}: is no map of tasks: {cause}", file=str(path)) from cause
    if schema != SCHEMA:
        raise InputError(f"{path}: is of schema {schema!r}, not {SCHEMA!r}", file=str(path), schema=schema)
    try:
        directions = ToolDirections(values["approach"], values["closing"])
        return TaskMap(values["origin_m"], float(values["spacing_m"]), directions, values["reached"])
    except (TypeError, InputError) as cause:
        raise InputError(f"{path}: is no map of tasks: {cause}", file=str(path)) from cause
