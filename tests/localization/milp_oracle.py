"""What HiGHS makes of the same question: as many rows as one point of a convex set can meet."""

import numpy as np
from scipy.optimize import Bounds, LinearConstraint, milp


def most_rows(A, b, low, high, extra=()):
    """Largest number of rows A z <= b that one z meets, with low <= z <= high and extra rows (a, most) met by force.

    One binary unknown for each row says whether it must hold; if not, it gets as much slack as the box can need.
    """
    M, n = A.shape
    slack = np.maximum(np.maximum(A * low, A * high).sum(axis=1) - b, 0.0)
    constraints = [LinearConstraint(np.hstack([A, np.diag(slack)]), ub=b + slack)]
    constraints += [LinearConstraint(np.concatenate([a, np.zeros(M)]), ub=most) for a, most in extra]
    answer = milp(
        np.concatenate([np.zeros(n), -np.ones(M)]), constraints=constraints,
        integrality=np.concatenate([np.zeros(n), np.ones(M)]),
        bounds=Bounds(np.concatenate([low, np.zeros(M)]), np.concatenate([high, np.ones(M)])),
    )  # fmt: skip
    assert answer.status == 0, answer.message
    return round(-answer.fun)


def most_rows_in_plane(G, bounds_m):
    """The same for rows [n_x, n_y, 0, 0, β, 0] and a rectangle."""
    return most_rows(G[:, :2], G[:, 4], bounds_m[:, 0], bounds_m[:, 1])


def most_rows_of_poses(G, bounds_m, ranges=48):
    """At least as many as any pose can meet: (cos θ, sin θ) is let into the pentagon about each arc of the circle."""
    half, most = np.pi / ranges, 0
    low, high = np.append(bounds_m[:, 0], [-1.1, -1.1]), np.append(bounds_m[:, 1], [1.1, 1.1])
    for middle in (2 * np.arange(ranges) + 1) * half - np.pi:
        tangents = [(np.array([0, 0, np.cos(t), np.sin(t)]), 1.0) for t in (middle - half, middle, middle + half)]
        chord = (-np.array([0, 0, np.cos(middle), np.sin(middle)]), -np.cos(half))
        most = max(most, most_rows(G[:, :4], G[:, 4], low, high, [*tangents, chord]))
    return most
