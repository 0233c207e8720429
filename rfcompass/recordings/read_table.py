"""`reads.parquet`: the columns of a trace's reads, checked and turned into arrays."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt
import pyarrow as pa
import pyarrow.compute as pc

from rfcompass.arrays import BoolArray, FloatArray, IntArray
from rfcompass.recordings.defects import defect, first_row
from rfcompass.types.reads import TagRead

READS_FILE = "reads.parquet"

# A level beyond ±300 dB is no radio signal; the bound also keeps every amplitude and every sum finite (ours).
LARGEST_LEVEL_DB = 300.0
_LARGEST_AMPLITUDE = 10.0 ** (LARGEST_LEVEL_DB / 20.0)

# Fields of a `TagRead`, in the order of the columns.
_REQUIRED_COLUMNS = {
    "epc": pa.string(), "antenna": pa.int32(), "freq_hz": pa.float64(), "rssi_dbm": pa.float64(),
    "phase_rad": pa.float64(), "pose_id": pa.int64(),
}  # fmt: skip
_OPTIONAL_COLUMNS = {
    "t_ns": pa.int64(), "doppler_hz": pa.float64(), "tx_antenna": pa.int32(), "i": pa.float64(), "q": pa.float64(),
    "t_reader_us": pa.int64(), "channel_index": pa.int32(),
}  # fmt: skip


@dataclass(frozen=True, slots=True)
class ReadColumns:
    """The known columns of `reads.parquet` as arrays, in the order of the file (R reads). Values are checked.

    Power and phase, or i and q, become the channel h = amplitude · exp(-j lag).

    Attributes:
        epcs: Distinct EPCs, sorted (T).
        epc_index: Index of each read's tag in `epcs`, shape (R,).
        antenna: Receiving port, shape (R,).
        frequencies_hz: Distinct carrier frequencies, ascending [Hz], shape (F,).
        freq_index: Index of each read's frequency in `frequencies_hz`, shape (R,).
        pose_id: Number of the antenna pose, shape (R,).
        amplitude: Linear, 10^(rssi_dbm / 20) or |i + jq|, shape (R,).
        lag_rad: phase_sign · phase_rad, or -arg(i + jq) [rad], shape (R,).
        tx_antenna: Transmitting port, shape (R,), or None.
        stop_id: Number of the stop, shape (R,), or None.
    """

    epcs: tuple[str, ...]
    epc_index: IntArray
    antenna: IntArray
    frequencies_hz: FloatArray
    freq_index: IntArray
    pose_id: IntArray
    amplitude: FloatArray
    lag_rad: FloatArray
    tx_antenna: IntArray | None
    stop_id: IntArray | None


def read_columns(table: pa.Table, phase_sign: int) -> ReadColumns:
    """Check the known columns of a table of reads, one by one.

    Columns: epc, antenna, freq_hz, pose_id, and either rssi_dbm with phase_rad, or i with q: the channel h itself,
    in the project's sign convention, preferred if all four are there. Optional are tx_antenna and stop_id, and t_ns,
    doppler_hz, t_reader_us and channel_index, which may hold nulls. Further columns are of no concern.

    Args:
        table: One row for each read (R).
        phase_sign: +1 if the raw phase grows with distance, else -1.

    Raises:
        TraceError: If a column is missing, stands twice or is ill-typed, or a value is not finite or not possible;
            names `column` and `row`.
    """
    _check_names(table)
    epcs, epc_index = _epcs(table)
    frequencies_hz, freq_index = _frequencies(table)
    amplitude, lag_rad = _channel(table, phase_sign)
    for name, check in _CHECKED_WITH_NULLS.items():
        if name in table.column_names:
            check(table, name, nulls=True)
    return ReadColumns(
        epcs=epcs,
        epc_index=epc_index,
        antenna=_integers(table, "antenna"),
        frequencies_hz=frequencies_hz,
        freq_index=freq_index,
        pose_id=_integers(table, "pose_id"),
        amplitude=amplitude,
        lag_rad=lag_rad,
        tx_antenna=_integers(table, "tx_antenna") if "tx_antenna" in table.column_names else None,
        stop_id=_integers(table, "stop_id") if "stop_id" in table.column_names else None,
    )


def reads_table(reads: Iterable[TagRead], stop_ids: Sequence[int] | None = None) -> pa.Table:
    """Put single reads into a table with the columns of `reads.parquet`, in their order.

    Columns that no read has a value for are left out.

    Args:
        reads: What was heard.
        stop_ids: Stop of each read, for a trace with stops.
    """
    rows = tuple(reads)
    columns = {
        name: pa.array([getattr(read, name) for read in rows], kind)
        for name, kind in (_REQUIRED_COLUMNS | _OPTIONAL_COLUMNS).items()
    }
    unused = [name for name in _OPTIONAL_COLUMNS if columns[name].null_count == len(rows)]
    if stop_ids is not None:
        columns["stop_id"] = pa.array(stop_ids, pa.int64())
    return pa.table({name: column for name, column in columns.items() if name not in unused})


def _check_names(table: pa.Table) -> None:
    for name in table.column_names:
        if table.column_names.count(name) > 1:
            raise defect(READS_FILE, "stands twice", column=name)


def _channel(table: pa.Table, phase_sign: int) -> tuple[FloatArray, FloatArray]:
    has_iq = "i" in table.column_names or "q" in table.column_names
    if not has_iq or "rssi_dbm" in table.column_names:
        rssi_dbm = _floats(table, "rssi_dbm")
        _refuse("rssi_dbm", rssi_dbm, np.abs(rssi_dbm) > LARGEST_LEVEL_DB)
    if not has_iq or "phase_rad" in table.column_names:
        phase_rad = _floats(table, "phase_rad")
    if not has_iq:
        return 10.0 ** (rssi_dbm / 20.0), phase_sign * phase_rad
    i, q = _floats(table, "i"), _floats(table, "q")
    for name, values in (("i", i), ("q", q)):
        _refuse(name, values, np.abs(values) > _LARGEST_AMPLITUDE)
    _refuse("i", i, (i == 0) & (q == 0))
    return np.hypot(i, q), -np.arctan2(q, i)


def _refuse(name: str, values: FloatArray, bad: BoolArray) -> None:
    if (row := first_row(bad)) is not None:
        raise defect(READS_FILE, f"{values[row]} is not possible", column=name, row=row)


def _column(table: pa.Table, name: str) -> pa.ChunkedArray:
    if name not in table.column_names:
        raise defect(READS_FILE, f"is missing (found: {', '.join(table.column_names) or 'none'})", column=name)
    column = table.column(name)
    return column.cast(column.type.value_type) if pa.types.is_dictionary(column.type) else column


def _refuse_nulls(column: pa.ChunkedArray, name: str) -> None:
    if column.null_count:
        raise defect(READS_FILE, "is null", column=name, row=first_row(column.is_null().to_numpy()))


def _epcs(table: pa.Table) -> tuple[tuple[str, ...], IntArray]:
    column = _column(table, "epc")
    if not (pa.types.is_string(column.type) or pa.types.is_large_string(column.type)):
        raise defect(READS_FILE, f"holds {column.type}, not text", column="epc")
    _refuse_nulls(column, "epc")
    names, index = _distinct(column)
    if names and not names[0]:
        raise defect(READS_FILE, "is empty", column="epc", row=first_row(index == 0))
    return tuple(names), index


def _frequencies(table: pa.Table) -> tuple[FloatArray, IntArray]:
    freq_hz = _floats(table, "freq_hz")
    _refuse("freq_hz", freq_hz, freq_hz <= 0)
    distinct, index = _distinct(pa.chunked_array([freq_hz]))
    return np.array(distinct, dtype=np.float64), index


def _distinct(column: pa.ChunkedArray) -> tuple[list[Any], IntArray]:
    """Distinct values of a column, ascending, and the index of each row among them."""
    encoded = column.combine_chunks().dictionary_encode()
    values = encoded.dictionary.to_pylist()
    order = sorted(range(len(values)), key=values.__getitem__)
    rank = np.empty(len(values), dtype=np.int64)
    rank[order] = np.arange(len(values))
    return [values[i] for i in order], rank[encoded.indices.to_numpy()]


def _integers(table: pa.Table, name: str, *, nulls: bool = False) -> IntArray:
    column = _column(table, name)
    if not pa.types.is_integer(column.type):
        raise defect(READS_FILE, f"holds {column.type}, not integers", column=name)
    values = _filled(column, name, nulls=nulls)
    if values.dtype == np.uint64 and (row := first_row(values > np.iinfo(np.int64).max)) is not None:
        raise defect(READS_FILE, f"{values[row]} is no 64-bit integer", column=name, row=row)
    return values.astype(np.int64)


def _floats(table: pa.Table, name: str, *, nulls: bool = False) -> FloatArray:
    column = _column(table, name)
    if not (pa.types.is_floating(column.type) or pa.types.is_integer(column.type)):
        raise defect(READS_FILE, f"holds {column.type}, not numbers", column=name)
    values = _filled(column, name, nulls=nulls).astype(np.float64)
    if (row := first_row(~np.isfinite(values))) is not None:
        raise defect(READS_FILE, f"{values[row]} is not finite", column=name, row=row)
    return values


def _filled(column: pa.ChunkedArray, name: str, *, nulls: bool) -> npt.NDArray[Any]:
    """Values of a column, 0 in place of nulls where these are allowed."""
    if not nulls:
        _refuse_nulls(column, name)
    return np.asarray(pc.fill_null(column, 0).to_numpy())


_CHECKED_WITH_NULLS = {"t_ns": _integers, "doppler_hz": _floats, "t_reader_us": _integers, "channel_index": _integers}
