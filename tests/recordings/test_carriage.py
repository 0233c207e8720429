"""Where the antennas were: still ones, and ones on a carrier with a log."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rfcompass.errors import TraceError
from rfcompass.recordings import AntennaPoses, CarrierLog, StillAntennas
from rfcompass.recordings.carriage import POSE_SPACING_M

HEADER = "t_ns,antenna,x_m,y_m,z_m"
T0_NS = 1_700_000_000_000_000_000  # a float64 resolves 256 ns here


def log(tmp_path, rows, header=HEADER):
    path = tmp_path / "carrier.csv"
    path.write_text("\n".join([header, *rows]) + "\n")
    return CarrierLog.read(path)


def ids(carriage, times_ns, antenna=1):
    times_ns = np.asarray(times_ns, dtype=np.int64)
    return carriage.pose_ids(np.full(times_ns.shape, antenna), times_ns, np.ones(times_ns.shape, dtype=bool))


def test_antennas_that_nobody_placed_stand_at_the_origin():
    poses = StillAntennas().poses([(0, 1), (0, 3)])
    assert poses.antennas.tolist() == [1, 3]
    assert not poses.positions_m.any()


def test_still_antennas_stand_where_the_file_says(tmp_path):
    path = tmp_path / "poses.csv"
    path.write_text("pose_id,antenna,x_m,y_m,z_m,qx,qy,qz,qw\n5,2,1,2,3,0,0,1,0\n")
    still = StillAntennas.read(path)
    poses = still.poses([(0, 2)])
    assert poses.positions_m.tolist() == [[1, 2, 3]]
    assert poses.quaternions_xyzw.tolist() == [[0, 0, 1, 0]]
    assert still.pose_ids(np.array([2, 2]), np.zeros(2, dtype=np.int64), np.zeros(2, dtype=bool)).tolist() == [0, 0]


def test_a_port_without_a_place_has_none_once_another_has_one():
    still = StillAntennas({2: np.array([0.0, 0.0, 1.0])})
    ports = np.array([1, 2, 3, 2])
    assert still.pose_ids(ports, np.zeros(4, dtype=np.int64), np.zeros(4, dtype=bool)).tolist() == [-1, 0, -1, 0]
    assert StillAntennas().pose_ids(ports, np.zeros(4, dtype=np.int64), np.zeros(4, dtype=bool)).tolist() == [0] * 4


def test_a_file_of_still_antennas_without_a_row_is_refused_rather_than_taken_for_the_origin(tmp_path):
    (tmp_path / "poses.csv").write_text("pose_id,antenna,x_m,y_m,z_m,qx,qy,qz,qw\n")
    with pytest.raises(TraceError):
        StillAntennas.read(tmp_path / "poses.csv")


def test_two_poses_of_one_still_antenna_are_refused():
    with pytest.raises(TraceError) as caught:
        StillAntennas.of(AntennaPoses.along(np.zeros((2, 3))))
    assert caught.value.numbers["poses"] == 2


@given(share=st.floats(0.0, 1.0))
def test_the_pose_of_a_read_is_within_half_a_spacing_of_the_interpolated_place(tmp_path_factory, share):
    carrier = log(tmp_path_factory.mktemp("c"), [f"{T0_NS},1,0,0,1", f"{T0_NS + 10**9},1,0.3,0.4,1"])
    t_ns = T0_NS + int(share * 10**9)
    (pose_id,) = ids(carrier, [t_ns])
    (place_m,) = carrier.poses([(int(pose_id), 1)]).positions_m
    # The clock of the log is resolved to 1 ns at 0.5 m/s; the last pose may lie half a spacing before the end.
    assert np.linalg.norm(place_m - share * np.array([0.3, 0.4, 0.0]) - [0, 0, 1]) <= POSE_SPACING_M / 2 + 1e-8


def test_reads_outside_the_log_without_a_time_or_of_another_port_have_no_place(tmp_path):
    carrier = log(tmp_path, [f"{T0_NS},1,0,0,0", f"{T0_NS + 1000},1,1,0,0"])
    assert ids(carrier, [T0_NS - 1, T0_NS, T0_NS + 1000, T0_NS + 1001]).tolist() == [-1, 0, 200, -1]
    assert ids(carrier, [T0_NS], antenna=2).tolist() == [-1]
    unknown = carrier.pose_ids(np.array([1]), np.array([T0_NS]), np.array([False]))
    assert unknown.tolist() == [-1]


def test_a_carrier_that_stands_still_gives_one_pose(tmp_path):
    rows = [f"{T0_NS + 1000 * k},1,{0.1 if k > 2 else 0.0},0,0" for k in range(10)]
    carrier = log(tmp_path, rows)
    assert set(ids(carrier, T0_NS + np.arange(3000, 9001, 500)).tolist()) == {20}
    assert set(ids(carrier, T0_NS + np.arange(0, 2001, 500)).tolist()) == {0}


def test_each_port_has_its_own_path_and_orientation(tmp_path):
    rows = [f"{T0_NS + t},{port},{port},0,{t},0,0,0,{port}" for t in (0, 1) for port in (1, 2)]
    carrier = log(tmp_path, rows, f"{HEADER},qx,qy,qz,qw")
    poses = carrier.poses([(0, 1), (0, 2), (200, 2)])
    assert poses.positions_m.tolist() == [[1, 0, 0], [2, 0, 0], [2, 0, 1]]
    assert poses.quaternions_xyzw[:, 3].tolist() == [1, 2, 2]


@pytest.mark.parametrize(
    ("rows", "column", "row"),
    [
        (["5,1,0,0,0", "7,2,0,0,0", "5,1,1,0,0"], "t_ns", 2),
        (["5,1,0,0,0", "4,1,1,0,0"], "t_ns", 1),
        (["5,1,0,0,nan"], "z_m", 0),
        (["5.5,1,0,0,0"], "t_ns", 0),
        ([], None, None),
    ],
)
def test_a_bad_log_is_a_typed_error_that_says_where(tmp_path, rows, column, row):
    with pytest.raises(TraceError) as caught:
        log(tmp_path, rows)
    assert (caught.value.numbers.get("column"), caught.value.numbers.get("row")) == (column, row)
