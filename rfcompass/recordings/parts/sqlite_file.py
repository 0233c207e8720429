"""The file behind a part database: SQLite, created on first use, recognised by its marks."""

import os
import sqlite3
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from rfcompass.errors import PartDatabaseError

MEMORY = ":memory:"
LOCATION_VARIABLE = "RFCOMPASS_PARTS"

APPLICATION_ID = 0x52464350  # "RFCP", written into the file's header
SCHEMA_VERSION = 1
BUSY_TIMEOUT_S = 10.0  # how long to wait for another process

_TABLES = (
    "CREATE TABLE part (id TEXT PRIMARY KEY, record TEXT NOT NULL)",
    "CREATE TABLE tag (epc TEXT PRIMARY KEY, part_id TEXT NOT NULL REFERENCES part (id) ON DELETE CASCADE)",
    "CREATE TABLE assembly (name TEXT PRIMARY KEY)",
    "CREATE TABLE assembly_part ("
    "assembly TEXT NOT NULL REFERENCES assembly (name) ON DELETE CASCADE, place INTEGER NOT NULL, "
    "part_id TEXT NOT NULL REFERENCES part (id), PRIMARY KEY (assembly, place))",
    f"PRAGMA application_id = {APPLICATION_ID}",
    f"PRAGMA user_version = {SCHEMA_VERSION}",
)


def default_location() -> str:
    """Where parts are kept: `$RFCOMPASS_PARTS`, or else `parts.sqlite` in the user's data folder.

    Raises:
        PartDatabaseError: If the user has no home folder.
    """
    if stated := os.environ.get(LOCATION_VARIABLE):
        return stated
    try:
        home = Path.home()
    except RuntimeError as cause:
        message = f"no home folder to keep parts in; set {LOCATION_VARIABLE} to a file name"
        raise PartDatabaseError(message) from cause
    if sys.platform == "darwin":
        folder = home / "Library" / "Application Support"
    else:
        folder = Path(os.environ.get("XDG_DATA_HOME") or home / ".local" / "share")
    return str(folder / "rfcompass" / "parts.sqlite")


class SqliteFile:
    """A connection with explicit transactions, whose errors name the file.

    Args:
        location: File name, or `":memory:"`. Missing folders are made.

    Raises:
        PartDatabaseError: If the file cannot be opened, is damaged, or is not a part database of this version.
    """

    def __init__(self, location: str) -> None:
        """Open the file and check its marks."""
        self.location = location
        with self._naming_the_file():
            if location != MEMORY:
                Path(location).parent.mkdir(parents=True, exist_ok=True)
            # isolation_level=None: only our own BEGIN begins a transaction
            self._connection = sqlite3.connect(
                location, timeout=BUSY_TIMEOUT_S, isolation_level=None, check_same_thread=False
            )
        try:
            self.run("PRAGMA foreign_keys = ON")
            with self.transaction("BEGIN"):
                self._check_marks()
        except BaseException:
            self.close()
            raise

    @property
    def is_empty(self) -> bool:
        """True for a file without a single table, as SQLite creates it."""
        return not self.rows("SELECT 1 FROM sqlite_master LIMIT 1")

    def close(self) -> None:
        """Close the connection; a transaction that is under way is undone."""
        self._connection.close()

    def create_tables(self) -> None:
        """Make an empty part database of an empty file; call it inside a transaction."""
        for statement in _TABLES:
            self.run(statement)

    def rows(self, statement: str, *values: object) -> list[tuple[Any, ...]]:
        """Return what a query finds."""
        with self._naming_the_file():
            return self._connection.execute(statement, values).fetchall()

    def run(self, statement: str, *values: object) -> int:
        """Change something; return the number of rows that changed."""
        with self._naming_the_file():
            return self._connection.execute(statement, values).rowcount

    @contextmanager
    def transaction(self, begin: str = "BEGIN IMMEDIATE") -> Iterator[None]:
        """Make everything inside happen as a whole, or not at all. An inner transaction joins the outer one.

        Args:
            begin: `"BEGIN IMMEDIATE"` for writing; `"BEGIN"` for reads that must all see one state.
        """
        if self._connection.in_transaction:
            yield
            return
        self.run(begin)
        try:
            yield
            self.run("COMMIT")
        except BaseException:
            if self._connection.in_transaction:
                self._connection.rollback()
            raise

    def _check_marks(self) -> None:
        if self.is_empty:
            return
        found_id, version = (int(self.rows(f"PRAGMA {mark}")[0][0]) for mark in ("application_id", "user_version"))
        if found_id != APPLICATION_ID:
            raise self._error("is a database, but not one of parts", application_id=found_id)
        if version != SCHEMA_VERSION:
            message = f"is a part database of version {version}, this software knows version {SCHEMA_VERSION}"
            raise self._error(message, version=version, known=SCHEMA_VERSION)
        if (verdict := self.rows("PRAGMA quick_check(1)")[0][0]) != "ok":
            raise self._error(f"is damaged: {verdict}")
        self._check_size()

    def _check_size(self) -> None:
        # SQLite takes the missing end of a last page for zeros.
        pages, page_bytes = (int(self.rows(f"PRAGMA {fact}")[0][0]) for fact in ("page_count", "page_size"))
        with self._naming_the_file():
            found = Path(self.location).stat().st_size
        if found < pages * page_bytes:
            raise self._error(f"is damaged: cut off after {found} of {pages * page_bytes} bytes", bytes=found)

    @contextmanager
    def _naming_the_file(self) -> Iterator[None]:
        try:
            yield
        except (sqlite3.Error, OSError, UnicodeDecodeError) as cause:
            busy = isinstance(cause, sqlite3.OperationalError) and "locked" in str(cause)
            detail = f"is in use by another process ({cause})" if busy else f"cannot be used: {cause}"
            raise self._error(detail) from cause

    def _error(self, message: str, **numbers: object) -> PartDatabaseError:
        return PartDatabaseError(f"part database {self.location} {message}", file=self.location, **numbers)
