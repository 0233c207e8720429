"""How far a scan's comparisons can be trusted, as JSON."""

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from rfcompass.types.proximity import ProximityMatrix
    from rfcompass.types.tags import TagPositions


def comparator_json(matrix: "ProximityMatrix", anchors: "TagPositions") -> dict[str, Any] | None:
    """Judge a meter by the robot's own tags; None where too few of them were heard."""
    from rfcompass.errors import TooFewPairs
    from rfcompass.rf import check_comparator

    try:
        quality = check_comparator(matrix, anchors)
    except TooFewPairs:
        return None
    noise = quality.log_distance_noise
    return {
        "verdict": quality.verdict,
        "rank_correlation": quality.rank_correlation,
        "log_distance_noise": noise if noise < float("inf") else None,
        "wrong_share": quality.wrong_share,
        "pairs": quality.pairs,
    }
