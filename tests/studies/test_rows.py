import numpy as np
import pyarrow as pa
import pyarrow.dataset as ds
import pyarrow.parquet as pq
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from toy_study import METRICS, toy_study, toy_trial

from rfcompass.errors import StudyError
from rfcompass.studies.metric import Metric
from rfcompass.studies.rows import (
    RowWriter,
    finished_trials,
    read_shards,
    row_schema,
    set_aside_partial_shards,
    sorted_rows,
    stable_columns,
)
from rfcompass.studies.trial import run_trial

STUDY = toy_study()
RECORDS = [run_trial("toy", toy_trial, METRICS, cell, seed) for seed in STUDY.seeds for cell in STUDY.cells]


def write(folder, records, **how):
    writer = RowWriter(STUDY, folder, **how)
    for record in records:
        writer.add(record)
    writer.flush()


@settings(max_examples=15)
@given(st.permutations(RECORDS), st.integers(1, 40))
def test_rows_do_not_depend_on_order_and_shard_size(tmp_path_factory, records, shard_rows):
    expected, found = tmp_path_factory.mktemp("expected"), tmp_path_factory.mktemp("found")
    write(expected, RECORDS)
    write(found, records, shard_rows=shard_rows)
    assert len(list(found.iterdir())) == -(-len(records) // shard_rows)
    tables = [sorted_rows(read_shards(folder)) for folder in (expected, found)]
    assert tables[0].equals(tables[1])


def test_a_row_holds_what_the_trial_returned(tmp_path):
    write(tmp_path, RECORDS)
    rows = sorted_rows(read_shards(tmp_path)).to_pylist()
    assert len(rows) == len(RECORDS)
    for record in RECORDS:
        row = next(r for r in rows if r["seed"] == record.seed and all(r[k] == v for k, v in record.cell.items()))
        assert row["failure_kind"] == (record.failure.kind if record.failure else None)
        for metric in METRICS:
            value = record.metrics.get(metric.name)
            assert row[metric.name] == (list(value) if isinstance(value, tuple) else value)


def test_all_shards_have_the_declared_schema_and_read_as_one_table(tmp_path):
    failed = [record for record in RECORDS if record.failure]
    write(tmp_path, failed)  # a shard in which every metric is missing
    write(tmp_path, [record for record in RECORDS if not record.failure], shard_rows=5)
    (tmp_path / ".rows-killed.parquet.tmp").write_bytes(b"PAR1")
    for path in tmp_path.glob("*.parquet"):
        assert pq.read_schema(path).equals(row_schema(STUDY))
    assert ds.dataset(tmp_path).to_table().num_rows == len(RECORDS)


def test_factors_keep_their_type():
    factors = {"a": (1, 2), "b": (1, 2.5), "c": (None, 3), "d": (True, False), "e": ("x",)}
    schema = row_schema(toy_study(factors=factors, paper=()))
    types = [schema.field(name).type for name in factors]
    assert types == [pa.int64(), pa.float64(), pa.int64(), pa.bool_(), pa.string()]


def test_numbers_come_back_to_the_last_bit(tmp_path):
    study = toy_study(factors={"a": (1,)}, metrics=(Metric("x"),), paper=())
    value = float(np.nextafter(0.1, 1.0))
    writer = RowWriter(study, tmp_path)
    writer.add(run_trial("toy", lambda cell, seed, rng: {"x": value}, study.metrics, {"a": 1}, 0))
    writer.flush()
    assert next(read_shards(tmp_path)).column("x")[0].as_py().hex() == value.hex()


def test_old_rows_go_to_the_disk_although_they_are_few(tmp_path):
    writer = RowWriter(STUDY, tmp_path, shard_seconds=0.0)
    writer.add(RECORDS[0])
    assert len(list(tmp_path.iterdir())) == 1


def test_finished_trials_are_those_with_a_row(tmp_path):
    write(tmp_path, RECORDS[5:17], shard_rows=5)
    finished = finished_trials(STUDY, STUDY.seeds, tmp_path)
    assert np.flatnonzero(finished.ravel()).tolist() == list(range(5, 17))
    backwards = finished_trials(STUDY, (7, 3, 2), tmp_path)
    assert backwards.tolist() == finished[[7, 3, 2]].tolist()


def test_a_partial_shard_counts_as_not_there(tmp_path):
    write(tmp_path, RECORDS, shard_rows=8)
    broken = sorted(tmp_path.iterdir())[1]
    broken.write_bytes(broken.read_bytes()[:-7])
    assert finished_trials(STUDY, STUDY.seeds, tmp_path).sum() == len(RECORDS) - 8
    assert sum(table.num_rows for table in read_shards(tmp_path)) == len(RECORDS) - 8
    set_aside_partial_shards(tmp_path)
    assert ds.dataset(tmp_path).to_table().num_rows == len(RECORDS) - 8


def test_a_trial_with_two_rows_is_noticed(tmp_path):
    write(tmp_path, [*RECORDS, RECORDS[6]])
    with pytest.raises(StudyError, match="1 trials stand twice") as caught:
        sorted_rows(read_shards(tmp_path))
    assert caught.value.numbers["seed"] == RECORDS[6].seed


def test_stable_columns_leave_out_time_and_versions_only():
    table = row_schema(STUDY).empty_table()
    assert set(table.column_names) - set(stable_columns(table).column_names) == {"runtime_s", "versions"}
