import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rfcompass.errors import ShapeError
from rfcompass.geometry import Pose2, angle_difference, fit_pose2

poses = st.builds(Pose2, st.floats(-3, 3), st.floats(-3, 3), st.floats(-3.1, 3.1))
seeds = st.integers(0, 10_000)


@given(poses, seeds, st.integers(2, 6))
def test_exact_points_give_back_the_pose(pose, seed, count):
    points = np.random.default_rng(seed).uniform(-1, 1, (count, 2))
    found = fit_pose2(points, pose.apply(points))
    assert np.allclose(found.translation_m, pose.translation_m, atol=1e-7)
    assert abs(angle_difference(found.theta_rad, pose.theta_rad)) < 1e-7


@given(poses, seeds)
def test_no_nearby_pose_fits_better(pose, seed):
    rng = np.random.default_rng(seed)
    b = rng.uniform(-1, 1, (4, 2))
    a = pose.apply(b) + rng.normal(0, 0.1, (4, 2))

    def cost(p: Pose2) -> float:
        return float(((p.apply(b) - a) ** 2).sum())

    best = fit_pose2(b, a)
    for step in rng.normal(0, 0.01, (10, 3)):
        assert cost(best) <= cost(Pose2(best.x_m + step[0], best.y_m + step[1], best.theta_rad + step[2])) + 1e-12


@pytest.mark.parametrize("points", [np.zeros((1, 2)), np.zeros((3, 2))])
def test_points_that_leave_the_turn_open_are_refused(points):
    with pytest.raises(ShapeError):
        fit_pose2(points, points)
