"""The solid of all poses that meet the rows, against random poses and against the plane geometry of polygons."""

import numpy as np
from compared_scenes import random_stops

from rfcompass.geometry import angle_difference, intersect_half_planes, polygon_contains
from rfcompass.localization.pose_kernels import can_break, moments, ranges_alive, slices
from rfcompass.localization.pose_set import pose_set, unite
from rfcompass.localization.problem import PartitionProblem, build_partition
from rfcompass.types import HalfSpaces

BOUNDS_M = np.array([[-1.0, 1.0], [-1.0, 1.0]])


def a_problem(seed=0, **size):
    stops, truth = random_stops(np.random.default_rng(seed), **size)
    return build_partition(stops, bounds_m=BOUNDS_M), truth


def drawn(problem, count=200_000):
    """Random poses in the bounds that meet the rows, and the share of them."""
    rng = np.random.default_rng(9)
    x, y, theta = rng.uniform(-1, 1, count), rng.uniform(-1, 1, count), rng.uniform(-np.pi, np.pi, count)
    z = np.column_stack([x, y, np.cos(theta), np.sin(theta)])
    inside = (z @ problem.rows.A.T <= problem.rows.b).all(axis=1)
    return np.column_stack([x, y, theta])[inside], inside.mean()


def test_volume_mean_and_spread_are_those_of_random_poses():
    problem, _ = a_problem(K=2, N=4, S=1)
    poses, share = drawn(problem)
    found = pose_set(problem)
    assert len(poses) > 1000
    assert abs(found.volume / (4.0 * 2.0 * np.pi * share) - 1.0) < 0.1
    z = found.mean_z
    assert np.abs(z[:2] - poses[:, :2].mean(axis=0)).max() < 0.02
    assert abs(z[2] + 1j * z[3] - np.exp(1j * poses[:, 2]).mean()) < 0.05
    turn = angle_difference(poses[:, 2], np.arctan2(z[3], z[2]))
    spread = np.cov(np.column_stack([poses[:, :2], turn]).T)
    assert np.allclose(np.sqrt(np.diag(found.covariance)), np.sqrt(np.diag(spread)), rtol=0.1)
    assert np.abs(found.covariance - spread).max() < 0.1 * np.abs(spread).max()


def test_interval_and_region_hold_all_random_poses():
    problem, _ = a_problem(K=2, N=5, S=1)
    poses, _ = drawn(problem)
    found = pose_set(problem)
    low, high = found.theta_interval_rad
    assert len(poses) > 100
    assert ((poses[:, 2] - low) % (2 * np.pi) <= high - low).all()
    assert polygon_contains(found.region_m, poses[:, :2], 0.01).all()


def test_the_true_pose_of_exact_comparisons_is_inside():
    for seed in range(20):
        problem, truth = a_problem(seed)
        found = pose_set(problem)
        low, high = found.theta_interval_rad
        assert (truth.theta_rad - low) % (2 * np.pi) <= high - low
        assert np.hypot(*(found.mean_z[:2] - truth.translation_m)) < 0.3


def test_slices_are_the_polygons_of_half_planes():
    problem, truth = a_problem()
    theta = truth.theta_rad + np.linspace(-0.1, 0.1, 21)
    vertices, counts = slices(problem.rows.A, problem.rows.b, BOUNDS_M, theta)
    for t, angle in enumerate(theta):
        room = problem.rows.b - problem.rows.A[:, 2:] @ [np.cos(angle), np.sin(angle)]
        reference = intersect_half_planes(problem.rows.A[:, :2], room, BOUNDS_M)
        assert np.allclose(vertices[t, : counts[t]], reference, atol=1e-12)
    assert counts[10] >= 3


def test_rows_left_out_on_the_way_do_not_change_the_set():
    """The slices of all rows within the original bounds are the same polygons."""
    for seed in range(5):
        problem, _ = a_problem(seed)
        found = pose_set(problem)
        vertices, counts = slices(problem.rows.A, problem.rows.b, BOUNDS_M, found.theta_rad)
        whole = moments(vertices, counts) * found.width_rad[:, None]
        assert found.theta_rad.size > 10
        assert np.allclose(found.moments, whole, rtol=1e-9, atol=1e-15)


