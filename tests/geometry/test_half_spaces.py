"""The bisector law: a pose satisfies its row exactly if its tag is nearer to the first anchor."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from rfcompass.geometry import Pose2, bisector_rows, change_frame

coordinates = st.floats(-3, 3)
points = st.tuples(coordinates, coordinates, coordinates).map(np.array)
poses = st.builds(Pose2, coordinates, coordinates, st.floats(-3.1, 3.1))


def unknowns(pose: Pose2) -> np.ndarray:
    return np.array([pose.x_m, pose.y_m, np.cos(pose.theta_rad), np.sin(pose.theta_rad)])


@given(points, points, points, poses)
def test_a_row_measures_the_difference_of_squared_distances(nearer, farther, tag, pose):
    A, b = bisector_rows(nearer[None], farther[None], tag[None])
    p = pose.apply(tag)
    excess = ((p - nearer) ** 2).sum() - ((p - farther) ** 2).sum()
    assert np.isclose((A @ unknowns(pose) - b)[0], excess, atol=1e-9)


@given(points, points, points, poses, poses)
def test_a_row_says_the_same_in_every_frame(nearer, farther, tag, pose, T_new_old):
    A, b = bisector_rows(nearer[None], farther[None], tag[None])
    A_new, b_new = change_frame(A, b, T_new_old)
    slack_old = b - A @ unknowns(pose)
    slack_new = b_new - A_new @ unknowns(T_new_old @ pose)
    assert np.allclose(slack_old, slack_new, atol=1e-8)


@given(points, points, points, poses)
def test_swapping_the_anchors_flips_the_row(nearer, farther, tag, pose):
    A, b = bisector_rows(np.stack([nearer, farther]), np.stack([farther, nearer]), np.stack([tag, tag]))
    assert np.allclose(A[0], -A[1])
    assert np.isclose(b[0], -b[1])


def test_heights_left_out_move_the_bisector_by_decimetres():
    """Erratum E6: hand tag 0.3 m, base tag 0.1 m, part 0.025 m high, 0.3 m apart: about 12 cm."""
    nearer, farther, tag = np.array([[0, 0, 0.3]]), np.array([[0.3, 0, 0.1]]), np.array([[0, 0, 0.025]])
    flat = np.array([1.0, 1.0, 0.0])
    A, b = bisector_rows(nearer, farther, tag)
    _, b_flat = bisector_rows(nearer * flat, farther * flat, tag * flat)
    assert 0.10 < abs(b - b_flat)[0] / A[0, 0] < 0.13
