"""The pose of a part that lies on something: the same search at several heights, weighed by their evidence.

Near-field images are made in the plane of a stated height, so what they measure is another thing at every height, and
no evidence for one of them: the images are then made anew at each, and all heights stay as likely as they were.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from rfcompass.arrays import FloatArray
from rfcompass.errors import Infeasible, InputError
from rfcompass.localization.evidence_trust import TrustedEvidence, trust
from rfcompass.localization.part_evidence import PartEvidence
from rfcompass.localization.pose_inference import infer_pose, see_tags
from rfcompass.localization.pose_posterior import PosePosterior
from rfcompass.localization.pose_search import split_cells
from rfcompass.types.observation import Observation

_SPARE = 1e-6  # ours: cells of less probability than this beside the best are left out


def lifts_between(low_m: float, high_m: float, step_m: float) -> FloatArray:
    """Heights to try [m], ends included, at most a step apart.

    Raises:
        InputError: If the ends are not in order, the step is not above 0, or there are more than 100 heights.
    """
    if not (np.isfinite([low_m, high_m, step_m]).all() and low_m <= high_m and step_m > 0.0):
        message = f"heights from {low_m} to {high_m} m in steps of {step_m} m are no range"
        raise InputError(message, low_m=low_m, high_m=high_m, step_m=step_m)
    count = int(np.ceil((high_m - low_m) / step_m - 1e-9)) + 1
    if count > 100:
        message = f"{count} heights from {low_m} to {high_m} m; at most 100"
        raise InputError(message, low_m=low_m, high_m=high_m, step_m=step_m)
    return np.linspace(low_m, high_m, count)


def infer_lifted(
    evidence: PartEvidence, bounds_m: FloatArray, lifts_m: FloatArray
) -> tuple[PosePosterior, TrustedEvidence]:
    """Infer pose and height together, every height as likely as any other beforehand.

    p(x, y, θ, h | everything) ∝ p(everything | x, y, θ, h): one search at each height, joined by their evidence.

    Args:
        evidence: What was heard, with the part at its stated height.
        bounds_m: Where the part's centre may lie [m], [[xmin, xmax], [ymin, ymax]].
        lifts_m: How much higher than stated the part may lie [m], shape (H,).

    Returns:
        The posterior, and what was trusted at the likeliest height.

    Raises:
        Infeasible: If no pose inside the bounds has any probability at any height.
    """
    trusted = [trust(evidence.lifted(float(lift_m)), bounds_m) for lift_m in lifts_m]
    # Evidence can be compared only if stops and noise are the same: those of the height where least is amiss.
    order = [(len(one.dropped), one.noise_factor, one.wrong_share) for one in trusted]
    at = min(range(len(order)), key=order.__getitem__)
    found, heights = [], []
    for lift_m in lifts_m:
        lifted = trusted[at].evidence.lifted(float(lift_m - lifts_m[at]))
        try:
            found.append(infer_pose(lifted, see_tags(lifted, bounds_m), bounds_m))
            heights.append(float(lift_m))
        except Infeasible:
            continue
    if not found:
        message = f"no place inside {bounds_m.tolist()} m fits what was heard at any height"
        raise Infeasible(message, bounds_m=bounds_m.tolist(), rows=evidence.rows)
    return _joined(found, heights), trusted[at]


def raised(observations: Sequence[Observation], lift_m: float) -> list[Observation]:
    """The same stops, with the part stated to lie higher by so much [m]."""
    return [replace(stop, part_tag_heights_m=stop.part_tag_heights_m + lift_m) for stop in observations]


def mixed(found: Sequence[PosePosterior], lifts_m: Sequence[float]) -> PosePosterior:
    """Join posteriors of several heights, every height as likely as any other: p(z) = mean_h p(z | h).

    Args:
        found: One for each height.
        lifts_m: How much higher than stated the part lies in each [m].
    """
    return _joined([replace(one, log_evidence=0.0) for one in found], lifts_m)


def _joined(found: Sequence[PosePosterior], lifts_m: Sequence[float]) -> PosePosterior:
    """All cells, brought to one size, each height weighed by its evidence."""
    log_evidence = np.array([one.log_evidence for one in found])
    share = np.exp(log_evidence - log_evidence.max())
    half = np.min([one.half for one in found], axis=0)
    parts = [_split_to(one, half) for one in found]
    weight = np.concatenate([w * own for (_, w), own in zip(parts, share, strict=True)])
    kept = weight > _SPARE * weight.max()
    lift_m = np.repeat(lifts_m, [len(w) for _, w in parts])
    best = found[int(log_evidence.argmax())]
    return replace(
        best, cells=np.vstack([cells for cells, _ in parts])[kept], weight=weight[kept] / weight[kept].sum(), half=half,
        lift_m=lift_m[kept], log_evidence=float(log_evidence.max() + np.log(share.mean())),
    )  # fmt: skip


def _split_to(posterior: PosePosterior, half: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Cells of the given size, and the probability of each; sizes differ by powers of two."""
    cells, own = posterior.cells, posterior.half.copy()
    ways = 1
    for axis, turn in ((0, False), (1, True)):
        while own[axis] > 1.5 * half[axis]:
            cells = split_cells(cells, own, turn)
            own[axis] /= 2.0
            ways *= 2 if turn else 4
    return cells, np.repeat(posterior.weight, ways) / ways
