"""The compiled linear program against HiGHS, and the analytic centre against its own definition."""

import numpy as np
import pytest
from compared_scenes import distances, leg_points, random_stops
from scipy.optimize import linprog

from rfcompass.geometry import Pose2
from rfcompass.localization import partition_kernels as kernels
from rfcompass.localization.compared_stop import ComparedStop
from rfcompass.localization.comparing import compare_proximities
from rfcompass.localization.problem import build_partition
from rfcompass.localization.scaled_rows import scale_rows


def cells(count, **size):
    """Unit rows of random cells, by column, with the 64-gon."""
    for seed in range(count):
        stops, _ = random_stops(np.random.default_rng(seed), **size)
        for reduced in (True, False):
            scaled = scale_rows(build_partition(stops, transitive_reduction=reduced))
            G, h = scaled.with_polygon()
            yield scaled, np.ascontiguousarray(G.T), h


@pytest.mark.parametrize("size", [{"K": 1}, {"K": 2, "S": 1}, {"K": 4}], ids=str)
def test_the_largest_ball_is_the_one_of_highs(size):
    for _, G, h in cells(15, **size):
        _, radius, status = kernels.chebyshev(G, h, 1e-9)
        n = len(G)
        reference = linprog(
            [*np.zeros(n), -1.0], np.column_stack([G.T, np.ones(h.size)]), h, bounds=(None, None), method="highs"
        )
        assert status == kernels.SOLVED
        assert abs(radius + reference.fun) < 1e-8


def open_cells(count):
    """Cells of a small robot and a part metres away: wedges that only the bounds close, or that are empty."""
    rng = np.random.default_rng(1)
    anchors_m = np.column_stack([rng.uniform(-0.3, 0.3, (6, 2)), rng.uniform(0.0, 0.2, 6)])
    for _ in range(count):
        truth = Pose2(*rng.uniform(-6, 6, 2), rng.uniform(-np.pi, np.pi))
        stops = []
        for pose in (Pose2(*rng.uniform(-0.5, 0.5, 2), rng.uniform(-0.5, 0.5)), Pose2()):
            m = distances(anchors_m, leg_points(2), pose.inverse() @ truth)
            noisy = np.abs(m + 0.02 * rng.normal(size=m.shape))
            stops.append(ComparedStop(anchors_m, leg_points(2), compare_proximities(noisy), pose))
        for epsilon in (0.0, 0.05):
            bounds_m = np.array([[-10.0, 10.0], [-10.0, 10.0]])
            if any(stop.comparisons.used_at(epsilon).any() for stop in stops):
                yield scale_rows(build_partition(stops, epsilon=epsilon, bounds_m=bounds_m))


def test_open_and_empty_cells_far_away_are_solved_too():
    """Without a lower bound on the radius the solver loses its way in such cells."""
    radii = []
    for scaled in open_cells(60):
        G, h = scaled.with_polygon()
        _, radius, status = kernels.chebyshev(np.ascontiguousarray(G.T), h, 1e-9)
        reference = linprog([0, 0, 0, 0, -1.0], np.column_stack([G, np.ones(h.size)]), h, bounds=(None, None))
        assert status == kernels.SOLVED
        assert abs(radius + reference.fun) < 1e-7
        radii.append(radius)
    assert min(radii) < 0.0 < max(radii)


def test_the_radius_of_contradicting_rows_is_negative():
    G = np.array([[1.0, -1.0, 0.0, 0.0], [0.0, 0.0, 1.0, -1.0]])
    y, radius, status = kernels.chebyshev(G, np.array([0.0, -0.4, 1.0, 1.0]), 1e-9)
    assert status == kernels.SOLVED
    assert abs(radius + 0.2) < 1e-8
    assert abs(y[0] - 0.2) < 1e-8


def test_a_linear_goal_is_reached_as_by_highs():
    rng = np.random.default_rng(0)
    for _, G, h in cells(10):
        inside, _, _ = kernels.chebyshev(G, h, 1e-9)
        c = rng.normal(size=len(G))
        y, status = kernels.maximise(G, h, c, inside, 1e-9)
        reference = linprog(-c, G.T, h, bounds=(None, None), method="highs")
        assert status == kernels.SOLVED
        assert abs(c @ y + reference.fun) < 1e-7
        assert (G.T @ y <= h + 1e-12).all()


def barrier(G, h, y, disc):
    """Slow reference, straight from the definition."""
    room = [disc**2 - y[2] ** 2 - y[3] ** 2] if disc else []
    s = np.concatenate([h - G.T @ y, room])
    return -np.log(s).sum() if (s > 0).all() else np.inf


@pytest.mark.parametrize("size", [{"K": 1}, {"K": 4}, {"K": 2, "S": 1}], ids=str)
def test_no_step_from_the_analytic_centre_lowers_the_barrier(size):
    rng = np.random.default_rng(0)
    for scaled, polygon, h in cells(8, **size):
        start, radius, _ = kernels.chebyshev(polygon, h, 1e-9)
        G = np.ascontiguousarray(scaled.G.T)
        y, status = kernels.analytic_centre(G, scaled.h, start, scaled.disc)
        assert status == kernels.SOLVED
        lowest = barrier(G, scaled.h, y, scaled.disc)
        assert lowest <= barrier(G, scaled.h, start, scaled.disc)
        for step in rng.normal(size=(50, len(G))) * radius / 10:
            assert barrier(G, scaled.h, y + step, scaled.disc) > lowest


def test_a_symmetric_cell_has_its_centre_in_the_middle():
    G = np.array([[1.0, -1.0, 0.0, 0.0, 1.0, -1.0], [0.0, 0.0, 1.0, -1.0, 0.0, 0.0]])  # coincident rows
    y, status = kernels.analytic_centre(G, np.ones(6), np.array([0.7, -0.9]), 0.0)
    assert status == kernels.SOLVED
    assert np.abs(y).max() < 1e-9
