"""Errors that a run of the study `accuracy` has left, as pairs to draw grasp attempts from.

The rows keep the size of each error, not its direction: a draw takes any direction and either sign of the turn.
"""

import logging
import os
from functools import cache
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.compute as pc

from rfcompass.errors import StudyError
from rfcompass.evaluation.error_pairs import ErrorPairs
from rfcompass.studies.accuracy import ACCURACY, STOPS
from rfcompass.studies.folder import MANIFEST, read_rows

RUN_VARIABLE = "RFCOMPASS_ACCURACY_RUN"
DEFAULT_RUNS = (Path("runs") / "accuracy", Path("runs") / "results" / "accuracy")

_log = logging.getLogger(__name__)


def accuracy_run() -> Path | None:
    """Folder of a run of `accuracy`: the one that `RFCOMPASS_ACCURACY_RUN` names, or a default one that is there.

    Returns:
        None if there is none; says so in the log.

    Raises:
        StudyError: If the variable names a folder without a run.
    """
    named = os.environ.get(RUN_VARIABLE)
    if named is not None:
        if not (Path(named) / MANIFEST).is_file():
            raise StudyError(f"{RUN_VARIABLE} names {named}, where no study was run", folder=named)
        return Path(named).absolute()
    found = next((folder for folder in DEFAULT_RUNS if (folder / MANIFEST).is_file()), None)
    if found is None:
        _log.warning(
            "no run of the study accuracy at %s: its errors are left out; run it, or name one by %s",
            " or ".join(map(str, DEFAULT_RUNS)), RUN_VARIABLE,
        )  # fmt: skip
    return None if found is None else found.absolute()


@cache
def stored_errors(run: Path, rig: str, method: str, tags: int, sight: str = "in sight") -> ErrorPairs:
    """Errors of one method with the hand over the part, after three stops.

    Args:
        run: Folder of a run of `accuracy`.
        rig: What was measured with, one of `RIGS` of that study.
        method: Whose estimates.
        tags: Tags on the part, K.
        sight: `"in sight"` or `"hidden"`.

    Raises:
        StudyError: If the folder holds no such run, or no trial with both a place and an orientation.
    """
    rows = read_rows(run, ACCURACY)
    for factor, value in (("rig", rig), ("tags", tags), ("sight", sight)):
        rows = rows.filter(pc.equal(rows.column(factor), pa.scalar(value)))
    columns = [f"{method}_centre_{STOPS}_m", f"{method}_theta_{STOPS}_rad"]
    if method == "posterior":
        columns.append(f"spread_{STOPS}_m")
    values = np.column_stack([rows.column(name).to_numpy() for name in columns])
    complete = ~np.isnan(values).any(axis=1)
    if not complete.any():
        where = {"rig": rig, "method": method, "tags": tags, "sight": sight}
        raise StudyError(f"{run}: no trial of {where} has both a place and an orientation", folder=str(run), **where)
    found = values[complete]
    return ErrorPairs(
        distance_m=found[:, 0],
        theta_rad=found[:, 1],
        spread_m=found[:, 2] if method == "posterior" else None,
        incomplete=int((~complete).sum()),
    )
