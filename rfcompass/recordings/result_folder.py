"""What folders of results have in common: a file that says whose they are, and a place that may hold nothing else."""

import json
import os
from collections.abc import Callable
from pathlib import Path

from rfcompass.errors import TraceError


def is_described(path: Path, file: str, schema: str, left: Callable[[Path], bool]) -> bool:
    """True if a folder holds a file of our schema, and nothing that we do not leave.

    Args:
        path: The folder.
        file: Name of the JSON file that describes it.
        schema: What that must name as its schema.
        left: Says whether an entry of the folder may be ours.
    """
    if not (path / file).is_file() or not all(left(entry) for entry in path.iterdir()):
        return False
    try:
        described = json.loads((path / file).read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return False
    return isinstance(described, dict) and described.get("schema") == schema


def check_place(path: str | Path, what: str, is_ours: Callable[[Path], bool], *, overwrite: bool) -> None:
    """Accept a place that can be written: nothing there, an empty folder, or one of ours that may be replaced.

    Args:
        path: Where to write.
        what: What it is called, such as "run".
        is_ours: Tells such a folder.
        overwrite: Whether one that is there may be replaced.

    Raises:
        TraceError: If something is there that must not be replaced, or nothing can be written there; carries `path`.
    """
    target = Path(path)
    check_above(target)
    there = target.is_dir() and is_ours(target)
    if not target.exists() or (target.is_dir() and (not any(target.iterdir()) or (overwrite and there))):
        return
    found = f"a {what}; overwriting was not asked for" if there else f"something else than a {what}"
    raise TraceError(f"{target}: holds {found}", path=str(target))


def check_above(target: Path) -> None:
    """Check that a folder can be made, with those above it that are missing, before there is anything to write.

    Raises:
        TraceError: If the nearest one that is there is no folder, or must not be written to; carries `path`.
    """
    try:
        place = target.resolve()
        above = next((parent for parent in place.parents if _is_there(parent)), place)
        _is_there(place)
    except (OSError, RuntimeError, ValueError) as error:  # links in a circle, a name too long, one with a 0 in it
        raise TraceError(f"{target}: no place for a folder: {error}", path=str(target)) from error
    if not above.is_dir():
        raise TraceError(f"{target}: {above} is no folder", path=str(target))
    if not os.access(above, os.W_OK | os.X_OK):
        raise TraceError(f"{target}: nothing may be written to {above}", path=str(target))


def _is_there(path: Path) -> bool:
    try:
        return path.exists()
    except PermissionError:  # in a folder that one must not look into
        return False
