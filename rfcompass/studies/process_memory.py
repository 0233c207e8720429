"""Memory of processes: how much one holds, and how much more this one may take."""

import os
import resource
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

ON_LINUX = sys.platform == "linux"

# How often to look [s]. macOS has no file to read, and starting `ps` takes ten milliseconds.
LOOK_SECONDS = 0.05 if ON_LINUX else 0.5

# Fields of /proc/PID/statm, in pages.
_RESIDENT, _DATA = 1, 5


def resident_bytes(process: int) -> int:
    """Return the resident memory of a process [bytes], 0 if there is no such process any more."""
    try:
        if ON_LINUX:
            return _statm(str(process), _RESIDENT)
        shown = subprocess.run(["ps", "-o", "rss=", "-p", str(process)], capture_output=True, check=False)  # noqa: S603, S607
        return 1024 * int(shown.stdout or 0)
    except (OSError, ValueError):
        return 0


@contextmanager
def at_most(more_bytes: int | None) -> Iterator[None]:
    """Let this process allocate no more than so many bytes, as far as the system can say no.

    Linux refuses private writable memory beyond RLIMIT_DATA, touched or not, which Python raises as a MemoryError.
    (RLIMIT_AS would count files and reserved addresses as well.) macOS binds neither, so that nothing happens there.
    """
    if more_bytes is None or not ON_LINUX:
        yield
        return
    soft, hard = resource.getrlimit(resource.RLIMIT_DATA)
    limit = _statm("self", _DATA) + more_bytes
    resource.setrlimit(resource.RLIMIT_DATA, (limit if hard == resource.RLIM_INFINITY else min(limit, hard), hard))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_DATA, (soft, hard))


def _statm(process: str, field: int) -> int:
    return int(Path(f"/proc/{process}/statm").read_bytes().split()[field]) * os.sysconf("SC_PAGE_SIZE")
