"""What a scan heard, as JSON and back: a reader's own rows, averages over cells, or ready-made proximities.

A bridge to a real reader sends `reads`, with the columns of a trace, one object for each read. A server around what has
averaged already, such as the simulator, sends `channel`. Studies without a radio send `proximity`.
"""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, fields
from typing import Any

import numpy as np
import pyarrow as pa

from rfcompass.arrays import FloatArray
from rfcompass.errors import InputError, RobotFormatError
from rfcompass.recordings.antenna_poses import AntennaPoses
from rfcompass.recordings.read_table import reads_table
from rfcompass.recordings.robot_link.frames import JsonObject, shown
from rfcompass.recordings.robot_link.values import integer, integers, item, number, numbers, text
from rfcompass.recordings.trace import Trace
from rfcompass.recordings.trace_meta import TraceMeta, TraceTag
from rfcompass.types.proximity import ProximityMatrix
from rfcompass.types.reads import ReadTrace, Scan, TagRead
from rfcompass.types.record import Record

_READ_FIELDS = tuple(field.name for field in fields(TagRead))
_META_KEYS = ("frame", "geometry", "phase_sign", "phase_modulus", "dimensions")
_REPORTED = ("rssi_dbm", "phase_rad")


@dataclass(frozen=True, slots=True)
class HeardScan(Record):
    """What a scan heard: reads averaged over cells, or proximities.

    Attributes:
        scan: The averages.
        proximity: Ready-made proximities; None where there are reads.
    """

    scan: Scan
    proximity: ProximityMatrix | None = None


def heard_json(scan: Scan, proximity: ProximityMatrix | None) -> JsonObject:
    """Write a scan that was averaged already."""
    content: JsonObject = {}
    if scan.traces or proximity is None:
        content["channel"] = _channel_json(scan)
    if proximity is not None:
        content["proximity"] = _proximity_json(proximity)
    return content


def reads_json(reads: Sequence[TagRead], poses: AntennaPoses, meta: TraceMeta) -> JsonObject:
    """Write a scan as its reader reported it, one object for each read; what is not reported is left out."""
    rows = [{name: value for name in _READ_FIELDS if (value := getattr(read, name)) is not None} for read in reads]
    ids = zip(poses.pose_ids.tolist(), poses.antennas.tolist(), poses.positions_m.tolist(), strict=True)
    placed = [{"pose_id": pose, "antenna": antenna, "position_m": at_m} for pose, antenna, at_m in ids]
    return {"reads": {**{key: getattr(meta, key) for key in _META_KEYS}, "rows": rows, "antenna_poses": placed}}


def heard_of(content: object, epcs: Collection[str]) -> HeardScan:
    """Read what a scan heard.

    Args:
        content: The object `heard`.
        epcs: Tags that matter; reads of others are strays and left out.

    Raises:
        RobotFormatError: If something is missing, of the wrong kind, or not possible.
    """
    if not isinstance(content, Mapping) or not set(content) & {"reads", "channel", "proximity"}:
        raise RobotFormatError("heard: neither reads, nor channel, nor proximity", key="heard")
    if "reads" in content and "channel" in content:
        raise RobotFormatError("heard: reads and their averages together", key="heard")
    matrix = content.get("proximity")
    try:
        return HeardScan(_scan_of(content, epcs), None if matrix is None else _proximity_of(matrix))
    except RobotFormatError:
        raise
    except InputError as cause:
        raise RobotFormatError(f"heard: {cause.message}", **{**cause.numbers, "key": "heard"}) from cause


def _scan_of(content: Mapping[str, Any], epcs: Collection[str]) -> Scan:
    if "reads" in content:
        return _averaged(content["reads"], epcs)
    return _channel_of(content["channel"]) if "channel" in content else Scan()


def _averaged(content: object, epcs: Collection[str]) -> Scan:
    """Average the rows as those of a trace, with all of a trace's checks."""
    tags = tuple(TraceTag(epc) for epc in sorted(epcs))
    meta = TraceMeta(**{key: item(content, key) for key in _META_KEYS}, tags=tags)
    rows, placed = item(content, "rows"), item(content, "antenna_poses")
    if not isinstance(rows, list) or not isinstance(placed, list):
        raise RobotFormatError("reads: rows or antenna_poses is no list", key="rows")
    poses = AntennaPoses(
        pose_ids=np.array([integer(item(row, "pose_id"), "pose_id") for row in placed], dtype=np.int64),
        antennas=np.array([integer(item(row, "antenna"), "antenna") for row in placed], dtype=np.int64),
        positions_m=numbers([item(row, "position_m") for row in placed], "position_m", (len(placed), 3)),
        quaternions_xyzw=np.tile([0.0, 0.0, 0.0, 1.0], (len(placed), 1)),
    )
    try:
        table = reads_table([_read_of(row) for row in rows])
    except (pa.ArrowException, TypeError, OverflowError) as cause:
        raise RobotFormatError(f"reads: {cause}", key="rows") from cause
    if "i" in table.column_names:  # whoever reports the channel itself need not report power and phase as well
        table = table.drop([name for name in _REPORTED if table.column(name).null_count])
    return Trace(meta, table, poses).scan()


