"""How likely a grasp is to hold: the share of what may be true in which it does.

    P(holds) = ∫ 1[judge(T_part(x, y, θ)⁻¹ T_hand(ε), μ) holds]  p(x, y, θ | measured) p(ε) p(μ)  ≈  (1/S) Σ_s 1[…]

over samples of the estimate, of where the arm puts the hand (ε) and of the friction (μ). The judge is
`rfcompass.robots.judge_grasps`. The part lies on the floor as its frame says, z up.
"""

from dataclasses import dataclass

import numpy as np

from rfcompass.arrays import FloatArray, IntArray, read_only
from rfcompass.errors import InputError, ShapeError
from rfcompass.robots.grasp_batch import VERDICTS, judge_grasps
from rfcompass.types.estimate import PartEstimate
from rfcompass.types.grasp_noise import GraspDraws
from rfcompass.types.grasps import Failure
from rfcompass.types.hands import Hand
from rfcompass.types.parts import Part
from rfcompass.types.record import Record
from rfcompass.types.shapes import Cylinder, Shape, Sphere, rigid_transform


@dataclass(frozen=True, slots=True)
class GraspChance(Record):
    """How likely a grasp is to hold.

    Attributes:
        probability: Share of the samples in which it holds.
        standard_error: Of that share, for the number of samples; never 0 (two samples, one of each, are added).
        risks: Share of the samples that fail for each reason, most frequent first; reasons that never occur are left
            out.
        samples: Number of samples.
    """

    probability: float
    standard_error: float
    risks: tuple[tuple[str, float], ...]
    samples: int


def pose_samples(
    estimate: PartEstimate, rng: np.random.Generator, count: int, *, shape: Shape | None = None
) -> FloatArray | Failure:
    """Draw poses of the part from an estimate.

    Args:
        estimate: Where the part is: its samples, or a normal distribution with its covariance, or the point alone.
        rng: Source of the draws.
        count: How many (S); an estimate with fewer samples repeats some.
        shape: Of the part. A ball or a standing cylinder has no heading that matters, so that an estimate without
            orientation will do.

    Returns:
        x, y, θ in the frame of the estimate [m, m, rad], shape (S, 3); or the failure `"orientation_unknown"`.

    Raises:
        InputError: If the covariance is none, or fewer than one sample is asked for.
    """
    if count < 1:
        raise InputError(f"{count} samples were asked for; at least 1 is needed", count=count)
    if estimate.theta_rad is None:
        return _any_heading(estimate, rng, count, shape)
    if len(estimate.samples):
        return estimate.samples[_rows(len(estimate.samples), rng, count)]
    mean = np.array([*estimate.centre_m, estimate.theta_rad])
    return _normal(mean, estimate.covariance, rng, count)


def _any_heading(
    estimate: PartEstimate, rng: np.random.Generator, count: int, shape: Shape | None
) -> FloatArray | Failure:
    """Draws with any heading, for a thing that is round as it lies."""
    if not (isinstance(shape, Sphere) or (isinstance(shape, Cylinder) and shape.axis == "z")):
        return Failure("orientation_unknown", "the estimate has no orientation, so the jaws have no direction to close")
    if len(estimate.samples):
        centres_m = estimate.samples[_rows(len(estimate.samples), rng, count), :2]
    else:
        covariance = None if estimate.covariance is None else estimate.covariance[:2, :2]
        centres_m = _normal(estimate.centre_m, covariance, rng, count)
    return np.column_stack([centres_m, rng.uniform(-np.pi, np.pi, count)])


def _rows(have: int, rng: np.random.Generator, count: int) -> IntArray:
    return np.asarray(rng.choice(have, count, replace=count > have))


def _normal(mean: FloatArray, covariance: FloatArray | None, rng: np.random.Generator, count: int) -> FloatArray:
    """Draws of a normal distribution; the mean again and again if it has no covariance."""
    if covariance is None:
        return np.tile(mean, (count, 1))
    checked = read_only(covariance, "PartEstimate.covariance", (len(mean), len(mean)))
    scale = max(float(np.trace(checked)), 0.0)
    symmetric = np.allclose(checked, checked.T, atol=1e-9 * scale)
    if not symmetric or np.linalg.eigvalsh(checked)[0] < -1e-9 * scale:
        raise InputError("PartEstimate.covariance: is no covariance", covariance=checked.tolist())
    return np.asarray(rng.multivariate_normal(mean, checked, count, method="eigh"))


def success_probability(
    hand: Hand,
    part: Part,
    T_base_hand: FloatArray,
    samples: FloatArray,
    height_m: float,
    *,
    opening_m: float | None = None,
    draws: GraspDraws | None = None,
) -> GraspChance:
    """Tell how likely a grasp is to hold.

    Args:
        hand: Which hand.
        part: What it grasps.
        T_base_hand: Where the tool frame is sent, in the base frame, homogeneous, shape (4, 4).
        samples: Poses x, y, θ that the part may have in the base frame [m, m, rad], shape (S, 3).
        height_m: Height of the part's centre in the base frame [m].
        opening_m: Distance of the jaws as the hand comes down [m]; the greatest if None.
        draws: One try for each sample, for example `GraspNoise().draw(S, rng)`. The same draws for every candidate
            make candidates comparable. Without, the hand is where it is sent and friction is the hand's own.

    Raises:
        ShapeError: If samples are none or not finite, or the draws not as many.
        InputError: If the hand does not open so far.
        PartError: If the pose is no rigid transform.
    """
    poses = read_only(samples, "samples", (None, 3))
    if not len(poses):
        raise ShapeError("samples: there are none", name="samples")
    T_hand = rigid_transform(T_base_hand, "T_base_hand")
    friction = None
    if draws is not None:
        if len(draws.friction) != len(poses):
            raise ShapeError(f"{len(draws.friction)} draws for {len(poses)} samples", name="draws")
        T_hand, friction = draws.executed(T_hand), draws.friction
    T_part_hands = part_frames(poses, height_m) @ T_hand
    verdicts = judge_grasps(
        hand, part.shape, T_part_hands, opening_m=opening_m, mass_kg=part.mass_kg, friction=friction
    )  # fmt: skip
    return _chance(np.bincount(verdicts, minlength=len(VERDICTS)))


def part_frames(samples: FloatArray, height_m: float) -> FloatArray:
    """Base frame in the part frame for poses x, y, θ of the part (S, 3), shape (S, 4, 4)."""
    c, s = np.cos(samples[:, 2]), np.sin(samples[:, 2])
    x, y = samples[:, 0], samples[:, 1]
    T = np.tile(np.eye(4), (len(samples), 1, 1))
    T[:, 0, 0], T[:, 0, 1], T[:, 0, 3] = c, s, -(c * x + s * y)
    T[:, 1, 0], T[:, 1, 1], T[:, 1, 3] = -s, c, s * x - c * y
    T[:, 2, 3] = -height_m
    return T


def _chance(counts: IntArray) -> GraspChance:
    """What the counts of the verdicts say."""
    S, held = int(counts.sum()), int(counts[0])
    smoothed = (held + 1) / (S + 2)
    order = [v for v in np.argsort(-counts, kind="stable") if v > 0 and counts[v]]
    risks = tuple((VERDICTS[v], float(counts[v] / S)) for v in order)
    return GraspChance(held / S, float(np.sqrt(smoothed * (1 - smoothed) / (S + 2))), risks, S)
