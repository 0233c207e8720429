import numpy as np
import pyarrow as pa
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rfcompass.errors import TraceError
from rfcompass.recordings.stored_proximity import parse_proximity, proximity_table
from rfcompass.types import ProximityMatrix


def _matrix(K: int = 2, N: int = 3, *, seed: int = 0, errors: bool = True) -> ProximityMatrix:
    rng = np.random.default_rng(seed)
    m, half = rng.uniform(0.0, 2.0, (K, N)), rng.uniform(0.0, 1.0, (N, N))
    m[rng.random((K, N)) < 0.2] = np.nan
    anchor_m = half + half.T
    np.fill_diagonal(anchor_m, np.nan)
    standard_errors = rng.uniform(0.0, 0.1, (K, N)) if errors else None
    targets, anchors = rng.permutation(K), rng.permutation(N)
    return ProximityMatrix(
        tuple(f"T{k}" for k in targets), tuple(f"A{i}" for i in anchors), m, anchor_m, "noisy_distance", standard_errors
    )  # fmt: skip


def _same(one: ProximityMatrix, other: ProximityMatrix) -> bool:
    names = (one.target_epcs, one.anchor_epcs, one.kind) == (other.target_epcs, other.anchor_epcs, other.kind)
    arrays = [(one.m, other.m), (one.anchor_m, other.anchor_m)]
    if one.standard_errors is not None and other.standard_errors is not None:
        arrays.append((one.standard_errors, other.standard_errors))
    without = (one.standard_errors is None) == (other.standard_errors is None)
    return names and without and all(np.array_equal(a, b, equal_nan=True) for a, b in arrays)


@given(K=st.integers(0, 3), N=st.integers(1, 4), seed=st.integers(0, 99), errors=st.booleans())
def test_what_is_stored_comes_back_to_the_last_bit(K, N, seed, errors):
    matrices = {7: _matrix(K, N, seed=seed, errors=errors and K > 0), 2: _matrix(K, N, seed=seed + 1, errors=False)}
    again = parse_proximity(proximity_table(matrices))
    assert sorted(again) == [2, 7]
    assert all(_same(again[stop_id], matrices[stop_id]) for stop_id in matrices)


@pytest.mark.parametrize("name", ["stop_id", "kind", "block", "epc", "anchor_epc", "m"])
def test_a_missing_column_is_named(name):
    with pytest.raises(TraceError) as caught:
        parse_proximity(proximity_table({0: _matrix()}).drop([name]))
    assert (caught.value.numbers["file"], caught.value.numbers["column"]) == ("proximity.parquet", name)


@pytest.mark.parametrize(
    ("column", "row", "value"),
    [("block", 1, "other"), ("kind", 1, "oracle"), ("epc", 1, "T9"), ("m", 2, -1.0), ("m", 2, float("inf"))],
)
def test_a_defect_in_a_row_is_an_error(column, row, value):
    table = proximity_table({0: _matrix(errors=False)})
    cells = table[column].to_pylist()
    cells[row] = value
    broken = table.set_column(table.column_names.index(column), column, pa.array(cells, table[column].type))
    with pytest.raises(TraceError) as caught:
        parse_proximity(broken)
    assert caught.value.numbers["file"] == "proximity.parquet"


@pytest.mark.parametrize(
    ("column", "cells"),
    [("m", ["1"]), ("stop_id", [0.5]), ("epc", [b"A"]), ("m", pa.array([None], pa.float64()))],
)
def test_an_ill_typed_column_is_named(column, cells):
    table = proximity_table({0: _matrix(0, 1)})
    broken = table.set_column(table.column_names.index(column), column, pa.array(cells))
    with pytest.raises(TraceError) as caught:
        parse_proximity(broken)
    assert caught.value.numbers["column"] == column


def test_a_column_given_twice_is_named():
    table = proximity_table({0: _matrix()})
    with pytest.raises(TraceError, match="twice"):
        parse_proximity(table.append_column("m", table["m"]))


def test_a_target_paired_with_an_unknown_anchor_is_an_error():
    table = proximity_table({0: _matrix(1, 1, errors=False)})
    stranger = table.slice(0, 1).set_column(table.column_names.index("anchor_epc"), "anchor_epc", pa.array(["A9"]))
    with pytest.raises(TraceError, match="unknown anchors"):
        parse_proximity(pa.concat_tables([table, stranger]))


def test_a_pair_that_is_missing_or_stands_twice_is_an_error():
    table = proximity_table({0: _matrix()})
    for broken in (table.slice(1), pa.concat_tables([table, table.slice(0, 1)])):
        with pytest.raises(TraceError):
            parse_proximity(broken)
