"""Why there is no grasp, and where to drive for one: sums up what was tried."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from planners.antipodal import OUTSIDE_CONE, TOO_WIDE
from planners.drive_stage import DriveStage
from planners.grasp_question import GraspQuestion
from planners.grasp_ranking import RankedGrasp
from planners.hand_poses import JOINT_LIMIT, SCENE_COLLISION, UNREACHABLE
from rfcompass.geometry.pose2 import Pose2
from rfcompass.types.grasps import Failure, GraspCandidate, GraspFailure, GraspPlan, count_reasons
from rfcompass.types.world import FLOOR

NO_GRASP = "no_grasp"


def drive_first(failure: GraspFailure, base: Pose2, there: GraspPlan) -> GraspFailure:
    """The failure from here, with the place from which it works."""
    p = there.success_probability
    chance = "" if p is None else f", where a grasp holds with probability {p:.2f}"
    degrees = np.rad2deg(base.theta_rad)
    message = f"{failure.message}; drive to x {base.x_m:.2f} m, y {base.y_m:.2f} m, {degrees:.0f} degrees first{chance}"
    numbers = (("drive_x_m", base.x_m), ("drive_y_m", base.y_m), ("drive_theta_rad", base.theta_rad))
    there_p = () if p is None else (("probability_there", p),)
    return replace(failure, message=message, numbers=(*failure.numbers, *numbers, *there_p), base=base)


def after(drive: DriveStage, base: Pose2, there: GraspPlan) -> GraspPlan:
    """A plan from elsewhere, with the drive before it."""
    clearance_m = min(there.clearance_m, drive.certificate.at_least_m)
    return replace(
        there, base=base, clearance_m=clearance_m, stages=(drive.timed, *there.stages),
        certificates=(drive.certificate, *there.certificates),
    )  # fmt: skip


def failed(failure: Failure, candidates: Sequence[GraspCandidate]) -> GraspFailure:
    """A failure, with what was looked at before."""
    return GraspFailure(failure.kind, failure.message, failure.numbers, tuple(candidates))


def all_failed(question: GraspQuestion, rows: Sequence[RankedGrasp]) -> GraspFailure:
    """Sum up why no grasp can be done."""
    candidates = tuple(row.judged for row in rows)
    counts = count_reasons(candidates)
    told = ", ".join(f"{count} {kind}" for kind, count in counts.items()) or "the part has no opposite faces"
    numbers: list[tuple[str, float | str]] = [(f"count_{kind}", float(count)) for kind, count in counts.items()]
    part_id = question.part.part_id
    if set(counts) == {TOO_WIDE}:
        narrowest = min(candidates, key=_width_m)
        if narrowest.rejection is not None:
            numbers += narrowest.rejection.numbers
            return GraspFailure(TOO_WIDE, f"{part_id}: {narrowest.rejection.message}", tuple(numbers), candidates)
    if _only_out_of_reach(candidates):
        x, y = question.estimate.centre_m
        message = f"the arm gets to none of {len(candidates)} grasps of {part_id} at ({x:.2f}, {y:.2f}) m: {told}"
        return GraspFailure(UNREACHABLE, message, tuple(numbers), candidates)
    message = f"none of {len(candidates)} grasps of {part_id} can be done: {told}"
    return GraspFailure(NO_GRASP, message, tuple(numbers), candidates)


def _only_out_of_reach(candidates: Sequence[GraspCandidate]) -> bool:
    """True if the arm gets to no grasp that the shape allows, and nothing but the floor keeps it from others."""
    rejections = [row.rejection for row in candidates if row.rejection is not None]
    kinds = {row.kind for row in rejections}
    in_the_way = {
        name
        for row in rejections
        if row.kind == SCENE_COLLISION
        for key, name in row.numbers
        if key in ("first", "second")
    } - {"hand", FLOOR}
    by_shape = {TOO_WIDE, OUTSIDE_CONE, SCENE_COLLISION}
    return (
        bool(kinds & {UNREACHABLE, JOINT_LIMIT}) and not in_the_way and kinds <= by_shape | {UNREACHABLE, JOINT_LIMIT}
    )


def _width_m(candidate: GraspCandidate) -> float:
    numbers = dict(candidate.rejection.numbers) if candidate.rejection is not None else {}
    return float(numbers.get("width_m", np.inf))
