"""A fetch with a robot behind a socket as a trace: means of cells, since that is what a scan keeps of the reads."""

from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from typing import TypeAlias

import numpy as np
import pyarrow as pa

from rfcompass.arrays import FloatArray
from rfcompass.recordings import AntennaPoses, Trace, TraceMeta
from rfcompass.robots import Robot
from rfcompass.simulation import RecordedStop
from rfcompass.studies.fetch_trace import trace_of_stops
from rfcompass.types.reads import ReadTrace, Scan

_COLUMNS = {
    "epc": pa.string(), "antenna": pa.int32(), "freq_hz": pa.float64(), "pose_id": pa.int64(), "tx_antenna": pa.int32(),
    "i": pa.float64(), "q": pa.float64(), "stop_id": pa.int64(),
}  # fmt: skip

# Antenna position, its port, position of the transmitting one, and which time the same was seen within one tag's reads.
_Place: TypeAlias = tuple[tuple[float, ...], int, tuple[float, ...], int]


def remote_trace(robot: Robot, stops: Sequence[RecordedStop], robot_name: str) -> Trace:
    """Record what was believed and heard at every stop: one read for each cell with any, or ready-made proximities.

    Args:
        robot: The robot that carried the tags.
        stops: All stops of one job, at least one.
        robot_name: How the robot's side calls it.
    """
    scans = [stop.observation.scan for stop in stops if stop.observation.scan.traces]
    traces = [trace for scan in scans for trace in scan.traces.values()]
    cells = _Cells(max((int(trace.antenna_ports.max(initial=0)) for trace in traces), default=0) + 1)
    for stop in stops:
        cells.add(stop.observation.stop_id, stop.observation.scan)
    bistatic = any(trace.tx_positions_m is not None for trace in traces)
    meta = TraceMeta(
        frame=scans[0].frame if scans else "odom",
        geometry="bistatic" if bistatic else "monostatic",
        phase_modulus="pi" if any(trace.phase_modulus_rad < 4.0 for trace in traces) else "2pi",
        dimensions=scans[0].dimensions if scans else 3,
        source=f"{robot_name} over a robot link: {'means of cells, one row each' if scans else 'distances'}",
    )
    return trace_of_stops(robot, stops, meta, cells.reads(bistatic=bistatic), cells.poses(bistatic=bistatic))


@dataclass(slots=True)
class _Cells:
    """Cells as rows, and antenna poses, numbered on from stop to stop.

    Args:
        tx_port: Number for the transmitting antenna, whose own is not known.
    """

    tx_port: int
    _rows: list[tuple[object, ...]] = field(init=False, default_factory=list)
    _places: list[_Place] = field(init=False, default_factory=list)

    def add(self, stop_id: int, scan: Scan) -> None:
        """Add what one stop heard; tags share the positions that they have in common."""
        ids = dict[_Place, int]()
        for trace in scan.traces.values():
            at = list(_places_of(trace))
            for place in at:
                if place not in ids:
                    ids[place] = len(self._places)
                    self._places.append(place)
            for m, f in np.argwhere((trace.read_counts > 0) & (trace.channel != 0)).tolist():
                h, freq_hz = complex(trace.channel[m, f]), float(trace.frequencies_hz[f])
                self._rows.append(
                    (trace.epc, at[m][1], freq_hz, ids[at[m]], self.tx_port, h.real, h.imag, stop_id)
                )  # fmt: skip

    def reads(self, *, bistatic: bool) -> pa.Table:
        """All cells, as columns of `reads.parquet`."""
        columns = list(zip(*self._rows, strict=True)) or [()] * len(_COLUMNS)
        table = {
            name: pa.array(column, kind) for (name, kind), column in zip(_COLUMNS.items(), columns, strict=True)
        }  # fmt: skip
        return pa.table({name: column for name, column in table.items() if bistatic or name != "tx_antenna"})

    def poses(self, *, bistatic: bool) -> AntennaPoses:
        """Where the antennas were; how they were turned is not known."""
        rows = [(pose_id, port, rx_m) for pose_id, (rx_m, port, _, _) in enumerate(self._places)]
        if bistatic:
            rows += [(pose_id, self.tx_port, tx_m) for pose_id, (_, _, tx_m, _) in enumerate(self._places)]
        positions_m: FloatArray = np.array([position_m for _, _, position_m in rows], dtype=np.float64).reshape(-1, 3)
        return AntennaPoses(
            pose_ids=np.array([pose_id for pose_id, _, _ in rows], dtype=np.int64),
            antennas=np.array([port for _, port, _ in rows], dtype=np.int64),
            positions_m=positions_m,
            quaternions_xyzw=np.tile([0.0, 0.0, 0.0, 1.0], (len(rows), 1)),
        )


def _places_of(trace: ReadTrace) -> Iterator[_Place]:
    """Where each position of a tag's reads is; a monostatic antenna sends from where it listens."""
    tx_m = trace.antenna_positions_m if trace.tx_positions_m is None else trace.tx_positions_m
    seen = Counter[tuple[object, ...]]()
    both = zip(trace.antenna_positions_m.tolist(), trace.antenna_ports.tolist(), tx_m.tolist(), strict=True)
    for rx, port, tx in both:
        place = (tuple(rx), port, tuple(tx))
        yield (*place, seen[place])
        seen[place] += 1
