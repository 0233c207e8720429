"""An estimate that could be anywhere, or that rests on ghosts, sends nobody anywhere."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from planners.worth_driving import LOST_M, MOST_STRETCHED, doubt_m, is_worth_driving
from rfcompass.rf.self_check import own_scale
from rfcompass.types import PartEstimate, ProximityMatrix, TagPositions

POINTS_M = np.array([[0.0, 0.0, 0.1], [0.3, 0.1, 0.1], [-0.2, 0.2, 0.4], [0.1, -0.3, 0.2]])
ANCHORS = TagPositions("base_footprint", ("a", "b", "c", "d"), POINTS_M)


def matrix(stretched=1.0, kind="sar_nearfield"):
    m = stretched * np.linalg.norm(POINTS_M[:, None] - POINTS_M, axis=2)
    np.fill_diagonal(m, np.nan)
    return ProximityMatrix(("t",), ANCHORS.epcs, np.ones((1, 4)), m, kind)


def estimate(sd_m=None):
    covariance = None if sd_m is None else np.diag([sd_m[0] ** 2, sd_m[1] ** 2, np.nan])
    return PartEstimate("leg", np.array([1.0, 0.0]), None, "told", 1, covariance=covariance)


def test_it_is_the_worst_direction_that_counts():
    assert is_worth_driving(estimate((0.1, 0.99 * LOST_M)), matrix(), ANCHORS)
    assert not is_worth_driving(estimate((0.1, 1.01 * LOST_M)), matrix(), ANCHORS)


@given(sd_m=st.tuples(st.floats(0.01, 5.0), st.floats(0.01, 5.0)))
def test_doubt_is_the_larger_standard_deviation_and_infinite_over_ghosts(sd_m):
    assert doubt_m(estimate(sd_m), matrix(), ANCHORS) == pytest.approx(max(sd_m))
    assert doubt_m(estimate(sd_m), matrix(1.1 * MOST_STRETCHED), ANCHORS) == np.inf


@given(stretched=st.floats(0.1, 10.0))
def test_tags_of_the_robot_that_seem_far_too_far_apart_or_too_near_are_ghosts(stretched):
    assert own_scale(matrix(stretched), ANCHORS) == pytest.approx(stretched)
    believed = is_worth_driving(estimate((0.01, 0.01)), matrix(stretched), ANCHORS)
    assert believed == (1.0 / MOST_STRETCHED <= own_scale(matrix(stretched), ANCHORS) <= MOST_STRETCHED)


def test_a_meter_of_another_unit_has_no_scale():
    assert own_scale(matrix(7.0, "phase_l1"), ANCHORS) is None
    assert is_worth_driving(estimate(), matrix(7.0, "phase_l1"), ANCHORS)


def test_where_no_pair_was_measured_there_is_no_scale():
    blind = ProximityMatrix(("t",), ANCHORS.epcs, np.ones((1, 4)), np.full((4, 4), np.nan), "sar_nearfield")
    assert own_scale(blind, ANCHORS) is None
