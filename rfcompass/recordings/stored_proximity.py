"""`proximity.parquet`: ready-made proximity matrices, for instance of a study whose meter needs the truth.

One row for each pair: stop_id, kind, block (`target` for m[k, i], `anchor` for the anchor-anchor block), epc (row of
the matrix), anchor_epc (its column), m (NaN where missing) and, where there are any, standard_error (also NaN).
The order of the rows gives the order of the tags. Traces without stops use stop 0.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
import pyarrow as pa

from rfcompass.arrays import FloatArray
from rfcompass.errors import InputError
from rfcompass.recordings.defects import defect
from rfcompass.types.proximity import ProximityMatrix

PROXIMITY_FILE = "proximity.parquet"

_TYPES = {
    "stop_id": (pa.int64(),),
    "kind": (pa.string(), pa.large_string()),
    "block": (pa.string(), pa.large_string()),
    "epc": (pa.string(), pa.large_string()),
    "anchor_epc": (pa.string(), pa.large_string()),
    "m": (pa.float64(),),
    "standard_error": (pa.float64(),),
}


def proximity_table(matrices: Mapping[int, ProximityMatrix]) -> pa.Table:
    """Put the matrices of all stops into one table; equal matrices give equal tables."""
    rows = [row for stop_id in sorted(matrices) for row in _rows(stop_id, matrices[stop_id])]
    columns = zip(*rows, strict=True) if rows else ((),) * len(_TYPES)
    table = pa.table({
        name: pa.array(cells, kinds[0]) for (name, kinds), cells in zip(_TYPES.items(), columns, strict=True)
    })  # fmt: skip
    return table if any(m.standard_errors is not None for m in matrices.values()) else table.drop(["standard_error"])


def _rows(stop_id: int, matrix: ProximityMatrix) -> list[tuple[object, ...]]:
    errors = matrix.standard_errors
    targets: list[tuple[object, ...]] = [
        (stop_id, matrix.kind, "target", epc, anchor, float(matrix.m[k, i]), None if errors is None else errors[k, i])
        for k, epc in enumerate(matrix.target_epcs)
        for i, anchor in enumerate(matrix.anchor_epcs)
    ]
    anchors: list[tuple[object, ...]] = [
        (stop_id, matrix.kind, "anchor", epc, anchor, float(matrix.anchor_m[j, i]), None)
        for j, epc in enumerate(matrix.anchor_epcs)
        for i, anchor in enumerate(matrix.anchor_epcs)
    ]
    return targets + anchors


def parse_proximity(table: pa.Table) -> dict[int, ProximityMatrix]:
    """Read the matrices of all stops from a table.

    Raises:
        TraceError: If a column is missing or ill-typed, a pair is missing or given twice, or a value is not possible.
    """
    _check_types(table)
    drafts: dict[int, _Draft] = {}
    for row, pair in enumerate(table.to_pylist()):
        drafts.setdefault(pair["stop_id"], _Draft(pair["kind"])).add(pair, row)
    return {stop_id: draft.matrix(stop_id) for stop_id, draft in drafts.items()}


def _check_types(table: pa.Table) -> None:
    for name, kinds in _TYPES.items():
        if name not in table.column_names and name != "standard_error":
            raise defect(PROXIMITY_FILE, f"is missing (found: {', '.join(table.column_names)})", column=name)
        if table.column_names.count(name) > 1:
            raise defect(PROXIMITY_FILE, "stands twice", column=name)
        if name not in table.column_names:
            continue
        if table.column(name).type not in kinds:
            raise defect(PROXIMITY_FILE, f"holds {table.column(name).type}, not {kinds[0]}", column=name)
        if table.column(name).null_count and name != "standard_error":
            row = int(np.argmax(table.column(name).is_null().to_numpy()))
            raise defect(PROXIMITY_FILE, "is null", column=name, row=row)


@dataclass
class _Draft:
    """The pairs of one stop, collected row by row."""

    kind: str
    blocks: dict[str, dict[tuple[str, str], float]] = field(default_factory=lambda: {"target": {}, "anchor": {}})
    errors: dict[tuple[str, str], float] = field(default_factory=dict)

    def add(self, pair: Mapping[str, object], row: int) -> None:
        """Take one row in."""
        place = (str(pair["epc"]), str(pair["anchor_epc"]))
        if pair["block"] not in self.blocks:
            raise defect(PROXIMITY_FILE, f"{pair['block']!r} is neither target nor anchor", column="block", row=row)
        if pair["kind"] != self.kind:
            raise defect(PROXIMITY_FILE, f"{pair['kind']!r} and {self.kind!r} at one stop", column="kind", row=row)
        block = self.blocks[str(pair["block"])]
        if place in block:
            raise defect(PROXIMITY_FILE, f"pair {place} stands twice", column="epc", row=row)
        block[place] = _number(pair["m"])
        if pair["block"] == "target" and pair.get("standard_error") is not None:
            self.errors[place] = _number(pair["standard_error"])

    def matrix(self, stop_id: int) -> ProximityMatrix:
        """Build the matrix once all rows are in."""
        target, anchor = self.blocks["target"], self.blocks["anchor"]
        targets, anchors = tuple(dict.fromkeys(a for a, _ in target)), tuple(dict.fromkeys(a for a, _ in anchor))
        try:
            return ProximityMatrix(
                target_epcs=targets,
                anchor_epcs=anchors,
                m=_filled(target, targets, anchors),
                anchor_m=_filled(anchor, anchors, anchors),
                kind=self.kind,
                standard_errors=_filled(self.errors, targets, anchors) if self.errors else None,
            )
        except KeyError as cause:
            raise defect(PROXIMITY_FILE, f"stop {stop_id}: pair {cause} is missing", stop_id=stop_id) from cause
        except InputError as cause:
            raise defect(PROXIMITY_FILE, f"stop {stop_id}: {cause.message}", stop_id=stop_id) from cause


def _number(value: object) -> float:
    return float(value) if isinstance(value, float) else float("nan")


def _filled(pairs: Mapping[tuple[str, str], float], rows: tuple[str, ...], columns: tuple[str, ...]) -> FloatArray:
    if len(pairs) > len(rows) * len(columns):
        raise InputError("there are pairs with unknown anchors")
    return np.array([[pairs[row, column] for column in columns] for row in rows]).reshape(len(rows), len(columns))
