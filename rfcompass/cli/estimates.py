"""The shape of an estimate on the command line, and the localizers by name."""

from enum import StrEnum
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from collections.abc import Callable

    from rfcompass.interfaces import Localizer
    from rfcompass.types.estimate import PartEstimate


class Estimator(StrEnum):
    """Ways to find a part."""

    PARTITION = "partition"
    CONSISTENCY = "consistency"
    POSTERIOR = "posterior"
    NEAREST_TAG = "nearest_tag"
    SAR = "sar"


def localizer(estimator: Estimator, meter_kind: str = "auto") -> "Localizer":
    """Make a localizer that measures proximities, where they are not given, with a meter.

    Raises:
        UnknownMeter: If there is no such meter.
    """
    from rfcompass.localization import (
        ConsistencyLocalizer,
        NearestTagLocalizer,
        PartitionLocalizer,
        PosteriorLocalizer,
        SarLocalizer,
    )
    from rfcompass.rf import meter

    measured_with = meter(meter_kind)
    if estimator is Estimator.PARTITION:
        return PartitionLocalizer(centre="centroid", meter=measured_with)
    methods: dict[Estimator, Callable[..., Localizer]] = {
        Estimator.CONSISTENCY: ConsistencyLocalizer,
        Estimator.POSTERIOR: PosteriorLocalizer,
        Estimator.NEAREST_TAG: NearestTagLocalizer,
        Estimator.SAR: SarLocalizer,
    }
    return methods[estimator](meter=measured_with)


def estimate_json(estimate: "PartEstimate", proximity: str) -> dict[str, Any]:
    """Return the answer of `locate` and `fetch`; arrays stay arrays."""
    return {
        "part": estimate.part_id,
        "centre_m": estimate.centre_m,
        "height_m": estimate.height_m,
        "theta_rad": estimate.theta_rad,
        "bearing_rad": estimate.bearing_rad,
        "distance_m": estimate.distance_m,
        "covariance": estimate.covariance,
        "region": estimate.region_m,
        "probability": estimate.probability,
        "method": estimate.method,
        "proximity": proximity,
        "stops": estimate.stops,
        "outliers": len(estimate.outliers),
        "diagnostics": estimate.diagnostics,
    }


def one_line(estimate: "PartEstimate") -> str:
    """Say an estimate in one line, in centimetres and degrees."""
    import numpy as np

    x, y = 100 * estimate.centre_m
    theta = "orientation unknown" if estimate.theta_rad is None else f"θ {np.degrees(estimate.theta_rad):6.1f}°"
    return f"x {x:7.1f} cm  y {y:7.1f} cm  {theta}  D {100 * estimate.distance_m:5.0f} cm"
