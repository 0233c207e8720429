"""Read-only array fields: the one way a record takes an array in.

Records keep arrays as immutable copies, so that nobody can change an observation after it was made.
Pickle and JSON drop the read-only flag; loaders therefore go through the record's constructor again.
"""

import math
from collections.abc import Mapping
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

from rfcompass.errors import ShapeError

FloatArray: TypeAlias = npt.NDArray[np.float64]
ComplexArray: TypeAlias = npt.NDArray[np.complex128]
IntArray: TypeAlias = npt.NDArray[np.int64]
BoolArray: TypeAlias = npt.NDArray[np.bool_]

Shape: TypeAlias = tuple[int | None, ...]


def read_only(
    value: npt.ArrayLike, name: str, shape: Shape, dtype: npt.DTypeLike = np.float64, *, finite: bool = True
) -> npt.NDArray[Any]:
    """Return an immutable, C-contiguous copy of `value` after checking it.

    Args:
        value: Anything numpy can turn into an array.
        name: What to call it in an error message, for example `"ReadTrace.channel"`.
        shape: Expected shape; `None` leaves an axis free.
        dtype: Element type of the result. Casting must not lose information (1.5 is no integer).
        finite: Reject NaN and infinity. Pass `False` where NaN means "missing".

    Raises:
        ShapeError: If shape, type or finiteness is not as stated.
    """
    array = _cast(value, name, np.dtype(dtype))
    if not _fits(array.shape, shape):
        raise ShapeError(f"{name}: expected shape {_show(shape)}, got {array.shape}", name=name, got=array.shape)
    if finite and array.dtype.kind in "fc" and not np.isfinite(array).all():
        bad = int(np.size(array) - np.isfinite(array).sum())
        raise ShapeError(f"{name}: {bad} of {array.size} values are not finite", name=name, not_finite=bad)
    array.flags.writeable = False
    return array


def _cast(value: npt.ArrayLike, name: str, dtype: np.dtype[Any]) -> npt.NDArray[Any]:
    try:
        raw = np.asarray(value)
        if raw.size and dtype.kind in "iub" and raw.dtype.kind not in "iub":
            raise TypeError(f"{raw.dtype} is not {dtype}")
        return np.array(raw, dtype=dtype, order="C", copy=True)
    except (TypeError, ValueError) as error:
        raise ShapeError(f"{name}: cannot be read as {dtype}: {error}", name=name, dtype=str(dtype)) from error


def _fits(got: tuple[int, ...], expected: Shape) -> bool:
    return len(got) == len(expected) and all(want in (None, have) for have, want in zip(got, expected, strict=True))


def _show(shape: Shape) -> str:
    return "(" + ", ".join("*" if size is None else str(size) for size in shape) + ")"


def plain(value: Any) -> Any:  # noqa: ANN401 - whatever JSON can hold
    """Turn arrays, numpy scalars and mappings into what JSON can hold; NaN and infinity become null, the rest text."""
    match value:
        case np.ndarray() | np.generic():
            return plain(value.tolist())
        case Mapping():
            return {str(key): plain(item) for key, item in value.items()}
        case list() | tuple() | set() | frozenset():
            return [plain(item) for item in value]
        case float():
            return value if math.isfinite(value) else None
        case None | str() | int():
            return value
    return str(value)
