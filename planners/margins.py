"""Bodies that stand around, grown by a margin: the hand does not end up exactly where it is sent."""

from dataclasses import dataclass, replace

import numpy as np

from rfcompass.robots import CollisionModel, QuickCollisions, Robot
from rfcompass.types.configuration import Configuration
from rfcompass.types.shapes import Box, Cylinder, Mesh, Shape, Sphere
from rfcompass.types.world import World

# Ours: a part that is this near to a body lies on it or leans against it [m].
_LIES_ON_M = 1e-3
# A corner grows by this many times the margin.
_AT_CORNERS = np.sqrt(3.0)


@dataclass(frozen=True, slots=True)
class Surroundings:
    """What stands around robot and part.

    Attributes:
        world: Floor and bodies, grown by the margin where they may be; the part as it is.
        supports: Bodies that the part lies on or leans against.
    """

    world: World
    supports: frozenset[str]


def with_margin(robot: Robot, world: World, start: Configuration, margin_m: float, part_name: str) -> Surroundings:
    """Grow the bodies of a world, but for the part and what robot or part are nearer to already.

    Args:
        robot: Who must stay away from them.
        world: Floor and bodies; the floor is not grown.
        start: Where the robot is.
        margin_m: By how much, to all sides [m].
        part_name: The part, which the hand must come near to.
    """
    others = {body.name for body in world.bodies if body.stands_still} - {part_name}
    if not others:
        return Surroundings(world, frozenset())
    to_robot, to_part = _distances_m(robot, world, start, part_name)
    bodies = [
        replace(body, shape=grown(body.shape, margin_m))
        if body.name in others and min(to_robot[body.name], to_part[body.name]) > _AT_CORNERS * margin_m
        else body
        for body in world.bodies
    ]
    supports = frozenset(name for name in others if to_part[name] <= _LIES_ON_M)
    return Surroundings(World(tuple(bodies), world.floor_m), supports)


def _distances_m(
    robot: Robot, world: World, start: Configuration, part_name: str
) -> tuple[dict[str, float], dict[str, float]]:
    """Distance of each body from the robot, and from the part [m]."""
    T_base_part = next(body.T_parent_body for body in world.bodies if body.name == part_name)
    T_tool_part = robot.tool_pose(start).inverse().homogeneous @ T_base_part
    T_tool_part[3] = 0, 0, 0, 1
    # Where it stands, but as a thing that moves: what stands still is not checked against what stands still.
    quick = QuickCollisions(CollisionModel(robot, world.attach(part_name, robot.tool.frame, T_tool_part, ())))
    names = [body.name for body in world.bodies]
    to_robot, to_part = dict.fromkeys(names, np.inf), dict.fromkeys(names, np.inf)
    for pair, distance in zip(quick.pair_names, quick.distances(start), strict=True):
        for name in set(pair) & set(names):
            found = to_part if part_name in pair else to_robot
            found[name] = min(found[name], float(distance))
    return to_robot, to_part


def grown(shape: Shape, margin_m: float) -> Shape:
    """A shape that is larger by a margin to all sides; corners grow a little more. Of a mesh the pieces grow."""
    match shape:
        case Box():
            return Box(shape.size_m + 2 * margin_m)
        case Cylinder():
            return Cylinder(shape.radius_m + margin_m, shape.length_m + 2 * margin_m, shape.axis)
        case Sphere():
            return Sphere(shape.radius_m + margin_m)
        case Mesh():
            cube = margin_m * np.array(np.meshgrid(*[(-1.0, 1.0)] * 3)).reshape(3, -1).T
            pieces = tuple((piece[:, None] + cube).reshape(-1, 3) for piece in shape.pieces_m)
            return replace(shape, pieces_m=pieces)
