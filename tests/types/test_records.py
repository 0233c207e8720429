"""Records refuse what cannot be true, and come back from a pickle unchanged and still read-only."""

import dataclasses
import pickle

import numpy as np
import pytest

from rfcompass import types
from rfcompass.errors import DuplicateEpc, InputError, ShapeError, TagNeverHeard
from rfcompass.geometry import Pose2
from rfcompass.types import (
    Comparisons,
    HalfSpaces,
    Observation,
    PartEstimate,
    ProximityMatrix,
    ReadTrace,
    Scan,
    TagLayout,
    TagPositions,
)


def a_trace(epc="a", **changes):
    fields = {
        "epc": epc,
        "antenna_positions_m": np.arange(6.0).reshape(2, 3),
        "frequencies_hz": np.array([9.0e8, 9.1e8]),
        "channel": np.array([[1j, 0], [1, 2]]),
        "read_counts": np.array([[3, 0], [1, 1]]),
        "antenna_ports": np.array([1, 1]),
    }
    return ReadTrace(**{**fields, **changes})


def a_part(**changes):
    fields = {
        "body": "leg",
        "epcs": ("p1", "p2"),
        "frames": ("part", "part"),
        "points_m": np.array([[0.2, 0, 0], [-0.2, 0, 0]]),
        "dipoles": np.array([[0, 0, 2.0], [0, 0, 1.0]]),
        "roles": ("part_end", "part_end"),
        "counterparts": {2: {"hand_left": 0, "hand_right": 1}},
    }
    return TagLayout(**{**fields, **changes})


def an_observation(**changes):
    fields = {
        "stop_id": 1,
        "anchors": TagPositions("base", ("r1", "r2"), np.eye(3)[:2]),
        "part": a_part(),
        "part_tag_heights_m": np.array([0.05, 0.05]),
        "scan": Scan({"a": a_trace()}),
    }
    return Observation(**{**fields, **changes})


def a_matrix(**changes):
    anchor_m = np.array([[np.nan, 2.0], [2.0, np.nan]])
    fields = {
        "target_epcs": ("p",), "anchor_epcs": ("r1", "r2"), "m": [[1.0, np.nan]], "anchor_m": anchor_m, "kind": "rssi",
    }  # fmt: skip
    return ProximityMatrix(**{**fields, **changes})


RECORDS = [
    a_trace(),
    Scan({"a": a_trace()}),
    a_part(),
    an_observation(),
    a_matrix(),
    Comparisons([0], [0], [1], [0.5]),
    HalfSpaces(np.zeros((2, 4)), np.zeros(2), np.arange(2)),
    PartEstimate("leg", np.zeros(2), None, "partition", 1, diagnostics={"epsilon": 0.05}),
]


def same(a, b):
    if dataclasses.is_dataclass(a):
        return type(a) is type(b) and all(same(getattr(a, f.name), getattr(b, f.name)) for f in dataclasses.fields(a))
    if isinstance(a, np.ndarray):
        return np.array_equal(a, b, equal_nan=a.dtype.kind in "fc") and a.flags.writeable == b.flags.writeable
    if hasattr(a, "items"):
        return list(a) == list(b) and all(same(a[key], b[key]) for key in a)
    return a == b


@pytest.mark.parametrize("record", RECORDS, ids=lambda record: type(record).__name__)
def test_a_record_survives_a_pickle(record):
    copy = pickle.loads(pickle.dumps(record))
    assert same(record, copy)


@pytest.mark.parametrize("record", RECORDS, ids=lambda record: type(record).__name__)
def test_no_field_of_a_record_can_be_changed(record):
    name = dataclasses.fields(record)[0].name
    with pytest.raises(dataclasses.FrozenInstanceError):
        setattr(record, name, None)
    for field in dataclasses.fields(record):
        value = getattr(record, field.name)
        assert not isinstance(value, np.ndarray) or not value.flags.writeable


def test_every_public_record_is_frozen_and_slotted():
    records = [cls for name in types.__all__ if dataclasses.is_dataclass(cls := getattr(types, name))]
    assert len(records) > 15
    for cls in records:
        assert cls.__dataclass_params__.frozen, cls
        assert "__slots__" in cls.__dict__, cls


