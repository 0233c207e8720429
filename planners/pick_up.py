"""The last phase of RF-Compass: plan a grasp from the estimate, carry it out, and measure again after a failed try.

[Wang2013], section 3.2: a try that fails bumps the part, so the robot measures anew before the next one. The budget of
tries and drives is bounded; what ends without the part in the hand ends with a typed reason.
"""

from collections.abc import Generator
from dataclasses import dataclass, field
from typing import TypeAlias

from planners.fetch import Fetch, FetchStep
from planners.grasp import GraspPlanner
from planners.time_account import TimeSpent
from rfcompass.arrays import FloatArray
from rfcompass.errors import GraspFailed
from rfcompass.types.grasps import GraspFailure, GraspOutcome, GraspPlan
from rfcompass.types.motions import APPROACH, CLOSE, DRIVE
from rfcompass.types.parts import Part
from rfcompass.types.record import Record


@dataclass(frozen=True, slots=True, kw_only=True)
class PickUpRules(Record):
    """How much may be tried. All values are ours.

    Attributes:
        max_tries: Closings of the hand.
        max_drives: Drives to where a grasp is in reach.
        enough: A plan that is less likely to hold is not tried before the antenna has looked from other sides.
        max_looks: How often the antenna may do so.
    """

    max_tries: int = 3
    max_drives: int = 3
    enough: float = 0.2
    max_looks: int = 3


@dataclass(frozen=True, slots=True)
class GraspTrial(Record):
    """One closing of the hand.

    Attributes:
        plan: What was carried out.
        outcome: What the hand felt.
        spent: Time of its motions; after a failed try also of the way back.
    """

    plan: GraspPlan
    outcome: GraspOutcome
    spent: TimeSpent = field(default_factory=TimeSpent)


# Reasons that no drive and no look from elsewhere can change.
_HOPELESS = ("too_heavy", "too_wide")

PickUpEvent: TypeAlias = FetchStep | GraspTrial


@dataclass(slots=True)
class PickUp:
    """Picks up what a fetch has found; iterate over `events()`.

    Args:
        fetch: The loop, after its last stop.
        planner: Plans grasps for its robot.
        part: What lies there.
        rules: How much may be tried.
    """

    fetch: Fetch
    planner: GraspPlanner
    part: Part
    rules: PickUpRules = field(default_factory=PickUpRules)

    def events(self, found: FetchStep) -> Generator[PickUpEvent, None, None]:
        """Plan, grasp, and measure again where that fails; ends when the part is in the hand.

        Args:
            found: The last stop of the fetch.

        Raises:
            GraspFailed: If there is no grasp, or the last try failed as well; `reason` is the kind of the last failure.
                Where another place of the base may help, the robot drives there first: so that the part can be grasped
                if the planner says where, else so that it lies under the hand.
            NoAnswer: If the part cannot be located again.
        """
        step, tries, drives, looks = found, 0, 0, 0
        while True:
            around = self.fetch.surroundings(step)
            answer = self.planner.plan(self.part, step.estimate, around, start=step.configuration)
            if looks < self.rules.max_looks and self._is_unsure(answer) and self.fetch.looks_from_another_side(step):
                looks += 1
                step = yield from self.fetch.measure_anew(part_moved=False)
                continue
            if isinstance(answer, GraspFailure):
                if answer.kind in _HOPELESS or drives == self.rules.max_drives:
                    raise GraspFailed(f"no grasp: {answer.message}", reason=answer.kind, tries=tries)
                drives += 1
                if answer.base is None:
                    self.fetch.stand_over(step)
                else:
                    self.fetch.drive_to(step, answer.base)
                step = yield from self.fetch.measure_anew(part_moved=False)
                continue
            trial = self._carried_out(answer)
            yield trial
            tries += 1
            if trial.outcome.success:
                return
            if tries == self.rules.max_tries:
                failure = trial.outcome.failure
                reason, message = ("nothing_held", "nothing is held") if failure is None else (
                    failure.kind, failure.message)  # fmt: skip
                raise GraspFailed(f"{message}, after {tries} tries", reason=reason, tries=tries)
            self.fetch.looks_from_another_side(step)  # what misled it once would mislead it again
            step = yield from self.fetch.measure_anew(part_moved=True)

    def _is_unsure(self, answer: GraspPlan | GraspFailure) -> bool:
        """True if another look may help: a plan that hardly holds, or no grasp at all."""
        if isinstance(answer, GraspFailure):
            return answer.base is None and answer.kind not in _HOPELESS
        return answer.success_probability is not None and answer.success_probability < self.rules.enough

    def _carried_out(self, plan: GraspPlan) -> GraspTrial:
        """Go through the stages; after a failed try back to where the approach began.

        Raises:
            GraspFailed: If the plan lacks a certificate.
        """
        if plan.defects:
            raise GraspFailed(f"a plan that is not sound: {'; '.join(plan.defects)}", reason="not_certified")
        outcome, spent = GraspOutcome(False), TimeSpent()
        for stage in plan.stages:
            seconds = float(stage.times_s[-1])
            spent += TimeSpent(drive_s=seconds) if stage.stage == DRIVE else TimeSpent(arm_s=seconds)
            if stage.stage == DRIVE:
                self.fetch.device.move_base(plan.base)
            elif stage.stage == CLOSE:
                outcome = self.fetch.device.close_hand()
                if not outcome.success:
                    self._follow(plan.approach[::-1])
                    return GraspTrial(plan, outcome, spent + _back(plan))
                self._follow(stage.joints)
            else:
                self._follow(stage.joints)
        return GraspTrial(plan, outcome, spent)

    def _follow(self, joints: FloatArray) -> None:
        """Move the arm along waypoints, shape (T, Q)."""
        for waypoint in joints:
            self.fetch.device.move_arm(waypoint)


def _back(plan: GraspPlan) -> TimeSpent:
    """Time of the approach, taken backwards."""
    return TimeSpent(arm_s=sum(float(stage.times_s[-1]) for stage in plan.stages if stage.stage == APPROACH))
