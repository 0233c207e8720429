"""What a robot may bump into: a floor and bodies, some of which may ride on one of its links.

World frame: that of `Configuration.base`, z up. Plans made from an estimate take the present base frame as the world.
"""

from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np

from rfcompass.arrays import FloatArray
from rfcompass.errors import SceneError
from rfcompass.types.record import Record
from rfcompass.types.scene import Room, Scene
from rfcompass.types.shapes import Box, Cylinder, Mesh, Shape, Sphere, rigid_transform

FLOOR = "floor"
WORLD = "world"

# A wall is as thick as this, outwards [m]; ours: thicker than any step between two checks.
_WALL_M = 0.2


@dataclass(frozen=True, slots=True)
class Body(Record):
    """A solid thing: an obstacle, the part, or what the hand holds.

    Attributes:
        name: Unique in a world.
        shape: Box, cylinder, sphere or mesh in the body's own frame.
        T_parent_body: Homogeneous pose of that frame, shape (4, 4).
        parent: Link that carries the body; `"world"` if it stands still.
        may_touch: Links and bodies that it may touch; `"floor"` is one of the names.
    """

    name: str
    shape: Shape
    T_parent_body: FloatArray
    parent: str = WORLD
    may_touch: frozenset[str] = frozenset()

    def __post_init__(self) -> None:
        """Freeze; check the name, the shape and the pose."""
        if not self.name or self.name in (FLOOR, WORLD):
            raise SceneError(f"a body cannot be called {self.name!r}", body=self.name)
        if not isinstance(self.shape, Box | Cylinder | Sphere | Mesh):
            kind = type(self.shape).__name__
            raise SceneError(f"body {self.name}: a {kind} is no box, cylinder, sphere or mesh", body=self.name)
        T = rigid_transform(self.T_parent_body, f"Body[{self.name}].T_parent_body")
        object.__setattr__(self, "T_parent_body", T)
        object.__setattr__(self, "may_touch", frozenset(self.may_touch))

    @property
    def stands_still(self) -> bool:
        """False if a link carries it."""
        return self.parent == WORLD


@dataclass(frozen=True, slots=True)
class World(Record):
    """All that is not the robot.

    Attributes:
        bodies: Obstacles, the part, what the hand holds.
        floor_m: Height of the floor [m]; None where there is none.
    """

    bodies: tuple[Body, ...] = ()
    floor_m: float | None = 0.0

    def __post_init__(self) -> None:
        """Freeze; names must be unique, the floor's height finite."""
        object.__setattr__(self, "bodies", tuple(self.bodies))
        names = [body.name for body in self.bodies]
        if twice := sorted({name for name in names if names.count(name) > 1}):
            raise SceneError(f"bodies {twice} stand twice in a world", bodies=twice)
        if self.floor_m is not None and not np.isfinite(self.floor_m):
            raise SceneError(f"the floor's height is {self.floor_m}", floor_m=self.floor_m)

    def with_bodies(self, *bodies: Body) -> "World":
        """Return the world with more bodies."""
        return replace(self, bodies=(*self.bodies, *bodies))

    def without(self, name: str) -> "World":
        """Return the world without one body.

        Raises:
            SceneError: If there is none of that name; lists those that there are.
        """
        names = [body.name for body in self.bodies]
        if name not in names:
            raise SceneError(f"the world has no body {name!r}; it has: {', '.join(names) or 'none'}", known=names)
        return replace(self, bodies=tuple(body for body in self.bodies if body.name != name))

    def attach(self, name: str, link: str, T_link_body: FloatArray, may_touch: Iterable[str]) -> "World":
        """Return the world with a body on a link: the part after the jaws have closed.

        Args:
            name: Body to attach.
            link: Link that carries it from now on.
            T_link_body: Its pose on that link, shape (4, 4).
            may_touch: What it may touch there, for example the fingers.

        Raises:
            SceneError: If there is no such body.
        """
        rest = self.without(name)
        body = next(body for body in self.bodies if body.name == name)
        held = replace(body, T_parent_body=T_link_body, parent=link, may_touch=frozenset({link, *may_touch}))
        return rest.with_bodies(held)


def world_of_scene(scene: Scene, T_world_scene: FloatArray | None = None) -> World:
    """Turn obstacles and walls of a scene into bodies; the floor is the scene's plane z = 0.

    Args:
        scene: Room and obstacles.
        T_world_scene: Pose of the scene in the world, upright, homogeneous, shape (4, 4); the identity if None.

    Raises:
        SceneError: If the scene does not stand upright.
    """
    T = rigid_transform(np.eye(4) if T_world_scene is None else T_world_scene, "T_world_scene")
    if not np.allclose(T[2, :3], [0, 0, 1], atol=1e-9):
        raise SceneError("the scene is tilted against the world", T_world_scene=T.tolist())
    bodies = [Body(thing.name, thing.shape, T @ thing.T_scene_obstacle) for thing in scene.obstacles]
    walls = [] if scene.room is None else _walls(scene.room, T)
    return World((*bodies, *walls), float(T[2, 3]))


def _walls(room: Room, T_world_scene: FloatArray) -> list[Body]:
    """Four boxes around the room."""
    walls = []
    for axis, letter in enumerate("xy"):
        for at_end, side in enumerate(("low", "high")):
            size_m, T = room.size_m + 2 * _WALL_M, np.eye(4)
            size_m[axis] = _WALL_M
            T[:3, 3] = room.size_m / 2
            T[axis, 3] = room.size_m[axis] + _WALL_M / 2 if at_end else -_WALL_M / 2
            walls.append(Body(f"wall_{letter}_{side}", Box(size_m), T_world_scene @ T))
    return walls


@dataclass(frozen=True, slots=True)
class Clearance(Record):
    """How near two things are.

    Attributes:
        first: Link or body.
        second: Link, body or `"floor"`.
        distance_m: Smallest distance between them [m]; negative if they overlap: minus the depth.
    """

    first: str
    second: str
    distance_m: float

    @property
    def touching(self) -> bool:
        """True if they overlap."""
        return self.distance_m <= 0.0
