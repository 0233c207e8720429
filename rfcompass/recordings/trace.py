"""A trace: recorded reads with all that is needed to interpret them, and nothing about the truth."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import TYPE_CHECKING

import numpy as np
import pyarrow as pa

from rfcompass.arrays import BoolArray, ComplexArray, IntArray
from rfcompass.errors import TraceError
from rfcompass.recordings.antenna_poses import AntennaPoses
from rfcompass.recordings.cells import Cells, average_cells
from rfcompass.recordings.defects import defect
from rfcompass.recordings.observations import observations
from rfcompass.recordings.placement import PlacedReads, place_reads
from rfcompass.recordings.read_table import read_columns
from rfcompass.recordings.stops import STOPS_FILE, Stops
from rfcompass.recordings.stored_proximity import PROXIMITY_FILE
from rfcompass.recordings.trace_meta import TraceMeta
from rfcompass.recordings.trace_quality import TraceQuality, judge_reads
from rfcompass.types.observation import Observation
from rfcompass.types.parts import Part
from rfcompass.types.proximity import ProximityMatrix
from rfcompass.types.reads import ReadTrace, Scan

if TYPE_CHECKING:
    from rfcompass.robots import Robot


@dataclass(frozen=True, slots=True, eq=False)
class Trace:
    """Recorded reads, checked as a whole: holding one means that the format is kept.

    Attributes:
        meta: Conventions and tags.
        reads: One row for each read, columns as in `read_columns`, unknown ones included.
        antenna_poses: Where the antennas were, in the frame `meta.frame`.
        stops: What the robot believed about itself at each stop; None if no tags ride on a robot.
        proximity: Ready-made proximity matrix by stop_id (0 in a trace without stops), usually empty.

    Raises:
        TraceError: If the parts break the format; `file`, `column` and `row` say where.
    """

    meta: TraceMeta
    reads: pa.Table
    antenna_poses: AntennaPoses
    stops: Stops | None = None
    proximity: Mapping[int, ProximityMatrix] = field(default_factory=dict)
    _placed: PlacedReads = field(init=False, repr=False)

    def __post_init__(self) -> None:
        """Check everything; forget the table's free-form schema metadata."""
        set_ = object.__setattr__
        set_(self, "reads", self.reads.replace_schema_metadata(None).combine_chunks())
        columns = read_columns(self.reads, self.meta.phase_sign)
        set_(self, "_placed", place_reads(columns, self.meta, self.antenna_poses, self.stops))
        set_(self, "proximity", MappingProxyType(dict(self.proximity)))
        known = self.stop_ids.tolist() if self.stops is not None else [0]
        for stop_id, matrix in self.proximity.items():
            if stop_id not in known:
                raise defect(PROXIMITY_FILE, f"stop {stop_id} is unknown", column="stop_id", stop_id=stop_id)
            if not matrix.anchor_epcs:
                raise defect(PROXIMITY_FILE, f"the matrix of stop {stop_id} has no anchor", stop_id=stop_id)

    def __reduce__(self) -> tuple[object, ...]:
        """Rebuild through the constructor: a mapping proxy cannot be pickled."""
        return Trace, (self.meta, self.reads, self.antenna_poses, self.stops, dict(self.proximity))

    @property
    def epcs(self) -> tuple[str, ...]:
        """Tags that belong to the trace: those that `meta` lists, or all that were heard if it lists none."""
        return self.meta.epcs or self._placed.columns.epcs

    @property
    def stop_ids(self) -> IntArray:
        """All stops in their order, empty if the trace has none, shape (S,)."""
        return np.empty(0, dtype=np.int64) if self.stops is None else self.stops.stop_ids

    @property
    def quality(self) -> TraceQuality:
        """Quality report; computed anew at each call."""
        return judge_reads(
            self._placed, self.epcs, self.antenna_poses, self.stop_ids, half_turns=self.meta.phase_modulus == "pi"
        )

    def scan(self, stop_id: int | None = None) -> Scan:
        """Average the reads of one stop over cells (antenna position, frequency).

        All tags share the antenna positions at which at least one of them was heard, ordered by pose_id, then
        antenna, and the frequencies. The channel is h = mean amplitude · mean unit phasor, see `cells`; known
        channel offsets o(f) of the raw phase are removed, h · exp(+j phase_sign o(f)). Strays are left out.

        Args:
            stop_id: Which stop; may be None if there is at most one.

        Returns:
            One `ReadTrace` for each tag that was heard at that stop, in the frame `meta.frame`.

        Raises:
            TraceError: If the stop is unknown, or None although there are several.
        """
        cells = average_cells(self._placed, self.epcs, self._of_stop(stop_id))
        channel = cells.means.channel(half_turns=self.meta.phase_modulus == "pi") * self._offset_phasors(cells)
        heard = np.flatnonzero(cells.means.counts.any(axis=(1, 2)))
        traces = {cells.epcs[t]: self._read_trace(cells, int(t), channel[t]) for t in heard}
        return Scan(traces=traces, frame=self.meta.frame, dimensions=self.meta.dimensions)

    def observations(self, robot: "Robot", part: Part, epcs: Sequence[str] | None = None) -> tuple[Observation, ...]:
        """Read every stop as an observation of one part; see `rfcompass.recordings.observations`."""
        return observations(self, robot, part, epcs)

    def _of_stop(self, stop_id: int | None) -> BoolArray | None:
        stop_ids = self.stop_ids.tolist()
        if stop_id is None and len(stop_ids) > 1:
            raise TraceError(f"the trace has several stops, choose one of {stop_ids}", file=STOPS_FILE, stops=stop_ids)
        if stop_id is not None and stop_id not in stop_ids:
            message = f"stop {stop_id} is unknown (stops: {stop_ids or 'none'})"
            raise TraceError(message, file=STOPS_FILE, stop_id=stop_id, stops=stop_ids)
        of_read = self._placed.columns.stop_id
        return None if stop_id is None or of_read is None else np.asarray(of_read == stop_id)

    def _offset_phasors(self, cells: Cells) -> ComplexArray:
        offsets_rad = dict(self.meta.channel_offsets_rad)
        of_frequency = np.array([offsets_rad.get(freq_hz, 0.0) for freq_hz in cells.frequencies_hz.tolist()])
        return np.asarray(np.exp(1j * self.meta.phase_sign * of_frequency))

    def _read_trace(self, cells: Cells, t: int, channel: ComplexArray) -> ReadTrace:
        positions_m = self.antenna_poses.positions_m
        return ReadTrace(
            epc=cells.epcs[t],
            antenna_positions_m=positions_m[cells.rx_rows],
            frequencies_hz=cells.frequencies_hz,
            channel=channel,
            read_counts=cells.means.counts[t],
            antenna_ports=self.antenna_poses.antennas[cells.rx_rows],
            tx_positions_m=positions_m[cells.tx_rows] if self.meta.geometry == "bistatic" else None,
            phase_modulus_rad=self.meta.phase_modulus_rad,
        )
