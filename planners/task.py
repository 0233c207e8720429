"""The task layer of RF-Compass: from "fetch all legs of the table" to a sequence of actions for each part.

    task → parts → part database → navigate · localise · grasp · deliver, part by part

[Wang2013], section 3.2 and Fig. 2: the task planner names a part, the part's tags are looked up, and what comes back
from each localisation is the tuple (φ, D, θ). Any other planner can stand here: it needs the records below, no more.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from planners.fetch_rules import HAND_POINT_M
from rfcompass.errors import InputError
from rfcompass.geometry.pose2 import Pose2
from rfcompass.recordings import PartDatabase
from rfcompass.types.estimate import PartEstimate
from rfcompass.types.parts import Part
from rfcompass.types.record import Record

NAVIGATE, LOCALISE, GRASP, DELIVER = "navigate", "localise", "grasp", "deliver"
VERBS = (NAVIGATE, LOCALISE, GRASP, DELIVER)

# Ours: room for the open hand between two parts that were put down beside each other.
GAP_M = 0.15


@dataclass(frozen=True, slots=True)
class RelativeLocation(Record):
    """What a localisation tells a planner: where the part is, seen from the robot [Wang2013], section 3.2.

    Attributes:
        phi_rad: Direction φ in which the part's centre lies, from the base's x axis [rad].
        D_m: Its distance D from the base's centre [m].
        theta_rad: Orientation θ of the part in the base frame [rad]; None if it is not known. Only worth anything near
            the part (footnote 1 there).
    """

    phi_rad: float
    D_m: float
    theta_rad: float | None

    @staticmethod
    def of(estimate: PartEstimate) -> "RelativeLocation":
        """Return the tuple of an estimate."""
        return RelativeLocation(estimate.bearing_rad, estimate.distance_m, estimate.theta_rad)


@dataclass(frozen=True, slots=True)
class Action(Record):
    """One thing to do.

    Attributes:
        verb: One of `VERBS`.
        part_id: With which part.
        epcs: Tags to ask for, as the part database has them.
        goal: Where the part's centre and long side are to end, in the odometry frame; None unless it is delivered.
    """

    verb: str
    part_id: str
    epcs: tuple[str, ...]
    goal: Pose2 | None = None

    def __str__(self) -> str:
        """Say the action in one line."""
        if self.goal is None:
            return f"{self.verb:<9} {self.part_id}"
        where = f"x {self.goal.x_m:.2f} m, y {self.goal.y_m:.2f} m, θ {self.goal.theta_rad:.2f} rad, odometry frame"
        return f"{self.verb:<9} {self.part_id} to {where}"


@dataclass(frozen=True, slots=True)
class PartTask(Record):
    """All that is to be done with one part.

    Attributes:
        part: Which part.
        actions: What to do with it, in order.
        goal: Where it is to end, in the odometry frame.
    """

    part: Part
    actions: tuple[Action, ...]
    goal: Pose2


def parts_of_task(database: PartDatabase, part_ids: Sequence[str], assembly: str | None = None) -> tuple[Part, ...]:
    """Look up the parts that a task names: some by name, or all of a product.

    Args:
        database: The part database.
        part_ids: Names of parts, in the order in which to fetch them.
        assembly: Name of a product, in place of names of parts.

    Raises:
        InputError: If both are given or none, or a part is named twice.
        UnknownPart: If the database lacks one of them.
    """
    if bool(part_ids) == (assembly is not None):
        message = "name the parts to fetch, or one product to fetch all parts of; not both, and not neither"
        raise InputError(message, parts=list(part_ids), assembly=assembly)
    if assembly is not None:
        return database.assembly(assembly)
    if twice := sorted({part_id for part_id in part_ids if part_ids.count(part_id) > 1}):
        raise InputError(f"a part can be fetched once only: {', '.join(twice)}", parts=twice)
    return tuple(database.part(part_id) for part_id in part_ids)


def plan_task(parts: Sequence[Part], tags: int, first: Pose2, spacing: str = "ends") -> tuple[PartTask, ...]:
    """Plan what to do with each part: it is found, grasped and put into a row.

    The row begins at `first`; each next part lies beside the one before, towards negative y of that pose, which is
    where the robot stands when it puts a part down: it never drives over what it has delivered.

    Args:
        parts: What to fetch, in order.
        tags: Number of tags on each part, K.
        first: Where the first part is to end, in the odometry frame: its centre, and the direction of its x axis up to
            half a turn.
        spacing: Which placement of K tags.

    Raises:
        PartError: If a part has no layout of K tags.
    """
    places = zip(parts, _row_m(parts), strict=True)
    return tuple(
        _part_task(part, part.layout(tags, spacing).epcs, first @ Pose2(0.0, y_m, 0.0)) for part, y_m in places
    )


def row_at_the_start(parts: Sequence[Part]) -> Pose2:
    """Where a row begins whose middle is under the hand of a robot that stands at its start, across the base.

    Args:
        parts: What is to lie in the row.
    """
    x_m, y_m = HAND_POINT_M
    return Pose2(x_m - _row_m(parts)[-1] / 2.0, y_m, -np.pi / 2)


def _row_m(parts: Sequence[Part]) -> list[float]:
    """Place of each part along y [m], the first at 0, the others towards negative y."""
    places_m = [0.0]
    for one, after in pairwise(parts):
        widths_m = float(one.size_m[1] + after.size_m[1])
        places_m.append(places_m[-1] - widths_m / 2.0 - GAP_M)
    return places_m


def _part_task(part: Part, epcs: tuple[str, ...], goal: Pose2) -> PartTask:
    actions = [Action(verb, part.part_id, epcs) for verb in VERBS[:-1]]
    return PartTask(part, (*actions, Action(DELIVER, part.part_id, epcs, goal)), goal)
