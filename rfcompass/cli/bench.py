"""`rfcompass bench`: our own timings beside the peers', in one run."""

import contextlib
import os
import runpy
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Annotated

import typer

from rfcompass.cli.output import JsonFlag, answering, print_json, print_table
from rfcompass.errors import InputError

BENCHMARKS = Path(__file__).resolve().parents[2] / "benchmarks"


def bench(
    names: Annotated[
        list[str] | None, typer.Argument(help="Benchmarks to run, for example dtw; all by default.")
    ] = None,
    fast: Annotated[bool, typer.Option(help="Tiny sizes: does everything still run?")] = False,
    as_json: JsonFlag = False,
) -> None:
    """Time our hot paths beside the libraries that one would use instead, and print the ratios."""
    with answering(as_json):
        known = {path.stem.removeprefix("bench_"): path for path in sorted(BENCHMARKS.glob("bench_*.py"))}
        chosen = names or list(known)
        if not known:
            raise InputError(f"there are no benchmarks at {BENCHMARKS}: they come with the repository, not the package")
        if unknown := sorted(set(chosen) - set(known)):
            raise InputError(f"no benchmark {', '.join(unknown)}; known: {', '.join(known)}", known=list(known))
        sys.path.insert(0, str(BENCHMARKS.parent))  # benchmarks share `benchmarks.timing`
        with _stdout_to_stderr():
            timings = [timing for name in chosen for timing in runpy.run_path(str(known[name]))["run"](fast)]
        if as_json:
            print_json({"timings": [timing.as_dict() for timing in timings]})
            return
        columns = ("name", "ours", "peer", "peer's", "ratio", "agreement")
        print_table("Timings, one thread, one run", columns, (timing.cells() for timing in timings))


@contextlib.contextmanager
def _stdout_to_stderr() -> Iterator[None]:
    """Keep stdout for the report: a peer's compiled code (HiGHS) prints to it past Python's `sys.stdout`."""
    sys.stdout.flush()
    kept = os.dup(1)
    os.dup2(2, 1)
    try:
        yield
    finally:
        sys.stdout.flush()
        os.dup2(kept, 1)
        os.close(kept)
