"""Estimates as `locate` and `fetch` print and store them: a JSON file, in a run folder with samples beside it."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from rfcompass.arrays import FloatArray
from rfcompass.errors import EstimateError, NoEstimate
from rfcompass.files import read_json
from rfcompass.recordings.run_folder import ESTIMATE_FILE, SAMPLES_FILE
from rfcompass.types.estimate import DiagnosticValue, PartEstimate


def read_estimate(path: Path | str, *, height_m: float | None = None) -> PartEstimate:
    """Read an estimate.

    Args:
        path: JSON file, or a run folder; `samples.npz` beside it holds draws of the pose, if there is one.
        height_m: Height of the part's centre over the base frame [m] where the file has none, as those of older runs.

    Raises:
        EstimateError: If the file is none, a key is missing or ill-typed, or the height is not known.
        NoEstimate: If the run ended without an estimate; carries what it said.
        ShapeError: If a value is not finite, such as a covariance where the pose was observed.
    """
    given = Path(path)
    file = given / ESTIMATE_FILE if given.is_dir() else given
    content = _read_json(file)
    if isinstance(failure := content.get("failure"), Mapping):
        kind, message = failure.get("kind", "unknown"), failure.get("message", "no message")
        raise NoEstimate(f"{file}: holds no estimate but a failure, {kind}: {message}", file=str(file), failure=kind)
    height = _number(content, "height_m", file) if "height_m" in content else height_m
    if height is None:
        raise EstimateError(f"{file}: says nothing about the part's height (height_m)", file=str(file), key="height_m")
    covariance = content.get("covariance")
    return PartEstimate(
        part_id=_text(content, "part", file),
        centre_m=_array(content.get("centre_m"), "centre_m", file),
        theta_rad=None if content.get("theta_rad") is None else _number(content, "theta_rad", file),
        method=str(content.get("method", "not stated")),
        stops=int(_number(content, "stops", file)) if "stops" in content else 1,
        height_m=height,
        covariance=None if covariance is None else _array(covariance, "covariance", file),
        samples=_samples(file.with_name(SAMPLES_FILE)),
        diagnostics=_diagnostics(content, file),
    )


def _read_json(file: Path) -> Mapping[str, Any]:
    content = read_json(file, EstimateError)
    if not isinstance(content, dict):
        raise EstimateError(f"{file}: holds no JSON object", file=str(file))
    return content


def _diagnostics(content: Mapping[str, Any], file: Path) -> dict[str, DiagnosticValue]:
    """What the method said about its own work; values that are no scalars are left out."""
    found = content.get("diagnostics", {})
    if not isinstance(found, Mapping):
        raise EstimateError(f"{file}: diagnostics is {found!r}, no object", file=str(file), key="diagnostics")
    return {
        name: value for name, value in found.items() if value is None or isinstance(value, bool | int | float | str)
    }


def _number(content: Mapping[str, Any], key: str, file: Path) -> float:
    value = content.get(key)
    if isinstance(value, bool) or not isinstance(value, int | float) or not np.isfinite(value):
        raise EstimateError(f"{file}: {key} is {value!r}, no finite number", file=str(file), key=key)
    return float(value)


def _text(content: Mapping[str, Any], key: str, file: Path) -> str:
    if not isinstance(value := content.get(key), str):
        raise EstimateError(f"{file}: {key} is {value!r}, no text", file=str(file), key=key)
    return value


def _array(value: object, key: str, file: Path) -> FloatArray:
    """Nested lists as an array; null is NaN."""
    try:
        return np.array(value, dtype=np.float64)
    except (TypeError, ValueError) as cause:
        raise EstimateError(f"{file}: {key} is {value!r}, no list of numbers", file=str(file), key=key) from cause


def _samples(file: Path) -> FloatArray:
    if not file.is_file():
        return np.zeros((0, 3))
    try:
        with np.load(file) as stored:
            return np.asarray(stored["samples"], dtype=np.float64)
    except (OSError, ValueError, KeyError, EOFError) as cause:
        raise EstimateError(f"{file}: cannot be read: {cause}", file=str(file)) from cause