@pytest.mark.parametrize(
    "changes",
    [
        {"frequencies_hz": [9.1e8, 9.0e8]},
        {"frequencies_hz": [0.0, 9.0e8]},
        {"channel": np.full((2, 2), np.nan)},
        {"channel": np.ones((2, 2))},  # a value in a cell without reads
        {"read_counts": np.array([[-1, 0], [1, 1]])},
        {"read_counts": np.ones((3, 2), int)},
        {"antenna_positions_m": np.zeros((2, 2))},
        {"phase_modulus_rad": 1.0},
        {"tx_positions_m": np.zeros((1, 3))},
    ],
)
def test_a_trace_that_cannot_be_is_refused(changes):
    with pytest.raises(ShapeError):
        a_trace(**changes)


def test_a_bistatic_round_trip_is_the_sum_of_both_ways():
    trace = a_trace(tx_positions_m=np.zeros((2, 3)))
    point = np.array([[1.0, 2.0, 2.0]])
    expected = 3.0 + np.linalg.norm(point - trace.antenna_positions_m, axis=1)
    assert np.allclose(trace.round_trip_m(point), expected)
    assert np.allclose(a_trace().round_trip_m(point), 2 * (expected - 3.0))


def test_a_tag_that_was_not_heard_is_named_with_those_that_were():
    with pytest.raises(TagNeverHeard, match="b was never heard \\(heard: a\\)") as caught:
        Scan({"a": a_trace()}).trace("b")
    assert caught.value.numbers == {"epc": "b", "heard": ["a"]}


def test_a_scan_does_not_take_a_trace_under_another_name():
    with pytest.raises(ShapeError):
        Scan({"b": a_trace("a")})


def test_dipoles_are_unit_vectors():
    assert np.allclose(np.linalg.norm(a_part().dipoles, axis=1), 1.0)


@pytest.mark.parametrize(
    ("changes", "error"),
    [
        ({"epcs": ("p1", "p1")}, DuplicateEpc),
        ({"roles": ("part_end", "nose")}, InputError),
        ({"roles": ("part_end",)}, ShapeError),
        ({"dipoles": np.zeros((2, 3))}, ShapeError),
        ({"points_m": np.zeros((3, 3))}, ShapeError),
    ],
)
def test_a_layout_that_cannot_be_is_refused(changes, error):
    with pytest.raises(error):
        a_part(**changes)


def test_a_position_is_found_by_its_epc():
    positions = TagPositions("base", ("r1", "r2"), np.eye(3)[:2])
    assert np.array_equal(positions.point_m("r2"), [0, 1, 0])
    with pytest.raises(InputError, match="r1, r2"):
        positions.point_m("r3")


@pytest.mark.parametrize(
    ("changes", "error"),
    [
        ({"anchors": TagPositions("base", ("p1",), np.zeros((1, 3)))}, InputError),
        ({"base_covariance": np.diag([1.0, 1.0, -1.0])}, InputError),
        ({"base_covariance": np.triu(np.ones((3, 3)))}, InputError),
        ({"part_tag_heights_m": np.zeros(3)}, ShapeError),
    ],
)
def test_an_observation_that_cannot_be_is_refused(changes, error):
    with pytest.raises(error):
        an_observation(**changes)


@pytest.mark.parametrize(
    ("changes", "error"),
    [
        ({"m": [[-1.0, 1.0]]}, ShapeError),
        ({"m": [[np.inf, 1.0]]}, ShapeError),
        ({"m": [[1.0]]}, ShapeError),
        ({"anchor_m": [[np.nan, 2.0], [1.0, np.nan]]}, ShapeError),
        ({"anchor_m": [[0.0, 2.0], [2.0, 0.0]]}, ShapeError),
        ({"anchor_epcs": ("r1", "r1")}, DuplicateEpc),
    ],
)
def test_proximities_that_cannot_be_are_refused(changes, error):
    with pytest.raises(error):
        a_matrix(**changes)


