"""Judges a grasp against where the part truly is, and pushes the part when a try fails (`GraspOracle`).

Each try: the arm puts the hand a little off, friction is drawn, and `judge_grasp` says what happens. What the robot is
told is only what it could feel: held, met something on the way down, or closed on nothing. A failed try moves
the part as a hand would: away from the jaw that came down on it, or out of the jaws that could not hold it, by a random
and bounded slide with a random turn. The true pose and the verdicts stay here, for evaluation.
"""

from dataclasses import dataclass, field, replace

import numpy as np

from rfcompass.arrays import FloatArray, read_only
from rfcompass.errors import InputError
from rfcompass.geometry.pose2 import Pose2
from rfcompass.robots.grasp_judge import hit_on_the_way, judge_grasp
from rfcompass.types.grasp_noise import GraspNoise
from rfcompass.types.grasps import Failure, GraspOutcome
from rfcompass.types.hands import Hand
from rfcompass.types.parts import Part

_BLOCKED = Failure("hand_hits_part", "the hand met something on its way down")
_NOT_HELD = Failure("nothing_held", "the jaws have closed and hold nothing")
# Verdicts after which the part still lies where it was.
_UNTOUCHED = ("nothing_between_jaws", "too_heavy")


@dataclass(frozen=True, slots=True, kw_only=True)
class Push:
    """How far a failed try moves the part. Ours; the paper says only that the part is bumped.

    Attributes:
        slide_m: Longest slide [m]; its length is uniform from 0.
        turn_rad: Largest turn to either side [rad]; uniform.
    """

    slide_m: float = 0.03
    turn_rad: float = 0.2

    def __post_init__(self) -> None:
        """Refuse pushes that cannot be."""
        for name in ("slide_m", "turn_rad"):
            if not (np.isfinite(value := getattr(self, name)) and value >= 0):
                raise InputError(f"Push.{name}: {value} is not a finite number >= 0", name=name)


@dataclass(frozen=True, slots=True)
class GraspTry:
    """One try as it truly was. This record is truth.

    Attributes:
        verdict: `"holds"`, or the kind of failure that the judge found.
        friction: Coefficient that was drawn.
        before: Pose of the part before.
        after: Pose of the part after.
    """

    verdict: str
    friction: float
    before: Pose2
    after: Pose2


@dataclass(slots=True)
class PartOracle:
    """Where a part truly lies on the floor, and what becomes of it (`GraspOracle`).

    Args:
        hand: The robot's hand.
        part: What is grasped.
        T_world_part: True pose of the part; it lies on the floor z = 0.
        rng: Source of all draws.
        noise: How tries differ.
        push: How far a failed try moves the part.
    """

    hand: Hand
    part: Part
    T_world_part: Pose2
    rng: np.random.Generator
    noise: GraspNoise = field(default_factory=GraspNoise)
    push: Push = field(default_factory=Push)
    _tries: list[GraspTry] = field(init=False, default_factory=list)

    @property
    def tries(self) -> tuple[GraspTry, ...]:
        """All tries so far: for evaluation only."""
        return tuple(self._tries)

    @property
    def held(self) -> bool:
        """True if the part is in the hand: for evaluation only."""
        return bool(self._tries) and self._tries[-1].verdict == "holds"

    def judge(self, T_world_hand: FloatArray, aperture_m: float) -> GraspOutcome:
        """Try a grasp.

        Args:
            T_world_hand: Where the tool frame is sent, homogeneous, shape (4, 4).
            aperture_m: Distance of the jaws as the hand comes down [m].

        Raises:
            InputError: If the hand does not open so far.
        """
        sent = read_only(T_world_hand, "T_world_hand", (4, 4))
        draws = self.noise.draw(1, self.rng)
        T_part_hand = self._T_part_world @ draws.executed(sent)[0]
        hand = replace(self.hand, friction=float(draws.friction[0]))
        answer = judge_grasp(hand, self.part.shape, T_part_hand, opening_m=aperture_m, mass_kg=self.part.mass_kg)
        verdict = answer.kind if isinstance(answer, Failure) else "holds"
        after = self.T_world_part
        if isinstance(answer, Failure) and verdict not in _UNTOUCHED:
            after = self._pushed(hand, T_part_hand, aperture_m)
        self._tries.append(GraspTry(verdict, hand.friction, self.T_world_part, after))
        self.T_world_part = after
        if verdict == "holds":
            return GraspOutcome(True)
        return GraspOutcome(False, _BLOCKED if verdict in ("hand_hits_part", "too_wide") else _NOT_HELD)

    @property
    def _T_part_world(self) -> FloatArray:
        pose, T = self.T_world_part.inverse(), np.eye(4)
        T[:2, :2], T[:2, 3], T[2, 3] = pose.rotation, pose.translation_m, -self.part.resting_height_m
        return T

    def _pushed(self, hand: Hand, T_part_hand: FloatArray, aperture_m: float) -> Pose2:
        """Where the part lies after the hand has pushed it."""
        axes = self.T_world_part.rotation @ (T_part_hand[:3, :3] @ hand.R_tool_hand)[:2]
        hit = hit_on_the_way(hand, self.part.shape, T_part_hand, opening_m=aperture_m)
        # Away from a jaw that came down on it; out of the jaws, to either side, if they could not hold it.
        sign = {"left jaw": -1.0, "right jaw": 1.0}.get(hit or "", float(self.rng.choice((-1, 1))))
        direction = axes[:, 1] if hit is None else axes[:, 0]
        length = float(np.linalg.norm(direction))
        slide_m = sign * self.rng.uniform(0.0, self.push.slide_m) * direction / max(length, 1e-9)
        turn_rad = self.rng.uniform(-self.push.turn_rad, self.push.turn_rad)
        pose = self.T_world_part
        return Pose2(pose.x_m + slide_m[0], pose.y_m + slide_m[1], pose.theta_rad + turn_rad)