def test_rows_that_are_called_met_everywhere_are():
    rng = np.random.default_rng(0)
    for seed in range(5):
        problem, truth = a_problem(seed)
        box_m, half = truth.translation_m[:, None] + np.array([-0.05, 0.05]), 0.1
        middle = truth.theta_rad + np.array([-0.2, 0.3])
        maybe = can_break(problem.rows.A, problem.rows.b, box_m, middle, half)
        x, y = rng.uniform(*box_m.T[:, :, None], (2, 1000))
        theta = rng.choice(middle, 1000) + rng.uniform(-half, half, 1000)
        z = np.column_stack([x, y, np.cos(theta), np.sin(theta)])
        broken = (z @ problem.rows.A.T > problem.rows.b).any(axis=0)
        assert not broken[~maybe].any()
        assert 0 < (~maybe).sum() < maybe.size


def test_no_range_with_a_pose_in_it_is_called_empty():
    for seed in range(5):
        problem, _ = a_problem(seed, K=2, N=5, S=1)
        poses, _ = drawn(problem, 20_000)
        for half in (0.5, 0.05, 0.005):
            assert ranges_alive(problem.rows.A, problem.rows.b, BOUNDS_M, poses[:, 2], half)[0].all()


def test_contradicting_rows_hold_no_pose():
    A = np.array([[1.0, 0, 0.1, 0], [-1.0, 0, -0.1, 0]])
    found = pose_set(PartitionProblem(HalfSpaces(A, [-0.01, -0.01], [0, 1]), BOUNDS_M))
    assert found.volume == 0.0
    assert found.mean_z is None
    assert found.covariance is None
    assert found.theta_interval_rad is None
    assert found.region_m.shape == (0, 2)


def test_a_thin_cell_is_measured():
    """One micrometre wide, a millionth of a radian in range."""
    A = np.array([[1.0, 0, 0, 0], [-1.0, 0, 0, 0], [0, 0, -1.0, 0]])
    problem = PartitionProblem(HalfSpaces(A, [1e-6, 0.0, -np.cos(1e-6)], [0, 1, 2]), BOUNDS_M)
    found = pose_set(problem)
    assert abs(found.volume / (1e-6 * 2.0 * 2e-6) - 1.0) < 0.05
    low, high = found.theta_interval_rad
    assert abs(low + 1e-6) < 1e-7
    assert abs(high - 1e-6) < 1e-7


def test_without_theta_the_set_is_one_polygon():
    problem, _ = a_problem(K=1)
    found = pose_set(problem)
    assert found.mean_z.shape == (2,)
    assert found.theta_interval_rad is None
    assert np.isnan(found.covariance[2]).all()
    assert np.isfinite(found.covariance[:2, :2]).all()


def test_a_union_weighs_its_parts_by_volume():
    boxes = [
        pose_set(PartitionProblem(HalfSpaces([[1.0, 0, 0, 0], [-1.0, 0, 0, 0]], [high, -low], [0, 1]), BOUNDS_M))
        for low, high in ((-1.0, -0.5), (0.0, 1.0))
    ]
    both = unite(boxes)
    assert abs(both.mean_z[0] - (0.5 * -0.75 + 1.0 * 0.5) / 1.5) < 1e-9
    assert abs(both.volume - 1.5 * 2.0 * 2.0 * np.pi) < 1e-9


def test_an_interval_may_cross_the_half_turn():
    A = np.array([[0, 0, 1.0, 0]])
    found = pose_set(PartitionProblem(HalfSpaces(A, [-np.cos(0.3)], [0]), BOUNDS_M))
    low, high = found.theta_interval_rad
    assert -np.pi <= low < np.pi
    assert abs(low - (np.pi - 0.3)) < 0.02
    assert abs(high - (np.pi + 0.3)) < 0.02
