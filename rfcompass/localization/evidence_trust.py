"""Does what was heard hang together? Stops that contradict the newest are left out, noise is raised to what is seen."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from rfcompass.arrays import FloatArray
from rfcompass.localization.part_evidence import PartEvidence
from rfcompass.localization.pose_inference import SeenTag, see_tags
from rfcompass.types.record import Record

# All ours.
MEDIAN_T4 = 0.741  # of |t|, t Student-4
_LEAST_FACTOR = 1.5  # noise of the part's tags is raised if it is larger than that of the robot's by this
_CAPPED_AT, _CONTRADICTS = 10.0, 4.0  # mean of min(|u|, 10) over a stop; 1.0 for noise as expected
_WRONG_SHARE, _CONTRADICTING_SHARE = 0.2, 0.35  # of comparisons; pure guesses would be wrong in half of all cases


@dataclass(frozen=True, slots=True)
class TrustedEvidence(Record):
    """Evidence that hangs together.

    Attributes:
        evidence: What is left of it, with noise as large as it is seen to be.
        seen: Where each tag seems to be.
        dropped: Numbers of the stops that were left out.
        noise_factor: By how much the noise of distances was raised.
        wrong_share: Share of comparisons that the tags' best places do not meet; 0 for distances.
    """

    evidence: PartEvidence
    seen: tuple[SeenTag, ...]
    dropped: tuple[int, ...] = ()
    noise_factor: float = 1.0
    wrong_share: float = 0.0


def trust(evidence: PartEvidence, bounds_m: FloatArray) -> TrustedEvidence:
    """Leave out stops that contradict the others, and raise the noise to what is seen.

    With u = (r - d) / s at each tag's own best place, a stop contradicts the others if the mean of min(|u|, 10) over
    its distances is above 4, or more than 35 % of its comparisons are not met. Answers are meant in the newest base
    frame, so the newest stop stays: what contradicts it has lost its place, by slip or by a part that was moved.
    Then α and β are raised by median |u| / 0.741 if that is above 1.5 (few reflections hit the robot's tags, many the
    part's), and λ to twice the share of comparisons that are not met if that is above 20 %.

    Args:
        evidence: What was heard.
        bounds_m: Where the part's centre may lie [m], [[xmin, xmax], [ymin, ymax]].
    """
    dropped: list[int] = []
    seen = see_tags(evidence, bounds_m)
    while (worst := _contradicting(evidence, seen)) is not None:
        dropped.append(worst)
        evidence = evidence.without_stop(worst)
        seen = see_tags(evidence, bounds_m)
    miss = np.concatenate(misses(evidence, seen))
    if evidence.ranges:
        factor = max(1.0, float(np.median(miss)) / MEDIAN_T4)
        if factor <= _LEAST_FACTOR:
            return TrustedEvidence(evidence, seen, tuple(dropped))
        evidence = evidence.noisier(factor)
        return TrustedEvidence(evidence, see_tags(evidence, bounds_m), tuple(dropped), factor)
    wrong = float(np.mean(miss))
    if wrong > _WRONG_SHARE:
        evidence = evidence.with_lapse(min(1.0, 2.0 * wrong))
        seen = see_tags(evidence, bounds_m)
    return TrustedEvidence(evidence, seen, tuple(dropped), wrong_share=wrong)


def misses(evidence: PartEvidence, seen: Sequence[SeenTag]) -> list[FloatArray]:
    """|u| of each distance, or 1 for each comparison that is not met and 0 for the others, at each tag's best place."""
    out = []
    for table, tag in zip(evidence.tables, seen, strict=True):
        near = np.column_stack([tag.best_m - table[:, :2], table[:, 2]])
        if not evidence.ranges:
            far = np.column_stack([tag.best_m - table[:, 3:5], table[:, 5]])
            out.append((np.linalg.norm(near, axis=1) > np.linalg.norm(far, axis=1)).astype(float))
            continue
        d = np.linalg.norm(near, axis=1)
        lever2 = ((tag.best_m - table[:, 8:10]) ** 2).sum(axis=1)
        s2 = table[:, 4] + table[:, 5] * d**2 + table[:, 6] + table[:, 7] * lever2
        out.append(np.abs(table[:, 3] - d) / np.sqrt(s2))
    return out


def _contradicting(evidence: PartEvidence, seen: Sequence[SeenTag]) -> int | None:
    """The older stop that fits worst, if any stop, be it the newest, does not fit."""
    stops = evidence.stops_used
    if stops.size < 2:
        return None
    number, miss = np.concatenate(evidence.stops), np.concatenate(misses(evidence, seen))
    mean = np.array([np.minimum(miss[number == stop], _CAPPED_AT).mean() for stop in stops])
    if mean.max() <= (_CONTRADICTS if evidence.ranges else _CONTRADICTING_SHARE):
        return None
    return int(stops[:-1][mean[:-1].argmax()])
