import pyarrow.dataset as ds
import pyarrow.parquet as pq
import pytest
from toy_study import METRICS, toy_study, toy_trial

from rfcompass.studies import compaction, rows
from rfcompass.studies.compaction import join_small_shards, live_shards, remove_replaced
from rfcompass.studies.rows import RowWriter, read_shards, row_schema, sorted_rows
from rfcompass.studies.trial import run_trial

STUDY = toy_study()
RECORDS = [run_trial("toy", toy_trial, METRICS, cell, seed) for seed in STUDY.seeds for cell in STUDY.cells]


@pytest.fixture
def folder(tmp_path):
    """Sixteen shards of two rows."""
    write(tmp_path, shard_rows=2)
    return tmp_path


def write(folder, **how):
    writer = RowWriter(STUDY, folder, **how)
    for record in RECORDS:
        writer.add(record)
    writer.flush()


def names(folder):
    return sorted(path.name for path in folder.iterdir())


def test_joined_shards_hold_the_same_rows_in_one_file_of_the_same_schema(folder):
    before = sorted_rows(read_shards(folder))
    join_small_shards(folder, many=16)
    (joined,) = folder.iterdir()
    assert pq.read_schema(joined).equals(row_schema(STUDY))
    assert sorted_rows(read_shards(folder)).equals(before)
    assert sorted_rows([ds.dataset(folder).to_table()]).equals(before)


def test_few_shards_stay_as_they_are(folder):
    before = names(folder)
    join_small_shards(folder, many=17)
    assert names(folder) == before


@pytest.mark.parametrize("removed", range(0, 17, 4))
def test_a_kill_while_replaced_shards_are_removed_leaves_every_row_once(folder, monkeypatch, removed):
    """All that a kill can leave behind: the joined shard, and some of those that it replaces."""
    before, left = sorted_rows(read_shards(folder)), removed
    unlink = compaction.Path.unlink

    def killed(path, **how):
        nonlocal left
        if path.suffix == ".parquet":
            left -= 1
            if left < 0:
                raise KeyboardInterrupt
        unlink(path, **how)

    with monkeypatch.context() as patch:
        patch.setattr(compaction.Path, "unlink", killed)
        if removed < 16:
            with pytest.raises(KeyboardInterrupt):
                join_small_shards(folder, many=2)
        else:
            join_small_shards(folder, many=2)
    assert len(names(folder)) == 17 - removed
    assert sorted_rows(read_shards(folder)).equals(before)
    remove_replaced(folder)
    assert len(names(folder)) == 1
    assert sorted_rows(read_shards(folder)).equals(before)


def test_large_shards_are_left_alone_and_none_grows_beyond_its_size(folder, monkeypatch):
    monkeypatch.setattr(compaction, "JOINED_ROWS", 10)
    join_small_shards(folder, many=2)
    assert sorted(shard.rows for shard in live_shards(folder)) == [2, 10, 10, 10]
    before = names(folder)
    join_small_shards(folder, many=2)
    assert names(folder) == before  # three are large, and one alone is not joined


def test_a_damaged_shard_stops_nothing(folder):
    path = sorted(folder.iterdir())[3]
    size = path.stat().st_size
    path.write_bytes(path.read_bytes()[: size // 8] + bytes(size - size // 8))
    join_small_shards(folder, many=2)
    assert len(names(folder)) == 2
    assert path.name in names(folder)


def test_a_writer_joins_its_own_shards_now_and_then(tmp_path, monkeypatch):
    monkeypatch.setattr(rows, "MANY", 4)
    monkeypatch.setattr(rows, "join_small_shards", lambda folder: join_small_shards(folder, many=4))
    write(tmp_path, shard_rows=2)
    assert len(names(tmp_path)) == 1
    assert sorted_rows(read_shards(tmp_path)).num_rows == len(RECORDS)
