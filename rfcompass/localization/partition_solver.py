"""Find a centre of the partition: Eq. 4 and Eq. 8 of [Wang2013] with the centre made explicit."""

from dataclasses import dataclass
from typing import Literal, TypeAlias

import numpy as np

from rfcompass.arrays import FloatArray, read_only
from rfcompass.errors import InputError
from rfcompass.localization import fast_solver, reference_solver
from rfcompass.localization.pose_set import pose_set
from rfcompass.localization.problem import PartitionProblem
from rfcompass.localization.reference_solver import ExtraConstraints
from rfcompass.localization.scaled_rows import ScaledRows, scale_rows
from rfcompass.types.record import Record

Centre: TypeAlias = Literal["analytic", "chebyshev", "centroid"]
Solver: TypeAlias = Literal["fast", "cvxpy"]

SMALLEST_RADIUS_M = 1e-7  # ours: a thinner cell counts as empty; rows that meet in one line have radius 0


@dataclass(frozen=True, slots=True)
class PartitionSolution(Record):
    """A centre of the cell that the rows cut out.

    Attributes:
        z: [x0, y0] or [x0, y0, c, s] in the newest base frame [m, m, 1, 1]; where the rows contradict each
            other, the point that breaks them least, shape (2,) or (4,).
        radius_m: Radius of the largest ball in the cell, with c and s scaled by 0.2 m and the disc replaced by
            the 64-gon around it [m]; negative where the rows contradict each other.
        feasible: Whether the cell holds a pose.
        centre: Which centre z is.
        solver: Which solver found it.
        epsilon: Confidence threshold of the problem.
    """

    z: FloatArray
    radius_m: float
    feasible: bool
    centre: Centre
    solver: Solver
    epsilon: float

    def __post_init__(self) -> None:
        """Freeze z."""
        object.__setattr__(self, "z", read_only(self.z, "PartitionSolution.z", (None,)))

    @property
    def orientation_norm(self) -> float | None:
        """|(c, s)|, at most 1: how firmly the rows hold the orientation; None if it is no unknown."""
        return float(np.hypot(*self.z[2:])) if self.z.size == 4 else None

    @property
    def theta_rad(self) -> float | None:
        """θ = atan2(s, c) [rad]; None if the orientation is no unknown or (c, s) = 0."""
        return float(np.arctan2(self.z[3], self.z[2])) if self.orientation_norm else None


def solve_partition(
    problem: PartitionProblem,
    *,
    centre: Centre = "analytic",
    solver: Solver = "fast",
    extra_constraints: ExtraConstraints | None = None,
) -> PartitionSolution:
    """Find a centre of {z : A z <= b, c² + s² <= 1, z in the bounds} [Wang2013], Eq. 4 and Eq. 8.

    - `"analytic"`: argmin of -Σ log(b - A z) - log(1 - c² - s²) over all rows and the four of the bounds, what an
      interior-point method tends to [Boyd2004]. Does not depend on scales. Each row repels, implied ones too.
    - `"chebyshev"`: centre of the largest ball, with c and s scaled by 0.2 m and a 64-gon in place of the disc.
    - `"centroid"`: mean of (x0, y0, cos θ, sin θ) over all poses that meet all rows with c² + s² = 1, every
      x0, y0, θ weighing the same. A mean of such points lies in the cell, so it solves Eq. 8 too. Where the cell
      holds no such pose the analytic centre is returned, and `centre` says so.

    Args:
        problem: Rows and bounds.
        centre: Which centre to find.
        solver: `"fast"`, or `"cvxpy"` as reference and for extra constraints.
        extra_constraints: Takes the cvxpy expression z, returns further convex constraints on it, for example a
            wall or a heading cone. Needs `solver="cvxpy"`.

    Raises:
        InputError: If extra constraints come with the fast solver or with the centroid, or a name is unknown.
        SolverFailed: If the solver stops without a verdict.

    Deviations:
        The paper minimises 0, so that its solver's path decides which point comes out, and an open cell has no
        centre.
    """
    _check_choice(centre, solver, extra_constraints)
    scaled = scale_rows(problem)
    ball, radius_m = _largest_ball(scaled, solver, extra_constraints)
    z = scaled.to_metric(ball)
    if radius_m <= SMALLEST_RADIUS_M:
        return PartitionSolution(z, radius_m, False, "chebyshev", solver, problem.epsilon)
    if centre == "centroid" and (mean := pose_set(problem).mean_z) is not None:
        return PartitionSolution(mean, radius_m, True, centre, solver, problem.epsilon)
    if centre == "chebyshev":
        return PartitionSolution(z, radius_m, True, centre, solver, problem.epsilon)
    y = _analytic_centre(scaled, solver, ball, extra_constraints)
    if y is None:
        return PartitionSolution(z, radius_m, False, "chebyshev", solver, problem.epsilon)
    return PartitionSolution(scaled.to_metric(y), radius_m, True, "analytic", solver, problem.epsilon)


def _largest_ball(scaled: ScaledRows, solver: Solver, extra: ExtraConstraints | None) -> tuple[FloatArray, float]:
    return fast_solver.largest_ball(scaled) if solver == "fast" else reference_solver.largest_ball(scaled, extra)


def _analytic_centre(
    scaled: ScaledRows, solver: Solver, ball: FloatArray, extra: ExtraConstraints | None
) -> FloatArray | None:
    if solver == "fast":
        return fast_solver.analytic_centre(scaled, ball)
    return reference_solver.analytic_centre(scaled, ball, extra)


def _check_choice(centre: str, solver: str, extra: ExtraConstraints | None) -> None:
    if centre not in ("analytic", "chebyshev", "centroid"):
        raise InputError(f"no centre {centre!r}: analytic, chebyshev or centroid", centre=centre)
    if solver not in ("fast", "cvxpy"):
        raise InputError(f"no solver {solver!r}: fast or cvxpy", solver=solver)
    if extra is not None and (solver != "cvxpy" or centre == "centroid"):
        raise InputError("extra constraints need solver='cvxpy' and a centre of a convex set", solver=solver)
