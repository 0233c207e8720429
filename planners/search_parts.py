"""Whether the parts of a search fit together, before the arm moves."""

import numpy as np

from planners.search_beliefs import Belief
from planners.search_method import SearchMethod
from rfcompass.errors import InputError
from rfcompass.interfaces import ExtractionPolicy, GraspQuality, PileRobot, Segmenter

_SAME_M = 1e-6  # heights of a table that differ by less are rounded ones


def check_parts(
    robot: PileRobot, method: SearchMethod, segmenter: Segmenter, quality: GraspQuality, table_m: float
) -> None:
    """Check that each part has the methods of its role, and that segmenter and grasps mean the workspace's table.

    Args:
        robot: The arm.
        method: Its policy and its belief are looked at.
        segmenter: Tells objects apart.
        quality: Scores grasps.
        table_m: Height of the table in the world [m].

    Raises:
        InputError: If one has not, or has a `table_m` of another height.
    """
    roles: list[tuple[str, object, type]] = [
        ("robot", robot, PileRobot),
        ("segmenter", segmenter, Segmenter),
        ("quality", quality, GraspQuality),
        ("policy", method.policy, ExtractionPolicy),
    ]
    if method.belief is not None:
        roles.append(("belief", method.belief, Belief))
    for name, part, role in roles:
        if isinstance(part, type) or not isinstance(part, role):  # a class has the methods, too
            got = type(part).__name__
            raise InputError(f"PileSearch: the {name}, a {got}, is no {role.__name__}", name=name, got=got)
    for part in (segmenter, quality):
        its_m = getattr(part, "table_m", table_m)
        if not isinstance(its_m, int | float | np.number) or not abs(its_m - table_m) <= _SAME_M:
            message = f"{type(part).__name__} has its table at {its_m} m, the workspace at {table_m} m"
            raise InputError(message, got=its_m, expected=table_m)
