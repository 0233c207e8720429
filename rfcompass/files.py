"""Files that are there as a whole or not at all."""

import os
from collections.abc import Callable
from pathlib import Path
from uuid import uuid4


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
