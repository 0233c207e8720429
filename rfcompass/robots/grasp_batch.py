"""Would a grasp hold, for many poses at once: the verdicts of `judge_grasp`."""

import numpy as np

from rfcompass.arrays import FloatArray, IntArray, read_only
from rfcompass.robots.grasp_judge import judge_grasp
from rfcompass.types.grasps import Failure
from rfcompass.types.hands import Hand
from rfcompass.types.shapes import Shape

# What a verdict's number means.
VERDICTS = (
    "holds",
    "hand_hits_part",
    "too_wide",
    "nothing_between_jaws",
    "outside_friction_cone",
    "not_opposite",
    "too_heavy",
)


def judge_grasps(
    hand: Hand, shape: Shape, T_part_hands: FloatArray, *, opening_m: float | None = None, mass_kg: float | None = None
) -> IntArray:
    """Judge many poses of a hand.

    Args:
        hand: Which hand.
        shape: What it closes on.
        T_part_hands: Poses of the tool frame in the part frame, homogeneous, shape (S, 4, 4).
        opening_m: Distance of the jaws as it comes down [m]; the greatest if None.
        mass_kg: How heavy the part is; not looked at if None.

    Returns:
        Numbers of `VERDICTS`; 0: it holds. Shape (S,).

    Raises:
        InputError: If the hand does not open so far.
    """
    poses = read_only(T_part_hands, "T_part_hands", (None, 4, 4))
    found = [judge_grasp(hand, shape, T, opening_m=opening_m, mass_kg=mass_kg) for T in poses]
    kinds = [answer.kind if isinstance(answer, Failure) else "holds" for answer in found]
    return np.array([VERDICTS.index(kind) for kind in kinds], dtype=np.int64)
