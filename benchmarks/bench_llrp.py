"""Recording 10 000 reads over LLRP: our source and recorder beside llrpkit's client and sllurp's.

The emulated reader stands in a process of its own, so that only the client's CPU time counts. Everyone hears the same
reads, with phases, and leaves them on the disk: we in a trace, llrpkit in its capture CSV, sllurp in what it prints,
pretty-printing included (the `log` command of 2.0.1, which should write CSV, does not start). What starting and shaking
hands costs is taken off: each figure is a long run less a short one. `differ by` is the largest difference of a phase,
in turns, or 1 if one of the two has lost a read; llrpkit's CSV rounds to 0.1 degrees.

sllurp is GPL and never imported: it runs as a program from an environment of its own, named by the variable SLLURP or
found on the path, and is left out where there is none. `pipx install sllurp==2.0.1` makes one.

    OMP_NUM_THREADS=1 SLLURP=.../bin/sllurp python -m benchmarks.bench_llrp [--fast]
"""

import ast
import asyncio
import csv
import importlib.util
import os
import re
import resource
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from benchmarks.timing import Timing, show
from rfcompass.recordings import TraceMeta, open_trace, record, sources
from rfcompass.types import TagRead

READS, FEW_READS, REPEATS = 10_000, 100, 3
FAST_READS = 300
HOST = "127.0.0.1"
START_S, QUIET_S, GIVE_UP_S = 2.0, 1.0, 120.0


@dataclass(frozen=True)
class Run:
    """What one client spent, CPU time [s], and the phase of each read that it wrote [turns]."""

    cpu_s: float
    phases: np.ndarray


Client = Callable[[int, int, Path], Run]


def made_up_reads(count: int) -> tuple[TagRead, ...]:
    """Random reads of five tags on two ports and fifty channels."""
    rng = np.random.default_rng(0)
    epcs, antennas, channels = rng.integers(5, size=count), rng.integers(2, size=count), rng.integers(50, size=count)
    rssi_dbm, phase_rad = rng.uniform(-80.0, -30.0, count), rng.uniform(0.0, 2.0 * np.pi, count)
    return tuple(
        TagRead(
            epc=f"3008{epcs[k]:020x}",
            antenna=1 + int(antennas[k]),
            freq_hz=902.75e6 + 0.5e6 * int(channels[k]),
            rssi_dbm=float(rssi_dbm[k]),
            phase_rad=float(phase_rad[k]),
            doppler_hz=0.0,
            t_reader_us=1_700_000_000_000_000 + 1000 * k,
        )
        for k in range(count)
    )


def serve(count: int) -> None:
    """Be the reader: say the port, and stay until nobody holds the other end of stdin."""
    with sources.EmulatedReader(sources.SequenceSource(made_up_reads(count))) as reader:
        print(reader.port, flush=True)
        sys.stdin.read()


