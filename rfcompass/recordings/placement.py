"""Which antenna pose and which stop each read belongs to: the checks between the files of a trace."""

from dataclasses import dataclass

import numpy as np

from rfcompass.arrays import IntArray
from rfcompass.recordings.antenna_poses import AntennaPoses
from rfcompass.recordings.defects import defect, first_row
from rfcompass.recordings.read_table import READS_FILE, ReadColumns
from rfcompass.recordings.stops import STOPS_FILE, Stops
from rfcompass.recordings.trace_meta import TraceMeta


@dataclass(frozen=True, slots=True)
class PlacedReads:
    """Reads with their antenna positions found.

    An antenna position is a pose of the receiving antenna together with one of the transmitting antenna, the same one
    when monostatic. Positions are ordered by the receiver's pose, then the transmitter's.

    Attributes:
        columns: The reads (R).
        position: Antenna position of each read, shape (R,).
        rx_rows: Row of the receiving antenna of each position among the trace's poses, shape (M,).
        tx_rows: Row of its transmitting antenna, shape (M,).
    """

    columns: ReadColumns
    position: IntArray
    rx_rows: IntArray
    tx_rows: IntArray


def place_reads(columns: ReadColumns, meta: TraceMeta, poses: AntennaPoses, stops: Stops | None) -> PlacedReads:
    """Find the antenna pose of each read and check that its stop is known.

    Raises:
        TraceError: If a read names a pose or a stop that is not there, or if the ports contradict `geometry`.
    """
    _check_offsets(columns, meta)
    _check_stops(columns.stop_id, meta, stops)
    P, rx_rows = poses.pose_ids.size, _pose_rows(columns, columns.antenna, "antenna", poses)
    if meta.geometry == "monostatic":
        _check_monostatic(columns)
        return PlacedReads(columns, rx_rows, np.arange(P), np.arange(P))
    if columns.tx_antenna is None:
        raise defect(READS_FILE, "is missing, yet the trace is bistatic", column="tx_antenna")
    tx_rows = _pose_rows(columns, columns.tx_antenna, "tx_antenna", poses)
    pairs, position = np.unique(rx_rows * P + tx_rows, return_inverse=True)
    return PlacedReads(columns, position, pairs // max(P, 1), pairs % max(P, 1))


def _pose_rows(columns: ReadColumns, antennas: IntArray, column: str, poses: AntennaPoses) -> IntArray:
    rows = poses.rows_of(columns.pose_id, antennas)
    if (row := first_row(rows < 0)) is not None:
        pose_id, antenna = int(columns.pose_id[row]), int(antennas[row])
        message = f"there is no pose {pose_id} of antenna {antenna} (poses: {poses.pose_ids.size})"
        column = column if pose_id in poses.pose_ids else "pose_id"
        raise defect(READS_FILE, message, column=column, row=row, pose_id=pose_id, antenna=antenna)
    return rows


def _check_monostatic(columns: ReadColumns) -> None:
    rx, tx = columns.antenna, columns.tx_antenna
    if tx is not None and (row := first_row(rx != tx)) is not None:
        message = f"{tx[row]} is not the receiving antenna {rx[row]}, yet the trace is monostatic"
        raise defect(READS_FILE, message, column="tx_antenna", row=row)


def _check_offsets(columns: ReadColumns, meta: TraceMeta) -> None:
    if not meta.channel_offsets_rad:
        return
    known = np.array([freq_hz for freq_hz, _ in meta.channel_offsets_rad])
    if (row := first_row(~np.isin(columns.frequencies_hz, known)[columns.freq_index])) is not None:
        freq_hz = float(columns.frequencies_hz[columns.freq_index[row]])
        message = f"channel_offsets_rad of the trace has no entry for {freq_hz:.17g} Hz"
        raise defect(READS_FILE, message, column="freq_hz", row=row, freq_hz=freq_hz)


def _check_stops(stop_id: IntArray | None, meta: TraceMeta, stops: Stops | None) -> None:
    if stops is None:
        if meta.robot is not None:
            raise defect(STOPS_FILE, f"is missing, yet tags ride on robot {meta.robot}", robot=meta.robot)
        stop_ids = np.empty(0, dtype=np.int64)
    else:
        stop_ids = stops.stop_ids
    if stop_id is None:
        if stop_ids.size > 1:
            raise defect(READS_FILE, f"is missing, yet there are {stop_ids.size} stops", column="stop_id")
        return
    if (row := first_row(~np.isin(stop_id, stop_ids))) is not None:
        unknown = int(stop_id[row])
        message = f"stop {unknown} is unknown (stops: {stop_ids.tolist() or 'no stops.csv'})"
        raise defect(READS_FILE, message, column="stop_id", row=row, stop_id=unknown)
