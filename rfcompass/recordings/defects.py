"""How a defect of a trace is reported: the same numbers everywhere, so that programs can act on them."""

import numpy as np

from rfcompass.arrays import BoolArray
from rfcompass.errors import TraceError


def defect(
    file: str, message: str, *, column: str | None = None, row: int | None = None, **numbers: object
) -> TraceError:
    """Build the error for one defect.

    Args:
        file: Name of the file inside the trace folder.
        message: What is wrong, without the place.
        column: Column or key, where known.
        row: Row of the file's data, counted from 0 without the header, where known.
        **numbers: More evidence.
    """
    place = "".join((f", column {column}" if column else "", f", row {row}" if row is not None else ""))
    known = {"column": column, "row": row}
    evidence = {name: value for name, value in known.items() if value is not None}
    return TraceError(f"{file}{place}: {message}", file=file, **evidence, **numbers)


def first_row(bad: BoolArray) -> int | None:
    """Row of the first True, None if there is none; `bad` has shape (R,)."""
    return int(np.argmax(bad)) if bad.any() else None
