"""A run folder: all that a run left behind, for looking at it again.

run.json        what was asked, software versions, seed
events.jsonl    what happened, one line for each stop
trace/          what was heard, in the trace format
estimate.json   the answer, in the shape that `locate` prints
samples.npz     draws of the pose, if the estimator makes any
*.png view.html pictures
"""

import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from rfcompass.arrays import FloatArray
from rfcompass.errors import TraceError
from rfcompass.files import atomic_folder
from rfcompass.recordings.result_folder import check_place, is_described
from rfcompass.recordings.trace import Trace
from rfcompass.recordings.trace_store import write_trace

RUN_FILE, EVENTS_FILE, ESTIMATE_FILE, SAMPLES_FILE, VIEW_FILE = (
    "run.json", "events.jsonl", "estimate.json", "samples.npz", "view.html",
)  # fmt: skip
TRACE_FOLDER = "trace"
RUN_SCHEMA = "rfcompass-run/1"


@dataclass(frozen=True, slots=True)
class Run:
    """What goes into a run folder. JSON values hold no arrays and no NaN.

    Attributes:
        asked: What was asked for: command, options, seed, versions.
        events: What happened, in order.
        trace: What was heard.
        estimate: The answer, or the failure.
        samples: Draws of (x, y, θ), shape (S, 3).
        pictures: Writers of further files, by name; each gets the path to write.
    """

    asked: Mapping[str, Any]
    events: Sequence[Mapping[str, Any]]
    trace: Trace
    estimate: Mapping[str, Any]
    samples: FloatArray = field(default_factory=lambda: np.zeros((0, 3)))
    pictures: Mapping[str, Callable[[Path], object]] = field(default_factory=dict)


def is_run(path: Path) -> bool:
    """True if a folder holds a run: a `run.json` of our schema, and nothing that a run does not leave."""
    return is_described(path, RUN_FILE, RUN_SCHEMA, lambda entry: _left_by_a_run(entry.name))


def _left_by_a_run(name: str) -> bool:
    known = (RUN_FILE, EVENTS_FILE, ESTIMATE_FILE, SAMPLES_FILE, VIEW_FILE, TRACE_FOLDER)
    return name in known or name.endswith(".png")


def write_run(run: Run, path: str | Path, *, overwrite: bool = False) -> None:
    """Write a run folder, all of it or nothing; equal runs give equal bytes.

    Args:
        run: What to write.
        path: Folder to create.
        overwrite: Replace a run that is already there. Anything else that is there is never replaced.

    Raises:
        TraceError: If something is there that must not be replaced, or the disk refuses; carries `path`.
    """
    target = Path(path).resolve()
    check_target(target, overwrite=overwrite)
    try:
        with atomic_folder(target) as folder:
            write_run_files(run, folder)
    except OSError as cause:
        raise TraceError(f"{target}: cannot be written: {cause}", path=str(target)) from cause


def check_target(path: str | Path, *, overwrite: bool) -> None:
    """Accept a place for a run folder: nothing there, an empty folder, or a run that may be replaced.

    Raises:
        TraceError: If something is there that must not be replaced, or nothing can be written there; carries `path`.
    """
    check_place(path, "run", is_run, overwrite=overwrite)


def write_run_files(run: Run, folder: Path) -> None:
    """Write what belongs into a run folder, into one that is there and empty."""
    (folder / RUN_FILE).write_text(_json({"schema": RUN_SCHEMA, **run.asked}, indent=2), encoding="utf-8")
    (folder / EVENTS_FILE).write_text("".join(map(_json, run.events)), encoding="utf-8")
    (folder / ESTIMATE_FILE).write_text(_json(run.estimate, indent=2), encoding="utf-8")
    write_trace(run.trace, folder / TRACE_FOLDER)
    if len(run.samples):
        np.savez(folder / SAMPLES_FILE, samples=run.samples)
    for name, write in run.pictures.items():
        write(folder / name)


def _json(value: Mapping[str, Any], indent: int | None = None) -> str:
    return json.dumps(value, indent=indent, allow_nan=False) + "\n"
