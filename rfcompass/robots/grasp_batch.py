"""Would a grasp hold, for many poses at once: the verdicts of `judge_grasp`, from faces in a tree and compiled.

Agrees with `judge_grasp` but where a question is decided by less than some hundredths of a millimetre or, on round
things, by less than 2.5° of a normal: a circle is a polygon of 96 edges here, a ball one of 1280 triangles.
"""

from dataclasses import fields

import numpy as np
import numpy.typing as npt

from rfcompass.arrays import FloatArray, IntArray, read_only
from rfcompass.errors import InputError
from rfcompass.robots.grasp_judge import GRAVITY_M_S2
from rfcompass.robots.grasp_kernels import HandArrays, PartArrays, judge_poses
from rfcompass.robots.part_faces import part_faces
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
    hand: Hand,
    shape: Shape,
    T_part_hands: FloatArray,
    *,
    opening_m: float | None = None,
    mass_kg: float | None = None,
    friction: npt.ArrayLike | None = None,
) -> IntArray:
    """Judge many poses of a hand.

    Args:
        hand: Which hand.
        shape: What it closes on.
        T_part_hands: Poses of the tool frame in the part frame, homogeneous, shape (S, 4, 4).
        opening_m: Distance of the jaws as it comes down [m]; the greatest if None.
        mass_kg: How heavy the part is; not looked at if None.
        friction: Coefficient for each pose, shape (S,); the hand's own if None.

    Returns:
        Numbers of `VERDICTS`; 0: it holds. Shape (S,).

    Raises:
        InputError: If the hand does not open so far, or a coefficient is not above 0.
        ShapeError: If the poses or the coefficients are not finite, or not as many.
    """
    poses = read_only(T_part_hands, "T_part_hands", (None, 4, 4))
    mu = read_only(np.full(len(poses), hand.friction) if friction is None else friction, "friction", (len(poses),))
    if (mu <= 0).any():
        raise InputError(f"friction: {mu.min()} is not above 0", friction=float(mu.min()))
    opening = hand.opening(opening_m)
    faces, origins_m = part_faces(shape), np.ascontiguousarray(poses[:, :3, 3])
    R = (poses[:, :3, :3].reshape(-1, 3) @ hand.R_tool_hand).reshape(-1, 3, 3)  # one product is quicker than many
    farthest_m = faces.radius_m + float(np.linalg.norm(origins_m, axis=1).max(initial=0.0))
    verdicts = judge_poses(
        R,
        origins_m,
        mu,
        _hand_arrays(hand, opening, farthest_m + 1.0),
        PartArrays(*(getattr(faces, field.name) for field in fields(faces))),
    )
    if mass_kg is not None:
        most_kg = np.minimum(hand.payload_kg, 2 * mu * hand.grip_n / GRAVITY_M_S2)
        verdicts[mass_kg > most_kg] = VERDICTS.index("too_heavy")
    return np.asarray(verdicts)


def _hand_arrays(hand: Hand, opening_m: float, from_m: float) -> HandArrays:
    """The open hand, and what its boxes sweep as it comes down from that far away."""
    boxes_m = hand.boxes_m(opening_m)
    boxes_m[:, 0, 2] = -from_m
    pads_m = np.concatenate([hand.left.pads_m, hand.right.pads_m])
    between_m = np.array([[[-from_m, *pads_m[:, 0].min(axis=0)], [from_m, *pads_m[:, 1].max(axis=0)]]])
    most = max(len(hand.left.pads_m), len(hand.right.pads_m))
    both = np.stack([_filled(hand.left.pads_m, most), _filled(hand.right.pads_m, most)])
    return HandArrays(boxes_m, both, between_m, opening_m, hand.least_m, hand.give_m)


def _filled(pads_m: FloatArray, most: int) -> FloatArray:
    """As many pads as the other jaw has: some that nothing can be in front of, (P, 2, 2)."""
    nothing = np.tile(np.array([[[np.inf], [-np.inf]]]), (most - len(pads_m), 1, 2))
    return np.concatenate([pads_m, nothing])
