"""What `rfcompass fetch` says of several parts: answers, actions and events as JSON."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rfcompass.arrays import plain
from rfcompass.cli.output import failure_json

if TYPE_CHECKING:
    from planners.task import PartTask
    from rfcompass.cli.fetch import Fetched
    from rfcompass.geometry.pose2 import Pose2
    from rfcompass.recordings import Run
    from rfcompass.studies.task_fetching import JudgedPutDown


@dataclass(frozen=True, slots=True)
class Delivered:
    """What came of one part.

    Attributes:
        wanted: What was to be done with it.
        fetched: The fetch.
        put: How it was put down; None if it never was in the hand.
        run: Its run folder; None if nothing was heard.
    """

    wanted: "PartTask"
    fetched: "Fetched"
    put: "JudgedPutDown | None" = None
    run: "Run | None" = None

    @property
    def delivered(self) -> bool:
        """True if the part is where it was to go, as the robot believes."""
        return self.put is not None and self.fetched.failure is None

    def has_done(self, verb: str) -> bool:
        """True if an action came to its end."""
        steps = self.fetched.steps
        return {
            "navigate": any(judged.step.in_reach for judged in steps),
            "localise": (bool(steps) and self.fetched.located) or self.put is not None,
            "grasp": self.fetched.held,
            "deliver": self.delivered,
        }[verb]


def actions_json(done: Sequence[Delivered]) -> list[dict[str, Any]]:
    """Every planned action, and whether it came to its end."""
    return [
        plain({"action": action.verb, "part": action.part_id, "tags": action.epcs,
               "goal": None if action.goal is None else pose_json(action.goal), "done": one.has_done(action.verb)})
        for one in done for action in one.wanted.actions
    ]  # fmt: skip


def answers_json(done: Sequence[Delivered], target: Path) -> list[dict[str, Any]]:
    """One answer for each part: that of a single fetch, and where the part was put."""
    return [plain(_answer(one, target)) for one in done]


def _answer(one: Delivered, target: Path) -> dict[str, Any]:
    from rfcompass.cli.fetch import fetch_answer, simulated_error

    name, fetched = one.wanted.part.part_id, one.fetched
    answer: dict[str, Any] = {"part": name, "delivered": one.delivered}
    if fetched.steps and (fetched.located or one.put is not None):
        answer |= {**fetch_answer(fetched), "simulated_error": simulated_error(fetched.steps[-1])}
    elif fetched.failure is not None:
        answer |= failure_json(fetched.failure)
    answer |= {"run": str(target / name) if one.run is not None else None, "stops_made": len(fetched.steps)}
    return answer if one.put is None else {**answer, "put_down": _put_json(one.put)}


def _put_json(judged: "JudgedPutDown") -> dict[str, Any]:
    put = judged.put
    return {
        "goal": pose_json(put.goal), "part": pose_json(put.T_odom_part), "base": pose_json(put.T_odom_base),
        "short_m": put.short_m, "carried_over_floor_m": put.carry.floor_m, "drives": put.drives,
        "simulated": {"part": pose_json(judged.T_odom_part), "centre_error_m": judged.centre_error_m,
                      "theta_error_rad": judged.theta_error_rad, "drop_m": judged.drop_m},
    }  # fmt: skip


def events_json(done: Sequence[Delivered]) -> list[dict[str, Any]]:
    """What happened, in order; each localisation as the tuple (φ, D, θ) that a planner gets [Wang2013], section 3.2."""
    return [event for one in done for event in _events(one)]


def _events(one: Delivered) -> list[dict[str, Any]]:
    from planners.task import RelativeLocation

    name, events = one.wanted.part.part_id, list[dict[str, Any]]()
    for judged in one.fetched.steps:
        step, base = judged.step, judged.step.configuration.base
        found = RelativeLocation.of(step.estimate)
        location = {"phi_rad": found.phi_rad, "D_m": found.D_m, "theta_rad": found.theta_rad}
        events.append({"action": step.phase, "part": name, "stop": step.observation.stop_id, "base": pose_json(base),
                       "location": location, "in_reach": step.in_reach})  # fmt: skip
    for trial in one.fetched.trials:
        failure = trial.outcome.failure
        why = None if failure is None else failure.kind
        events.append({"action": "grasp", "part": name, "success": trial.outcome.success, "failure": why})
    if one.put is not None:
        put = one.put.put
        events.append({"action": "deliver", "part": name, "base": pose_json(put.T_odom_base),
                       "put_at": pose_json(put.T_odom_part), "short_m": put.short_m})  # fmt: skip
    if one.fetched.failure is not None:
        events.append({"action": "end", "part": name, **failure_json(one.fetched.failure)})
    return list(plain(events))


def pose_json(pose: "Pose2") -> list[float]:
    """x, y and θ."""
    return [pose.x_m, pose.y_m, pose.theta_rad]
