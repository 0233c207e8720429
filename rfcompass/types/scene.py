"""A room as everybody may know it: walls, obstacles and what they are made of.

Planners, collision checks and the radio channel read the same obstacles. What nobody can know, such as the small
things that scatter waves, is truth and belongs to the simulation.

Scene frame: the room is the box from the origin to `Room.size_m`, z up, the floor at z = 0.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import TypeAlias

import numpy as np

from rfcompass.arrays import FloatArray, read_only
from rfcompass.errors import SceneError
from rfcompass.types.record import Record, frozen_mapping
from rfcompass.types.shapes import Box, Cylinder

ObstacleShape: TypeAlias = Box | Cylinder


@dataclass(frozen=True, slots=True)
class Material(Record):
    """What walls and obstacles do to a wave.

    A wave that meets a wall is reflected with Fresnel's coefficients of a half-space; a wave that passes an obstacle
    over a length t loses `surface_loss_db` + `loss_db_per_m` t and arrives as if its way were (√ε - 1) t longer.

    Attributes:
        name: Unique in a scene.
        permittivity: Real relative permittivity ε, at least 1.
        loss_db_per_m: Loss along the way through it [dB/m].
        surface_loss_db: Loss of each passage, however short [dB]: skins, wet surfaces, frames.
        conductor: Reflects everything, as a perfect conductor does; permittivity and phase delay then have no meaning.
    """

    name: str
    permittivity: float = 1.0
    loss_db_per_m: float = 0.0
    surface_loss_db: float = 0.0
    conductor: bool = False

    def __post_init__(self) -> None:
        """Check the numbers."""
        if not self.name:
            raise SceneError("a material has no name", key="name")
        for key, least in (("permittivity", 1.0), ("loss_db_per_m", 0.0), ("surface_loss_db", 0.0)):
            if not (np.isfinite(value := getattr(self, key)) and value >= least):
                message = f"material {self.name}: {key} is {value!r}, not a finite number >= {least:g}"
                raise SceneError(message, material=self.name, key=key, got=value)

    @property
    def delay_ratio(self) -> float:
        """Extra way for each metre inside, √ε - 1; 0 for a conductor, which lets nothing through to be delayed."""
        return 0.0 if self.conductor else float(np.sqrt(self.permittivity)) - 1.0


@dataclass(frozen=True, slots=True)
class Obstacle(Record):
    """A solid thing in the room.

    Attributes:
        name: Unique in a scene.
        shape: Box or cylinder, about its own centre.
        T_scene_obstacle: Homogeneous pose of the centre, shape (4, 4).
        material: Name of its material.
        blocks_base: Whether a mobile base must go round it; False for what it drives under or over.
    """

    name: str
    shape: ObstacleShape
    T_scene_obstacle: FloatArray
    material: str
    blocks_base: bool = True

    def __post_init__(self) -> None:
        """Freeze the pose and check that it is rigid."""
        if not isinstance(self.shape, Box | Cylinder):
            kind = type(self.shape).__name__
            raise SceneError(
                f"obstacle {self.name}: a {kind} is neither Box nor Cylinder", obstacle=self.name, got=kind
            )
        T = read_only(self.T_scene_obstacle, f"Obstacle[{self.name}].T_scene_obstacle", (4, 4))
        R = T[:3, :3]
        if np.abs(R @ R.T - np.eye(3)).max() > 1e-6 or np.linalg.det(R) < 0 or T[3].tolist() != [0, 0, 0, 1]:
            raise SceneError(f"obstacle {self.name}: its pose is not rigid", obstacle=self.name, got=T.tolist())
        object.__setattr__(self, "T_scene_obstacle", T)

    @property
    def bounds_m(self) -> FloatArray:
        """Lowest and highest corner of a box around it, along the axes of the scene [m], shape (2, 3)."""
        R, centre_m = self.T_scene_obstacle[:3, :3], self.T_scene_obstacle[:3, 3]
        reach_m = np.abs(R) @ self.shape.upper_m
        return np.stack([centre_m - reach_m, centre_m + reach_m])


@dataclass(frozen=True, slots=True)
class Room(Record):
    """Four walls, a floor and a ceiling: the box from the origin to `size_m`.

    Attributes:
        size_m: Edges along x, y and z [m], shape (3,).
        wall_material: Name of the material of all four walls.
        floor_material: Name of the material of the plane z = 0.
        ceiling_material: Name of the material of the plane z = size_m[2].
    """

    size_m: FloatArray
    wall_material: str
    floor_material: str
    ceiling_material: str

    def __post_init__(self) -> None:
        """Freeze and check the edges."""
        size_m = read_only(self.size_m, "Room.size_m", (3,))
        if not (size_m > 0).all():
            raise SceneError(f"room: size_m is {size_m.tolist()}, not three lengths above 0", key="size_m", got=size_m)
        object.__setattr__(self, "size_m", size_m)

    @property
    def surfaces(self) -> tuple[tuple[str, str], ...]:
        """Material at the lower and the upper plane of each axis x, y, z."""
        walls = (self.wall_material, self.wall_material)
        return walls, walls, (self.floor_material, self.ceiling_material)


@dataclass(frozen=True, slots=True)
class Scene(Record):
    """A room, what stands in it, and the materials of both.

    Attributes:
        name: Name for reports.
        room: Walls, floor and ceiling; None for free space.
        obstacles: Everything solid.
        materials: By name.
    """

    name: str
    room: Room | None = None
    obstacles: tuple[Obstacle, ...] = ()
    materials: Mapping[str, Material] = field(default_factory=dict)

    def __post_init__(self) -> None:
        """Freeze; check that names are unique and materials known."""
        object.__setattr__(self, "obstacles", tuple(self.obstacles))
        object.__setattr__(self, "materials", frozen_mapping(self.materials))
        names = [obstacle.name for obstacle in self.obstacles]
        if twice := sorted({name for name in names if names.count(name) > 1}):
            raise SceneError(f"scene {self.name}: obstacles {twice} stand twice", key="obstacles", got=twice)
        for key, material in self.materials.items():
            if key != material.name:
                raise SceneError(f"scene {self.name}: material {material.name} is filed under {key}", key=key)
        for user, material_name in self._uses():
            if material_name not in self.materials:
                known = sorted(self.materials)
                message = f"scene {self.name}: {user} is of unknown material {material_name!r}; known: {known}"
                raise SceneError(message, key=user, got=material_name, known=known)

    def with_obstacles(self, extra: Sequence[Obstacle]) -> "Scene":
        """Return the scene with more obstacles; their materials must be known."""
        return replace(self, obstacles=(*self.obstacles, *extra))

    def _uses(self) -> list[tuple[str, str]]:
        used = [(f"obstacle {obstacle.name}", obstacle.material) for obstacle in self.obstacles]
        if self.room is not None:
            used += [("the room", name) for pair in self.room.surfaces for name in pair]
        return used