def test_epsilon_drops_the_comparisons_with_small_margins_only():
    comparisons = Comparisons([0, 0, 0], [0, 1, 2], [1, 2, 0], [0.0, 0.1, np.nan])
    assert comparisons.used_at(0.0).tolist() == [True, True, True]
    assert comparisons.used_at(0.1).tolist() == [False, True, True]
    assert comparisons.used_at(0.2).tolist() == [False, False, True]
    assert not comparisons.has_margins
    assert comparisons.take([1]).has_margins


@pytest.mark.parametrize(
    "columns", [([0], [1], [1], [0.5]), ([-1], [0], [1], [0.5]), ([0], [0], [1], [1.5]), ([0], [0, 1], [1], [0.5])]
)
def test_comparisons_that_cannot_be_are_refused(columns):
    with pytest.raises((InputError, ShapeError)):
        Comparisons(*columns)


def test_half_spaces_are_over_the_plane_or_over_the_pose():
    with pytest.raises(ShapeError):
        HalfSpaces(np.zeros((2, 3)), np.zeros(2), np.arange(2))


def test_an_estimate_knows_where_to_drive():
    estimate = PartEstimate("leg", np.array([-3.0, 4.0]), 0.5, "partition", 1)
    assert np.isclose(estimate.distance_m, 5.0)
    assert np.isclose(estimate.bearing_rad, np.arctan2(4, -3))


def test_an_estimate_moves_with_the_frame():
    rng = np.random.default_rng(5)
    samples = rng.normal(size=(500, 3))
    estimate = PartEstimate(
        "leg", samples[:, :2].mean(axis=0), 0.3, "posterior", 1, covariance=np.cov(samples.T), samples=samples
    )
    moved = estimate.in_frame(Pose2(1.0, -2.0, 0.7))
    assert np.allclose(moved.samples[:, :2].mean(axis=0), moved.centre_m)
    assert np.allclose(np.cov(moved.samples.T), moved.covariance)
    assert np.isclose(moved.theta_rad, 1.0)


def test_an_orientation_that_is_not_observable_stays_so():
    covariance = np.full((3, 3), np.nan)
    covariance[:2, :2] = np.diag([4.0, 1.0])
    estimate = PartEstimate("leg", np.zeros(2), None, "partition", 1, covariance=covariance)
    moved = estimate.in_frame(Pose2(0, 0, np.pi / 2))
    assert moved.theta_rad is None
    assert np.allclose(moved.covariance[:2, :2], np.diag([1.0, 4.0]))
    with pytest.raises(ShapeError):
        PartEstimate("leg", np.zeros(2), 0.1, "partition", 1, covariance=covariance)


def test_reads_of_one_way_after_another_keep_every_cell_and_all_carriers():
    more = a_trace(
        antenna_positions_m=[[9.0, 9, 9]], frequencies_hz=[9.1e8, 9.2e8], channel=[[3, 0]], read_counts=[[5, 0]],
        antenna_ports=[2],
    )  # fmt: skip
    joined = a_trace().then(more)
    np.testing.assert_array_equal(joined.frequencies_hz, [9.0e8, 9.1e8, 9.2e8])
    np.testing.assert_array_equal(joined.channel, [[1j, 0, 0], [1, 2, 0], [0, 3, 0]])
    np.testing.assert_array_equal(joined.read_counts, [[3, 0, 0], [1, 1, 0], [0, 5, 0]])
    np.testing.assert_array_equal(joined.antenna_ports, [1, 1, 2])
    np.testing.assert_array_equal(joined.antenna_positions_m[2], [9, 9, 9])
    assert joined.reads == a_trace().reads + more.reads


@pytest.mark.parametrize(
    "other",
    [{"epc": "b"}, {"phase_modulus_rad": np.pi}, {"tx_positions_m": np.zeros((2, 3))}],
    ids=lambda other: next(iter(other)),
)
def test_reads_of_two_tags_or_readers_are_not_joined(other):
    with pytest.raises(ShapeError):
        a_trace().then(a_trace(**other))
