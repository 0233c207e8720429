"""Files and folders that are there as a whole or not at all, and JSON files that can be read or say why not."""

import json
import os
import shutil
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any
from uuid import uuid4

from rfcompass.errors import RfCompassError


def write_atomic(path: Path, write: Callable[[Path], object]) -> None:
    """Let `write` fill a file beside `path`, then put it in place at once, safely on the disk.

    Whoever reads, even after a crash, sees the old file, the new file or none. What a killed writer leaves behind
    starts with a point and ends with `.tmp`.
    """
    draft = path.with_name(f".{path.name}.{uuid4().hex}.tmp")
    try:
        write(draft)
        with draft.open("rb+") as file:
            os.fsync(file.fileno())
        draft.replace(path)
    finally:
        draft.unlink(missing_ok=True)


def write_text_atomic(path: Path, text: str) -> None:
    """Write a text file as a whole, in UTF-8."""
    write_atomic(path, lambda draft: draft.write_text(text, encoding="utf-8"))


@contextmanager
def atomic_folder(path: Path) -> Iterator[Path]:
    """Let the body fill a new folder beside `path`, then put it in place at once, safely on the disk.

    If the body fails, nothing is left behind. What is at `path` already steps aside, is removed in the end, and
    comes back if the new folder cannot take its place: whoever calls has made sure that it may be replaced.
    """
    partial = path.with_name(f".{path.name}.{uuid4().hex}.partial")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        partial.mkdir()
        yield partial
        for file in partial.rglob("*"):
            _sync(file)
        _sync(partial)
        _move_into_place(partial, path)
    finally:
        shutil.rmtree(partial, ignore_errors=True)


def _move_into_place(partial: Path, target: Path) -> None:
    if not target.exists() or not any(target.iterdir()):
        partial.rename(target)
    else:
        former = partial.with_suffix(".former")
        target.rename(former)
        try:
            partial.rename(target)
        except OSError:
            former.rename(target)
            raise
        shutil.rmtree(former)
    _sync(target.parent)


def _sync(path: Path) -> None:
    descriptor = os.open(path, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)


def read_json(file: Path, error: type[RfCompassError]) -> Any:  # noqa: ANN401 - whatever the file holds
    """Read a JSON file.

    Raises:
        RfCompassError: Of the class `error`, if there is no such file, or it is no JSON.
    """
    try:
        return json.loads(file.read_text(encoding="utf-8"))
    except (OSError, ValueError) as cause:
        raise error(f"{file}: cannot be read as JSON: {cause}", file=str(file)) from cause