def _read_of(row: object) -> TagRead:
    if not isinstance(row, Mapping):
        raise RobotFormatError(f"reads: {shown(row)} is no object", key="rows")
    if unknown := sorted(set(row) - set(_READ_FIELDS)):
        raise RobotFormatError(f"reads: column {shown(unknown[0])} is unknown", key=unknown[0])
    required = {name: item(row, name) for name in ("epc", "antenna", "freq_hz")}
    return TagRead(**{**dict.fromkeys(_REPORTED), **required, **row})


def _channel_json(scan: Scan) -> JsonObject:
    tags = [_tag_json(scan.traces[epc]) for epc in scan.traces]
    heights_m = dict(scan.heights_m)
    return {"frame": scan.frame, "dimensions": scan.dimensions, "heights_m": heights_m, "tags": tags}


def _tag_json(trace: ReadTrace) -> JsonObject:
    return {
        "epc": trace.epc,
        "antenna_positions_m": trace.antenna_positions_m.tolist(),
        "antenna_ports": trace.antenna_ports.tolist(),
        "tx_positions_m": None if trace.tx_positions_m is None else trace.tx_positions_m.tolist(),
        "frequencies_hz": trace.frequencies_hz.tolist(),
        "i": trace.channel.real.tolist(),
        "q": trace.channel.imag.tolist(),
        "read_counts": trace.read_counts.tolist(),
        "phase_modulus_rad": trace.phase_modulus_rad,
    }


def _channel_of(content: object) -> Scan:
    tags, heights_m = item(content, "tags"), item(content, "heights_m")
    if not isinstance(tags, list) or not isinstance(heights_m, Mapping):
        raise RobotFormatError("channel: tags is no list, or heights_m no object", key="channel")
    traces = [_tag_of(tag) for tag in tags]
    if len(traces) > len({trace.epc for trace in traces}):
        raise RobotFormatError("channel: an EPC stands twice", key="epc")
    return Scan(
        traces={trace.epc: trace for trace in traces},
        frame=text(content, "frame"),
        dimensions=integer(item(content, "dimensions"), "dimensions"),
        heights_m={epc: number(height_m, "heights_m") for epc, height_m in heights_m.items()},
    )


def _tag_of(content: object) -> ReadTrace:
    frequencies_hz = numbers(item(content, "frequencies_hz"), "frequencies_hz", (None,))
    positions_m = numbers(item(content, "antenna_positions_m"), "antenna_positions_m", (None, 3))
    M, F = len(positions_m), len(frequencies_hz)
    tx_m = item(content, "tx_positions_m")
    channel = np.empty((M, F), dtype=np.complex128)
    channel.real, channel.imag = (numbers(item(content, key), key, (M, F)) for key in ("i", "q"))
    return ReadTrace(
        epc=text(content, "epc"),
        antenna_positions_m=positions_m,
        frequencies_hz=frequencies_hz,
        channel=channel,
        read_counts=integers(item(content, "read_counts"), "read_counts", (M, F)),
        antenna_ports=integers(item(content, "antenna_ports"), "antenna_ports", (M,)),
        tx_positions_m=None if tx_m is None else numbers(tx_m, "tx_positions_m", (M, 3)),
        phase_modulus_rad=number(item(content, "phase_modulus_rad"), "phase_modulus_rad"),
    )


def _proximity_json(matrix: ProximityMatrix) -> JsonObject:
    errors = matrix.standard_errors
    return {
        "kind": matrix.kind,
        "target_epcs": list(matrix.target_epcs),
        "anchor_epcs": list(matrix.anchor_epcs),
        "m": _with_null(matrix.m),
        "anchor_m": _with_null(matrix.anchor_m),
        "standard_errors": None if errors is None else _with_null(errors),
    }


def _with_null(values: FloatArray) -> list[list[float | None]]:
    return [[None if np.isnan(value) else value for value in row] for row in values.tolist()]


def _proximity_of(content: object) -> ProximityMatrix:
    targets, anchors = _names(content, "target_epcs"), _names(content, "anchor_epcs")
    K, N = len(targets), len(anchors)
    errors = item(content, "standard_errors")
    return ProximityMatrix(
        target_epcs=targets,
        anchor_epcs=anchors,
        m=_with_nan(item(content, "m"), "m", (K, N)),
        anchor_m=_with_nan(item(content, "anchor_m"), "anchor_m", (N, N)),
        kind=text(content, "kind"),
        standard_errors=None if errors is None else _with_nan(errors, "standard_errors", (K, N)),
    )


def _names(content: object, key: str) -> tuple[str, ...]:
    listed = item(content, key)
    if not isinstance(listed, list) or not all(isinstance(name, str) for name in listed):
        raise RobotFormatError(f"{key}: no list of names", key=key)
    return tuple(listed)


def _with_nan(value: object, key: str, shape: tuple[int, int]) -> FloatArray:
    if not isinstance(value, list) or not all(isinstance(row, list) for row in value):
        raise RobotFormatError(f"{key}: no list of lists", key=key)
    missing = [[entry is None for entry in row] for row in value]
    filled = numbers([[0.0 if entry is None else entry for entry in row] for row in value], key, shape)
    return np.where(np.array(missing, dtype=bool).reshape(shape), np.nan, filled)
