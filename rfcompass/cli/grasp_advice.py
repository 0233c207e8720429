"""`rfcompass grasp --measure-again`: would another stop help, said after a plan was found."""

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import numpy as np

    from rfcompass.robots import Robot
    from rfcompass.types import GraspPlan, Part, PartEstimate, World
    from rfcompass.types.configuration import Configuration
    from rfcompass.types.grasps import MeasureAdvice
    from rfcompass.types.tags import TagLayout

# Ours: stops that are offered. More take longer to find, and the best of 70 raises the chance hardly more.
_STOPS = 24


def with_advice(
    plan: "GraspPlan",
    question: tuple["Part", "PartEstimate", "World"],
    robot: "Robot",
    start: "Configuration | None",
    tags: int | None,
    rng: "np.random.Generator",
) -> "GraspPlan":
    """The plan, with the advice to measure again if that is worth it.

    Args:
        plan: What would be done now.
        question: Part, estimate and world of the plan.
        robot: Whose plan.
        start: Where its arm is; the posture "scan" if None.
        tags: Tags that are heard on the part; the most that it can have if None.
        rng: Draws poses and measurements.

    Raises:
        PartError: If the part has no tags, or no layout of that many.
        RobotModelError: If the robot has no posture "scan", from which stops are found.
    """
    from dataclasses import replace

    from planners.hand_stops import FreeStops, HandStops
    from planners.measure_again import MeasureAgain
    from rfcompass.localization import NoiseModel, noise_of
    from rfcompass.robots import CollisionModel, QuickCollisions, always_touching
    from rfcompass.robots.hand import hand_of

    part, estimate, world = question
    now = robot.configuration((start or robot.posture("scan")).joints)
    model = CollisionModel(robot, world, allowed=always_touching(robot))
    proposer = FreeStops(proposer=HandStops(robot=robot, count=_STOPS), collisions=QuickCollisions(model))
    adviser = MeasureAgain(robot, hand_of(robot), proposer, noise_of(estimate) or NoiseModel())
    return replace(plan, advice=adviser.advise(plan, part, estimate, now, heard_tags(part, tags), rng))


def heard_tags(part: "Part", tags: int | None) -> "TagLayout":
    """The part's layout of that many tags; of the most that it can have if None.

    Raises:
        PartError: If it has no tags, or no such layout.
    """
    from rfcompass.errors import PartError

    if tags is not None:
        return part.layout(tags)
    if not len(part.tags.epcs):
        raise PartError(f"part {part.part_id} has no tags, so no stop can hear it", part=part.part_id)
    most = max(part.selections, key=lambda selection: selection.K, default=None)
    return part.tags if most is None else part.tagged(most.epcs, most.counterparts)


def advice_json(advice: "MeasureAdvice | None") -> dict[str, Any]:
    """Return an advice; arrays stay arrays."""
    if advice is None:
        return {"worth_it": False}
    base = advice.stop.configuration.base
    return {
        "worth_it": True,
        "success_now": advice.success_now,
        "success_after": advice.success_after,
        "spread": advice.spread,
        "outcomes": advice.outcomes,
        "stop": {"joints": advice.stop.configuration.joints, "base": [base.x_m, base.y_m, base.theta_rad]},
        "seconds": advice.stop.seconds,
    }


def advice_line(plan: "GraspPlan") -> str:
    """Say it in one line."""
    if plan.advice is not None:
        return f"{plan.advice.message}, {plan.advice.stop.seconds:.1f} s away"
    if plan.success_probability is None:
        return "whether to measure again is not known: the estimate does not say how sure it is"
    return "grasp now: no other stop would raise the chance by 0.05"
