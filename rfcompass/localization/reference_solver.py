"""The partition problem in the words of cvxpy: slow, readable, and open to a user's own convex constraints.

cvxpy is imported only when it is asked for, since that takes a second or two.
"""

import importlib
import warnings
from collections.abc import Callable, Sequence
from typing import Any, TypeAlias

import numpy as np

from rfcompass.arrays import FloatArray
from rfcompass.errors import SolverFailed
from rfcompass.localization.scaled_rows import ScaledRows

# Takes the cvxpy expression of [x0, y0] or [x0, y0, c, s] (newest base frame, metres), returns cvxpy constraints.
ExtraConstraints: TypeAlias = Callable[[Any], Sequence[Any]]

_ROUNDS = ((1e-8, 1.0), (1e-9, 3.0), (1e-11, 1.0), (1e-11, 3.0))  # tolerance and unit of u, for each round


def largest_ball(scaled: ScaledRows, extra_constraints: ExtraConstraints | None = None) -> tuple[FloatArray, float]:
    """Chebyshev centre: maximise r, subject to G y + r <= h and the 64-gon.

    Args:
        scaled: Rows and bounds.
        extra_constraints: Further convex constraints on the centre.

    Returns:
        The centre in scaled unknowns, shape (n,), and the radius [m]; negative if the rows contradict each other,
        -inf if the extra constraints do.

    Raises:
        SolverFailed: If the solver stops without a verdict.
    """
    cp = _cvxpy()
    G, h = scaled.with_polygon()
    y, r = cp.Variable(G.shape[1]), cp.Variable()
    constraints = [G @ y + r <= h, *_extra(scaled, y, extra_constraints)]
    program = cp.Problem(cp.Maximize(r), constraints)
    if _solve(program, 1e-10) == "infeasible":
        return np.zeros(G.shape[1]), -np.inf
    return np.asarray(y.value), float(r.value)


def analytic_centre(
    scaled: ScaledRows, near: FloatArray, extra_constraints: ExtraConstraints | None = None
) -> FloatArray | None:
    """Minimise -Σ log(b - A z) - log(1 - c² - s²), in scaled unknowns.

    The program is written in u, with y = near + T u and T Tᵀ the inverse Hessian of the barrier at `near`, the
    disc's taken at its middle, so that the cell has about the size one in every direction and the solver's
    tolerance is a small part of it. It is solved several times, each time about the answer before, and rounds in
    which the solver gives up or calls its own answer inaccurate are passed over if another one succeeds:
    exponential cones come out with three to six digits, and sometimes not at all, which is not enough to judge
    another solver by.

    Args:
        scaled: Rows and bounds.
        near: Point of the cell to start from, scaled, shape (n,).
        extra_constraints: Further convex constraints; they do not enter the barrier.

    Returns:
        The centre in scaled unknowns, shape (n,); None if the disc or the extra constraints leave nothing.

    Raises:
        SolverFailed: If the solver stops without a verdict.
    """
    answer, status, failure = near, "", SolverFailed("cvxpy was not asked", status="")
    for tolerance, unit in _ROUNDS:
        try:
            found, new_status = _analytic_round(scaled, answer, (tolerance, unit), extra_constraints)
        except SolverFailed as error:
            failure = error
            continue
        if found is None and not status:
            return None
        if found is not None and (new_status == "optimal" or status != "optimal"):
            answer, status = found, new_status
    if not status:
        raise failure
    return answer


def _analytic_round(
    scaled: ScaledRows, near: FloatArray, how: tuple[float, float], extra_constraints: ExtraConstraints | None
) -> tuple[FloatArray | None, str]:
    cp, (tolerance, unit) = _cvxpy(), how
    relative = scaled.G / (scaled.h - scaled.G @ near)[:, None]
    T = unit * np.linalg.inv(np.linalg.cholesky(relative.T @ relative + _disc_curvature(scaled))).T
    u = cp.Variable(scaled.scale.size)
    y = near + T @ u
    barrier = -cp.sum(cp.log(1.0 - relative @ T @ u))
    if scaled.disc:
        room = 1.0 - cp.sum_squares(y[2:] / scaled.disc)
        barrier -= cp.sum(cp.log(cp.hstack([room])))
    program = cp.Problem(cp.Minimize(barrier), _extra(scaled, y, extra_constraints))
    status = _solve(program, tolerance)
    return (np.asarray(y.value) if status != "infeasible" else None), status


def _disc_curvature(scaled: ScaledRows) -> FloatArray:
    """Hessian of -log(disc² - y₂² - y₃²) at zero, shape (n, n)."""
    return np.diag([0.0, 0.0, *[2.0 / scaled.disc**2] * 2]) if scaled.disc else np.zeros((2, 2))


def _cvxpy() -> Any:  # noqa: ANN401 - imported late, untyped
    return importlib.import_module("cvxpy")


def _extra(scaled: ScaledRows, y: Any, extra: ExtraConstraints | None) -> list[Any]:  # noqa: ANN401
    return [] if extra is None else list(extra(scaled.middle + y / scaled.scale))


def _solve(program: Any, tolerance: float) -> str:  # noqa: ANN401
    """Solve; returns "optimal", "inaccurate" or "infeasible".

    Raises:
        SolverFailed: On any other outcome.
    """
    cp = _cvxpy()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # "solution may be inaccurate": that is our return value
        try:
            program.solve(solver=cp.CLARABEL, tol_gap_abs=tolerance, tol_gap_rel=tolerance, tol_feas=tolerance)
        except cp.SolverError as error:
            raise SolverFailed(f"cvxpy: {error}", status="solver_error") from error
    if program.status in (cp.INFEASIBLE, cp.INFEASIBLE_INACCURATE):
        return "infeasible"
    if program.status not in (cp.OPTIMAL, cp.OPTIMAL_INACCURATE):
        raise SolverFailed(f"cvxpy stopped with status {program.status}", status=program.status)
    return "optimal" if program.status == cp.OPTIMAL else "inaccurate"