@contextmanager
def reader_process(count: int) -> Iterator[int]:
    """A reader in its own process; gives its port."""
    command = [sys.executable, "-m", "benchmarks.bench_llrp", "--serve", str(count)]
    root = Path(__file__).resolve().parents[1]
    with subprocess.Popen(command, cwd=root, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as process:
        try:
            yield int(process.stdout.readline())
        finally:
            process.stdin.close()
            process.wait(10.0)


def rfcompass_client(port: int, count: int, folder: Path) -> Run:
    """Source, recorder and trace."""
    meta = TraceMeta(frame="antenna", reader="emulated", phase_modulus="2pi")
    start_s = time.process_time()
    done = record(sources.LlrpSource(HOST, port, max_reads=count), folder / "trace", meta=meta)
    cpu_s = time.process_time() - start_s
    return Run(cpu_s, open_trace(done.path).reads["phase_rad"].to_numpy() / (2.0 * np.pi))


def llrpkit_client(port: int, count: int, folder: Path) -> Run:
    """Reader and capture CSV of llrpkit."""
    from llrpkit import Reader  # noqa: PLC0415 - an extra
    from llrpkit.capture import TagWriter  # noqa: PLC0415

    async def capture() -> None:
        async with Reader(HOST, port) as reader:
            with TagWriter(folder / "capture.csv") as writer:
                stream = reader.inventory(
                    include_phase=True, include_doppler=True, max_tags=count, duration=GIVE_UP_S
                )  # fmt: skip
                async for tag in stream:
                    writer.write(tag)

    start_s = time.process_time()
    asyncio.run(capture())
    cpu_s = time.process_time() - start_s
    with (folder / "capture.csv").open(encoding="utf-8", newline="") as rows:
        return Run(cpu_s, np.array([float(row["phase_deg"]) / 360.0 for row in csv.DictReader(rows)]))


def sllurp_client(command: str) -> Client:
    """Run sllurp as a program, its output in a file."""

    def client(port: int, count: int, folder: Path) -> Run:  # noqa: ARG001 - it cannot be told how many
        log = folder / "sllurp.log"
        options = ["--antennas", "0", "--report-every-n-tags", "1", "--impinj-reports"]
        cpu_s = run_until_quiet([command, "inventory", "--port", str(port), *options, HOST], log)
        seen = re.findall(r"saw tag\(s\): (\[.*?\}\])\n", log.read_text(encoding="utf-8"), re.DOTALL)
        tags = [tag for report in seen for tag in ast.literal_eval(report)]
        return Run(cpu_s, np.array([tag["ImpinjRFPhaseAngle"] / 4096.0 for tag in tags]))

    return client


def run_until_quiet(command: list[str], log: Path) -> float:
    """Run a program until it has printed nothing for a while, then Ctrl-C; its CPU time [s]."""
    before, start_s = resource.getrusage(resource.RUSAGE_CHILDREN), time.monotonic()
    with log.open("w") as out, subprocess.Popen(command, stdout=out, stderr=subprocess.STDOUT) as process:
        size, grown_s = 0, start_s
        while process.poll() is None and time.monotonic() - max(grown_s, start_s + START_S) < QUIET_S:
            time.sleep(0.05)
            if (now := log.stat().st_size) != size:
                size, grown_s = now, time.monotonic()
        process.send_signal(signal.SIGINT)
        process.wait(10.0)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def spent(client: Client, count: int, repeats: int) -> Run:
    """Least CPU time for so many reads beyond the first few, and what the last long run wrote."""
    few, many = ([once(client, n) for _ in range(repeats)] for n in (FEW_READS, FEW_READS + count))
    return Run(min(one.cpu_s for one in many) - min(one.cpu_s for one in few), many[-1].phases)


def once(client: Client, count: int) -> Run:
    """One client at a fresh reader."""
    with tempfile.TemporaryDirectory() as folder, reader_process(count) as port:
        return client(port, count, Path(folder))


def difference(ours: Run, theirs: Run) -> float:
    """Largest difference of a phase [turns]; 1 if somebody lost a read."""
    if len(ours.phases) != len(theirs.phases):
        return 1.0
    off = ours.phases - theirs.phases
    return float(np.abs(off - np.round(off)).max())


def run(fast: bool = False) -> list[Timing]:
    """Time every client that is installed."""
    if importlib.util.find_spec("llrpkit") is None:
        print("llrp left out: it needs llrpkit, pip install 'rfcompass[llrp]'", file=sys.stderr)
        return []
    count, repeats = (FAST_READS, 1) if fast else (READS, REPEATS)
    peers: dict[str, Client] = {"llrpkit, capture CSV": llrpkit_client}
    command = os.environ.get("SLLURP") or shutil.which("sllurp")
    if command is None:
        print("sllurp left out: set SLLURP to its program, in an environment of its own", file=sys.stderr)
    else:
        peers["sllurp, what it prints"] = sllurp_client(command)
    for client in (rfcompass_client, llrpkit_client):
        once(client, FEW_READS)  # imports
    ours = spent(rfcompass_client, count, repeats)
    theirs = {name: spent(client, count, repeats) for name, client in peers.items()}
    what = f"record {count} reads over LLRP"
    return [Timing(what, ours.cpu_s, name, peer.cpu_s, difference(ours, peer)) for name, peer in theirs.items()]


def main(argv: list[str]) -> None:
    """Print the table, or be the reader."""
    if argv[:1] == ["--serve"]:
        serve(int(argv[1]))
    else:
        show(run("--fast" in argv))


if __name__ == "__main__":
    main(sys.argv[1:])
