import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rfcompass.errors import TraceError
from rfcompass.recordings import Stops
from rfcompass.recordings.stops import parse_stops, stops_csv
from rfcompass.recordings.text_table import read_text_table


def _stops(S=3, joints=("arm_joint_1", "arm_joint_2"), *, seed=0, covariances=True) -> Stops:
    rng = np.random.default_rng(seed)
    roots = rng.normal(size=(S, 3, 3))
    squares = roots @ roots.transpose(0, 2, 1)
    return Stops(
        stop_ids=rng.permutation(S),
        base_poses=rng.normal(size=(S, 3)),
        joint_names=joints,
        joints=rng.normal(size=(S, len(joints))),
        covariances=(squares + squares.transpose(0, 2, 1)) / 2 if covariances else None,
    )


def _read(tmp_path, content: bytes) -> Stops:
    (tmp_path / "stops.csv").write_bytes(content)
    return parse_stops(read_text_table(tmp_path / "stops.csv"))


@given(
    S=st.integers(0, 4), joints=st.lists(st.text("abc", min_size=1), unique=True), covariances=st.booleans(),
    seed=st.integers(0, 9),
)  # fmt: skip
def test_what_is_written_reads_back_to_the_last_bit(tmp_path_factory, S, joints, covariances, seed):
    stops = _stops(S, tuple(joints), seed=seed, covariances=covariances)
    again = _read(tmp_path_factory.mktemp("stops"), stops_csv(stops))
    assert again.joint_names == stops.joint_names
    for name in ("stop_ids", "base_poses", "joints"):
        assert getattr(again, name).tobytes() == getattr(stops, name).tobytes()
    assert (again.covariances is None) == (not covariances)
    if again.covariances is not None and stops.covariances is not None:
        assert again.covariances.tobytes() == stops.covariances.tobytes()


HEADER = "stop_id,base_x_m,base_y_m,base_theta_rad"


@pytest.mark.parametrize(
    ("content", "column", "row"),
    [
        ("stop_id,base_x_m,base_y_m\n0,0,0\n", "base_theta_rad", None),
        (f"{HEADER}\n0,0,0,0\n0,1,0,0\n", "stop_id", 1),
        (f"{HEADER}\n0,0,0,nan\n", "base_theta_rad", 0),
        (f"{HEADER},arm_joint_1\n0,0,0,0,0\n1,0,0,0,up\n", "arm_joint_1", 1),
        (f"{HEADER},cov_xx\n0,0,0,0,1\n", "cov_xy", None),
        (f"{HEADER},cov_xx,cov_xy,cov_xt,cov_yy,cov_yt,cov_tt\n0,0,0,0,1,2,0,1,0,1\n", "cov_xx", 0),
    ],
)
def test_a_defect_is_named_by_column_and_row(tmp_path, content, column, row):
    with pytest.raises(TraceError) as caught:
        _read(tmp_path, content.encode())
    assert caught.value.numbers["column"] == column
    assert caught.value.numbers.get("row") == row


def test_a_joint_value_that_is_not_finite_is_an_error():
    with pytest.raises(TraceError, match="joints"):
        Stops(np.array([0]), np.zeros((1, 3)), ("arm_joint_1",), np.array([[np.inf]]))
