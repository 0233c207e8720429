"""Which pairs of solids a collision check looks at.

Not looked at: what moves together, neighbours (links on either side of one joint), what was allowed by name, and
bodies of the world among each other. A base stands on the floor, so only what moves against it can hit the floor.
"""

from collections.abc import Iterable, Sequence
from itertools import combinations

from rfcompass.errors import RobotModelError
from rfcompass.robots.robot import Robot
from rfcompass.robots.solids import Solid
from rfcompass.types.world import FLOOR, WORLD, Body

Pair = frozenset[str]

# Carrier of what stands in the world, apart from the robot's root, which is joint 0.
_STILL = -1


def allowed_pairs(pairs: Iterable[tuple[str, str]], known: Iterable[str]) -> frozenset[Pair]:
    """Check the names of pairs that may touch.

    Raises:
        RobotModelError: If a name is neither a link nor a body; lists those that are known.
    """
    names = sorted({*known, FLOOR})
    allowed = [frozenset(pair) for pair in pairs]
    if unknown := sorted({name for pair in allowed for name in pair} - set(names)):
        message = f"{unknown[0]!r} is no link or body that could touch; known: {', '.join(names)}"
        raise RobotModelError(message, name=unknown[0], known=names)
    return frozenset(allowed)


def touch_pairs(bodies: Sequence[Body]) -> frozenset[Pair]:
    """Pairs that the bodies themselves allow."""
    return frozenset(frozenset({body.name, other}) for body in bodies for other in body.may_touch)


def joint_of(robot: Robot, carrier: str) -> int:
    """Number of the joint that moves a link, 0 for what is rigid to the base, -1 for the world."""
    if carrier == WORLD:
        return _STILL
    return robot.kinematics.placement(robot.kinematics.frame_id(carrier))[0]


def checked_pairs(robot: Robot, solids: Sequence[Solid], allowed: frozenset[Pair]) -> list[tuple[int, int]]:
    """Indices of the pairs of solids to look at."""
    joints = [joint_of(robot, solid.carrier) for solid in solids]
    parents = list(robot.kinematics.model.parents)

    def neighbours(i: int, j: int) -> bool:
        a, b = sorted((joints[i], joints[j]))
        return a == b or (a >= 0 and parents[b] == a)

    return [
        (i, j)
        for i, j in combinations(range(len(solids)), 2)
        if not neighbours(i, j) and frozenset({solids[i].owner, solids[j].owner}) not in allowed
    ]


def above_floor(robot: Robot, solids: Sequence[Solid], allowed: frozenset[Pair]) -> list[int]:
    """Indices of the solids that the floor can stop."""
    return [
        i
        for i, solid in enumerate(solids)
        if joint_of(robot, solid.carrier) > 0 and frozenset({solid.owner, FLOOR}) not in allowed
    ]
