"""The folder of a task: several parts, each with a whole run folder of its own.

task.json       what was asked, the planned actions and which of them were done
events.jsonl    every action as it happened, with (φ, D, θ) of every localisation
PART/           the run folder of each part that was looked for: `rfcompass locate PART/trace` and all else works on it
view.html       all of it in one page
"""

import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from rfcompass.errors import TraceError
from rfcompass.files import atomic_folder
from rfcompass.recordings.result_folder import check_place, is_described
from rfcompass.recordings.run_folder import EVENTS_FILE, VIEW_FILE, Run, is_run, write_run_files

TASK_FILE = "task.json"
TASK_SCHEMA = "rfcompass-task/1"


@dataclass(frozen=True, slots=True)
class TaskRun:
    """What goes into the folder of a task. JSON values hold no arrays and no NaN.

    Attributes:
        asked: What was asked for: command, options, seed, versions.
        actions: What was planned, and whether it was done.
        events: What happened, in order.
        runs: The run of each part that was looked for, by its name.
        pictures: Writers of further files, by name; each gets the path to write.
    """

    asked: Mapping[str, Any]
    actions: Sequence[Mapping[str, Any]]
    events: Sequence[Mapping[str, Any]]
    runs: Mapping[str, Run]
    pictures: Mapping[str, Callable[[Path], object]] = field(default_factory=dict)


def write_task(task: TaskRun, path: str | Path, *, overwrite: bool = False) -> None:
    """Write the folder of a task, all of it or nothing; equal tasks give equal bytes.

    Args:
        task: What to write.
        path: Folder to create.
        overwrite: Replace a task that is already there. Anything else that is there is never replaced.

    Raises:
        TraceError: If something is there that must not be replaced, or the disk refuses; carries `path`.
    """
    target = Path(path).resolve()
    check_task_target(target, overwrite=overwrite)
    try:
        with atomic_folder(target) as folder:
            described = {"schema": TASK_SCHEMA, **task.asked, "actions": list(task.actions)}
            (folder / TASK_FILE).write_text(json.dumps(described, indent=2, allow_nan=False) + "\n", encoding="utf-8")
            lines = [json.dumps(event, allow_nan=False) + "\n" for event in task.events]
            (folder / EVENTS_FILE).write_text("".join(lines), encoding="utf-8")
            for name, run in task.runs.items():
                (folder / name).mkdir()
                write_run_files(run, folder / name)
            for name, write in task.pictures.items():
                write(folder / name)
    except OSError as cause:
        raise TraceError(f"{target}: cannot be written: {cause}", path=str(target)) from cause


def is_task(path: Path) -> bool:
    """True if a folder holds a task: a `task.json` of our schema, and nothing that a task does not leave."""
    known = (TASK_FILE, EVENTS_FILE, VIEW_FILE)
    return is_described(path, TASK_FILE, TASK_SCHEMA, lambda entry: entry.name in known or is_run(entry))


def check_task_target(path: str | Path, *, overwrite: bool) -> None:
    """Accept a place for a task: nothing there, an empty folder, or a task that may be replaced.

    Raises:
        TraceError: If something is there that must not be replaced, or nothing can be written there; carries `path`.
    """
    check_place(path, "task", is_task, overwrite=overwrite)
