"""How every command answers: JSON or a table on stdout, messages on stderr, and the exit code.

Exit 0: done. Exit 1: no answer, for a typed reason. Exit 2: bad input.
"""

import json
import sys
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from typing import Annotated, Any

import typer
from rich.console import Console
from rich.markup import escape
from rich.table import Table

from rfcompass.arrays import plain
from rfcompass.errors import InputError, RfCompassError

EXIT_NO_ANSWER = 1
EXIT_BAD_INPUT = 2

JsonFlag = Annotated[bool, typer.Option("--json", help="Print the answer as JSON on stdout.")]


def messages() -> Console:
    """Console for progress and messages: standard error."""
    return Console(stderr=True, highlight=False, soft_wrap=True)


@contextmanager
def answering(as_json: bool) -> Iterator[None]:
    """Turn our own errors into a message, a `failure` object and the exit code they stand for."""
    try:
        yield
    except RfCompassError as error:
        code = EXIT_BAD_INPUT if isinstance(error, InputError) else EXIT_NO_ANSWER
        messages().print(f"[bold red]{error.kind}[/]: ", end="")
        messages().print(error.message, markup=False)
        if as_json:
            print_json(failure_json(error))
        raise typer.Exit(code) from error


def failure_json(error: RfCompassError) -> dict[str, Any]:
    """Return the shape in which a failure is printed and stored."""
    return {"failure": {"kind": error.kind, "message": error.message, **error.numbers}}


def print_json(answer: Mapping[str, Any]) -> None:
    """Write one JSON object to stdout; NaN becomes null."""
    sys.stdout.write(json.dumps(plain(answer), allow_nan=False) + "\n")


def print_table(title: str, columns: Iterable[str], rows: Iterable[Iterable[object]]) -> None:
    """Write a table for people to stdout."""
    table = Table(title=escape(title), title_justify="left")
    for column in columns:
        table.add_column(escape(column), justify="left" if column in ("EPC", "method", "kind", "name") else "right")
    for row in rows:
        table.add_row(*(escape(str(cell)) for cell in row))
    Console(highlight=False).print(table)
