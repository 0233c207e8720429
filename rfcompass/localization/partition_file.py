"""Partition problems as JSON: what `rfcompass partition FILE` reads and prints.

One stop: {"anchors_m", "part_points_m", "comparisons"}; several: {"part_points_m", "stops": [{"pose", "anchors_m",
"comparisons"}]}; and "bounds_m" with either. A comparison is {"target", "nearer", "farther", "margin"}, the margin
if there is one. Indices count from 0 in each stop. A stop's pose is its base frame in the last stop's, and the
answer is in that last frame. `part_points_m` are x, y in the part frame and z, the height, in the base frame.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from rfcompass.arrays import FloatArray, read_only
from rfcompass.errors import InputError, ShapeError
from rfcompass.geometry.pose2 import Pose2, as_pose2
from rfcompass.localization.compared_stop import ComparedStop
from rfcompass.localization.consistency import ConsistencyLocalizer
from rfcompass.localization.partition import PartitionLocalizer
from rfcompass.localization.partition_solver import Centre
from rfcompass.localization.pose_fit import PoseFit
from rfcompass.localization.posterior import PosteriorLocalizer
from rfcompass.localization.problem import check_bounds
from rfcompass.types.comparisons import Comparisons
from rfcompass.types.record import Record

METHODS = ("partition", "consistency", "posterior")
DEFAULT_CENTRE: Centre = "centroid"


@dataclass(frozen=True, slots=True)
class PartitionFile(Record):
    """A partition problem as it was read.

    Attributes:
        stops: Stops, newest last.
        bounds_m: Where the centre may lie [m], [[xmin, xmax], [ymin, ymax]], or None.
    """

    stops: tuple[ComparedStop, ...]
    bounds_m: FloatArray | None


def answer_partition(document: object, method: str = "partition", centre: Centre = DEFAULT_CENTRE) -> dict[str, Any]:
    """Solve a partition problem given as JSON.

    The centroid is the default centre here: over open cells it is closer to the part than the analytic centre,
    and it solves Eq. 8 as well, see `solve_partition`.

    Args:
        document: The parsed JSON.
        method: `"partition"`, `"consistency"` or `"posterior"`.
        centre: Which centre `partition` takes.

    Returns:
        What is printed as JSON: `centre_m`, `theta_rad`, `orientation_norm`, `satisfied_relaxed`, `satisfied`,
        `total`, `epsilon`, `region`, `theta_interval_rad`, `gap`, `outliers`, `method`, `centre`; see `PoseFit`.
        Null stands for what cannot be observed or was not asked. `posterior` adds `probability`, that of the region
        and of the interval.

    Raises:
        InputError: If the document or the method is wrong; names the place.
        Infeasible: If the comparisons contradict each other and `partition` cannot choose among them.
    """
    if method not in METHODS:
        raise InputError(f"no method {method!r}; one of {', '.join(METHODS)}", method=method)
    problem = read_partition(document)
    if method == "posterior":
        posterior = PosteriorLocalizer(bounds_m=problem.bounds_m)
        answer = _as_json(posterior.fit(problem.stops))
        return {"method": method, "centre": "mean", "probability": posterior.probability, **answer}
    if method == "consistency":
        fit, centre = ConsistencyLocalizer(bounds_m=problem.bounds_m).fit(problem.stops), "centroid"
    else:
        fit = PartitionLocalizer(centre=centre, bounds_m=problem.bounds_m).fit(problem.stops)
    return {"method": method, "centre": centre, **_as_json(fit)}


def read_partition(document: object) -> PartitionFile:
    """Read and check a partition problem.

    Raises:
        InputError: If something is missing, ill-typed, not finite or out of range; names the place.
        DegenerateAnchors: If a stop has fewer than two anchors, or all in one place.
    """
    top = _mapping(document, "partition problem")
    points_m = read_only(_need(top, "part_points_m", ""), "part_points_m", (None, 3))
    if len(points_m) == 0:
        raise InputError("part_points_m: the part has no tag", tags=0)
    if "stops" in top:
        if clash := sorted({"anchors_m", "comparisons"} & set(top)):
            raise InputError(f"{', '.join(clash)} stand beside stops; give one or the other", keys=clash)
        stops = _read_stops(_sequence(top["stops"], "stops"), points_m)
    else:
        stops = (_read_stop(top, points_m, Pose2(), ""),)
    bounds = top.get("bounds_m")
    return PartitionFile(stops, None if bounds is None else check_bounds(bounds))


def _read_stops(entries: Sequence[Any], points_m: FloatArray) -> tuple[ComparedStop, ...]:
    if not entries:
        raise InputError("stops: there is none", stops=0)
    stops = []
    for s, entry in enumerate(entries):
        where = f"stops[{s}]."
        stop = _mapping(entry, f"stops[{s}]")
        try:
            pose = as_pose2(_need(stop, "pose", where))
        except ShapeError as error:
            raise InputError(f"{where}pose: {error}", stop=s) from error
        stops.append(_read_stop(stop, points_m, pose, where))
    newest = stops[-1].T_newest_stop
    if max(abs(newest.x_m), abs(newest.y_m), abs(newest.theta_rad)) > 1e-9:
        raise InputError(f"stops[{len(stops) - 1}].pose: the last stop's pose must be [0, 0, 0]", stop=len(stops) - 1)
    return tuple(stops)


def _read_stop(stop: Mapping[str, Any], points_m: FloatArray, pose: Pose2, where: str) -> ComparedStop:
    anchors_m = read_only(_need(stop, "anchors_m", where), f"{where}anchors_m", (None, 3))
    entries = _sequence(_need(stop, "comparisons", where), f"{where}comparisons")
    target, nearer, farther = indices = np.zeros((3, len(entries)), dtype=np.int64)
    margin = np.full(len(entries), np.nan)
    for row, entry in enumerate(entries):
        place = f"{where}comparisons[{row}]"
        comparison = _mapping(entry, place)
        for column, name in enumerate(("target", "nearer", "farther")):
            indices[column, row] = _index(_need(comparison, name, f"{place}."), f"{place}.{name}")
        if comparison.get("margin") is not None:
            margin[row] = float(read_only(comparison["margin"], f"{place}.margin", ()))
    try:
        return ComparedStop(anchors_m, points_m, Comparisons(target, nearer, farther, margin), pose)
    except InputError as error:
        raise type(error)(f"{where}{error.message}", **error.numbers) from error


def _as_json(fit: PoseFit) -> dict[str, Any]:
    return {
        "centre_m": fit.z[:2].tolist(),
        "theta_rad": fit.theta_rad,
        "orientation_norm": fit.orientation_norm,
        "satisfied_relaxed": fit.satisfied_relaxed,
        "satisfied": fit.satisfied,
        "total": fit.total,
        "epsilon": fit.epsilon,
        "region": fit.region_m.tolist(),
        "theta_interval_rad": None if fit.theta_interval_rad is None else list(fit.theta_interval_rad),
        "gap": fit.gap,
        "outliers": fit.outliers.tolist(),
    }


def _need(mapping: Mapping[str, Any], key: str, where: str) -> Any:  # noqa: ANN401 - JSON
    if key not in mapping:
        raise InputError(f"{where}{key} is missing", key=f"{where}{key}")
    return mapping[key]


def _mapping(value: object, where: str) -> Mapping[str, Any]:
    if not isinstance(value, Mapping):
        raise InputError(f"{where}: expected an object, got {type(value).__name__}", where=where)
    return value


def _sequence(value: object, where: str) -> Sequence[Any]:
    if not isinstance(value, list | tuple):
        raise InputError(f"{where}: expected a list, got {type(value).__name__}", where=where)
    return value


def _index(value: object, where: str) -> int:
    if isinstance(value, bool) or not isinstance(value, int) or not 0 <= value < 2**31:
        raise InputError(f"{where}: {value!r} is no index", where=where)
    return value
