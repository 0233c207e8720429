"""Poses of the plane obey the axioms of a group, also near the identity and far from the origin."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rfcompass.errors import ShapeError
from rfcompass.geometry import Pose2, angle_difference, as_pose2

lengths = st.one_of(st.floats(-100, 100), st.floats(-1e-9, 1e-9))
angles = st.one_of(st.floats(-10, 10), st.floats(-1e-9, 1e-9))
poses = st.builds(Pose2, lengths, lengths, angles)
points = st.tuples(lengths, lengths).map(np.array)


def assert_same(a: Pose2, b: Pose2) -> None:
    assert np.allclose(a.translation_m, b.translation_m, atol=1e-9)
    assert abs(angle_difference(a.theta_rad, b.theta_rad)) < 1e-9


@given(poses, poses, poses)
def test_composition_is_associative(a, b, c):
    assert_same((a @ b) @ c, a @ (b @ c))


@given(poses)
def test_the_identity_changes_nothing(a):
    assert_same(a @ Pose2(), a)
    assert_same(Pose2() @ a, a)


@given(poses)
def test_the_inverse_undoes(a):
    assert_same(a @ a.inverse(), Pose2())
    assert_same(a.inverse() @ a, Pose2())


@given(poses, poses, points)
def test_composing_poses_is_applying_one_after_the_other(a, b, p):
    assert np.allclose((a @ b).apply(p), a.apply(b.apply(p)), atol=1e-9)


@given(poses, points, points)
def test_distances_do_not_change(a, p, q):
    assert np.isclose(np.linalg.norm(a.apply(p) - a.apply(q)), np.linalg.norm(p - q), atol=1e-9)


@given(poses, lengths)
def test_heights_do_not_change(a, z):
    assert a.apply(np.array([1.0, 2.0, z]))[2] == z


@given(poses)
def test_the_angle_is_kept_within_one_turn(a):
    assert -np.pi <= a.theta_rad < np.pi


@pytest.mark.parametrize("shape", [(), (4,), (2, 1)])
def test_points_of_another_dimension_are_refused(shape):
    with pytest.raises(ShapeError):
        Pose2().apply(np.zeros(shape))


@pytest.mark.parametrize("bad", [(np.nan, 0, 0), (0, np.inf, 0), (0, 0, np.nan)])
def test_a_pose_is_finite(bad):
    with pytest.raises(ShapeError):
        Pose2(*bad)
    with pytest.raises(ShapeError):
        as_pose2(bad)
