"""The folder of a search in a pile.

run.json        what was asked, software versions, seed, as for every run
search.json     the answer: how it ended, every action
events.jsonl    every action in order, one line each
trace/          what was heard on the first scan, in the trace format, if any tag was
pile.json       the pile that was simulated, if it was
*.html *.png    pictures: the film with a slider for the time, the report with every decision
"""

import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from rfcompass.errors import TraceError
from rfcompass.files import atomic_folder
from rfcompass.recordings.result_folder import check_place, is_described
from rfcompass.recordings.run_folder import EVENTS_FILE, RUN_FILE, RUN_SCHEMA, TRACE_FOLDER
from rfcompass.recordings.trace import Trace
from rfcompass.recordings.trace_store import write_trace

SEARCH_FILE, FILM_FILE, REPORT_FILE, PILE_FILE = "search.json", "view.html", "report.html", "pile.json"
SEARCH_SCHEMA = "rfcompass-search/1"
_KNOWN = (RUN_FILE, SEARCH_FILE, EVENTS_FILE, TRACE_FOLDER, FILM_FILE, REPORT_FILE, PILE_FILE)


@dataclass(frozen=True, slots=True)
class StoredSearch:
    """What goes into the folder of a search. JSON values hold no arrays and no NaN.

    Attributes:
        asked: What was asked for: command, options, seed, versions.
        answer: How it ended.
        events: Every action, in order.
        files: Writers of further files, by name; each gets the path to write.
        trace: What was heard on the first scan; None if nothing was.
    """

    asked: Mapping[str, Any]
    answer: Mapping[str, Any]
    events: Sequence[Mapping[str, Any]]
    files: Mapping[str, Callable[[Path], object]] = field(default_factory=dict)
    trace: Trace | None = None


def write_search(search: StoredSearch, path: str | Path, *, overwrite: bool = False) -> None:
    """Write the folder of a search, all of it or nothing.

    Args:
        search: What to write.
        path: Folder to create.
        overwrite: Replace a search that is already there. Anything else that is there is never replaced.

    Raises:
        TraceError: If something is there that must not be replaced, or the disk refuses; carries `path`.
    """
    target = Path(path).resolve()
    check_search_target(target, overwrite=overwrite)
    try:
        with atomic_folder(target) as folder:
            asked, told = {"schema": RUN_SCHEMA, **search.asked}, {"schema": SEARCH_SCHEMA, **search.answer}
            for name, value in ((RUN_FILE, asked), (SEARCH_FILE, told)):
                (folder / name).write_text(json.dumps(value, indent=2, allow_nan=False) + "\n", encoding="utf-8")
            lines = [json.dumps(event, allow_nan=False) + "\n" for event in search.events]
            (folder / EVENTS_FILE).write_text("".join(lines), encoding="utf-8")
            if search.trace is not None:
                write_trace(search.trace, folder / TRACE_FOLDER)
            for name, write in search.files.items():
                write(folder / name)
    except OSError as cause:
        raise TraceError(f"{target}: cannot be written: {cause}", path=str(target)) from cause


def is_search(path: Path) -> bool:
    """True if a folder holds a search: a `search.json` of our schema, and nothing that a search does not leave."""
    return is_described(path, SEARCH_FILE, SEARCH_SCHEMA, lambda entry: entry.name in _KNOWN or entry.suffix == ".png")


def check_search_target(path: str | Path, *, overwrite: bool) -> None:
    """Accept a place for a search: nothing there, an empty folder, or a search that may be replaced.

    Raises:
        TraceError: If something is there that must not be replaced, or nothing can be written there; carries `path`.
    """
    check_place(path, "search", is_search, overwrite=overwrite)
