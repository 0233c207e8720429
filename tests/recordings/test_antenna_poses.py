import pickle

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rfcompass.errors import TraceError
from rfcompass.recordings import AntennaPoses
from rfcompass.recordings.antenna_poses import parse_poses, poses_csv
from rfcompass.recordings.text_table import read_text_table

keys = st.lists(st.tuples(st.integers(-3, 8), st.integers(0, 3)), unique=True)


def _poses(pairs, seed=0, **unknown) -> AntennaPoses:
    rng = np.random.default_rng(seed)
    pose_ids, antennas = np.array(pairs, dtype=np.int64).reshape(-1, 2).T
    P = len(pairs)
    return AntennaPoses(pose_ids, antennas, rng.normal(size=(P, 3)), rng.normal(size=(P, 4)), unknown)


@given(pairs=keys, asked=st.lists(st.tuples(st.integers(-5, 10), st.integers(-1, 5))))
def test_rows_are_found_as_a_dictionary_finds_them(pairs, asked):
    poses = _poses(pairs)
    row_of = {(int(p), int(a)): row for row, (p, a) in enumerate(zip(poses.pose_ids, poses.antennas, strict=True))}
    pose_ids, antennas = np.array(asked, dtype=np.int64).reshape(-1, 2).T
    assert poses.rows_of(pose_ids, antennas).tolist() == [row_of.get(pair, -1) for pair in asked]


@given(pairs=keys.filter(bool), data=st.data())
def test_the_order_of_the_rows_does_not_matter(pairs, data):
    poses = _poses(pairs, note=[str(pair) for pair in pairs])
    order = np.array(data.draw(st.permutations(range(len(pairs)))))
    shuffled = AntennaPoses(
        poses.pose_ids[order], poses.antennas[order], poses.positions_m[order], poses.quaternions_xyzw[order],
        {"note": [poses.unknown["note"][i] for i in order]},
    )  # fmt: skip
    assert poses_csv(shuffled) == poses_csv(poses)
    assert sorted(pairs) == list(zip(poses.pose_ids.tolist(), poses.antennas.tolist(), strict=True))
    assert poses.unknown["note"] == tuple(str(pair) for pair in sorted(pairs))


@given(pairs=keys, seed=st.integers(0, 99))
def test_what_is_written_reads_back_to_the_last_bit(tmp_path_factory, pairs, seed):
    poses = _poses(pairs, seed, note=["x"] * len(pairs))
    file = tmp_path_factory.mktemp("poses") / "antenna_poses.csv"
    file.write_bytes(poses_csv(poses))
    again = parse_poses(read_text_table(file))
    assert again.positions_m.tobytes() == poses.positions_m.tobytes()
    assert again.quaternions_xyzw.tobytes() == poses.quaternions_xyzw.tobytes()
    assert poses_csv(again) == poses_csv(poses)


def test_a_pose_given_twice_is_named_by_its_later_row():
    with pytest.raises(TraceError) as caught:
        _poses([(2, 1), (1, 1), (1, 2), (1, 1)])
    assert {key: caught.value.numbers[key] for key in ("row", "pose_id", "antenna")} == {
        "row": 3, "pose_id": 1, "antenna": 1,
    }  # fmt: skip


def test_a_zero_quaternion_is_named_by_its_row():
    quaternions = np.array([[0.0, 0.0, 0.0, 1.0], [0.0, 0.0, 0.0, 0.0]])
    with pytest.raises(TraceError) as caught:
        AntennaPoses(np.array([5, 3]), np.array([1, 1]), np.zeros((2, 3)), quaternions)
    assert caught.value.numbers["row"] == 1


def test_a_position_that_is_not_finite_is_an_error():
    with pytest.raises(TraceError, match="not finite"):
        AntennaPoses(np.array([0]), np.array([1]), np.array([[0.0, np.nan, 0.0]]), np.array([[0.0, 0.0, 0.0, 1.0]]))


def test_a_record_survives_the_trip_between_processes_and_stays_frozen():
    again = pickle.loads(pickle.dumps(_poses([(0, 1), (1, 1)], note=["a", "b"])))
    assert again.unknown == {"note": ("a", "b")}
    with pytest.raises(ValueError, match="read-only"):
        again.positions_m[0, 0] = 1.0
