"""RF-Compass's localizer: comparisons cut the plane, a convex program takes the middle of what is left."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from rfcompass.arrays import FloatArray
from rfcompass.errors import Infeasible, InputError
from rfcompass.interfaces import ProximityMeter
from rfcompass.localization.compared_stop import ComparedStop, compared_stops
from rfcompass.localization.partition_solver import Centre, PartitionSolution, Solver, solve_partition
from rfcompass.localization.pose_fit import PoseFit, judge
from rfcompass.localization.pose_set import pose_set
from rfcompass.localization.problem import PartitionProblem, build_partition
from rfcompass.localization.reference_solver import ExtraConstraints
from rfcompass.localization.regions import region_polygon, theta_interval
from rfcompass.localization.window import MAX_MOTIONS, MAX_TRAVEL_M, recent_stops
from rfcompass.types.estimate import PartEstimate
from rfcompass.types.observation import Observation


@dataclass(frozen=True, slots=True, kw_only=True)
class PartitionLocalizer:
    """Localization by space partitioning [Wang2013], section 4.2-4.3.

    Compare the proximities of every pair of anchors for every part tag, collect the rows of the last three
    motions in the newest base frame (Eq. 2-12), raise ε from 0 in steps of 0.05 while they contradict each other,
    and take a centre of what is left (Eq. 8). If all part tags could be in one place, so far away that every one
    is nearer to the same anchors, the rows say nothing about θ: Eq. 8 reduces to Eq. 4, and θ is None.

    Attributes:
        centre: `"analytic"`, `"chebyshev"` or `"centroid"`, see `solve_partition`.
        solver: `"fast"` or `"cvxpy"`.
        transitive_reduction: Leave out rows that follow from others; moves the analytic centre only.
        bounds_m: Where the centre may lie, newest base frame [m], [[xmin, xmax], [ymin, ymax]]; 3 m about all
            anchors if None. `bounds_about(hand_tags, 0.25)` says "about the hand".
        epsilon_step: By how much ε rises.
        max_epsilon: Largest ε that is tried.
        max_motions: Length of the window in stops.
        max_travel_m: Length of the window along the base's path [m].
        meter: Measures proximities where an observation does not bring its own.
        extra_constraints: Further convex constraints on z, of four unknowns or, for a far part, two, with
            `solver="cvxpy"`. The drawn region, the interval of θ and the covariance do not know of them.

    Deviations:
        Heights of the tags are used; comparisons that follow from others are left out; the centre is bounded and
        made explicit; ε ends at 0.5; θ = atan2(s, c), while the paper does not say what it does if |(c, s)| < 1.
    """

    centre: Centre = "analytic"
    solver: Solver = "fast"
    transitive_reduction: bool = True
    bounds_m: FloatArray | None = None
    epsilon_step: float = 0.05
    max_epsilon: float = 0.5  # ours: the paper's loop has no end
    max_motions: int = MAX_MOTIONS
    max_travel_m: float = MAX_TRAVEL_M
    meter: ProximityMeter | None = None
    extra_constraints: ExtraConstraints | None = None

    def estimate(self, observations: Sequence[Observation]) -> PartEstimate:
        """Estimate the pose of the part in the newest base frame.

        Args:
            observations: Stops, newest last.

        Raises:
            InputError: If a stop has neither proximities nor a meter, or the anchors define no comparison.
            Infeasible: If no ε up to `max_epsilon` leaves comparisons that agree.
            SolverFailed: If the solver stops without a verdict.
        """
        recent = recent_stops(observations, self.max_motions, self.max_travel_m)
        return self.fit(compared_stops(recent, self.meter)).to_estimate(recent, "partition")

    def fit(self, stops: Sequence[ComparedStop]) -> PoseFit:
        """Find the pose from comparisons; the stops are taken as they are, without a window.

        Raises:
            Infeasible: If no ε up to `max_epsilon` leaves comparisons that agree.
            SolverFailed: If the solver stops without a verdict.
        """
        problem, solution = self._reject_outliers(stops)
        at_one_point = self._far_field(stops, problem)
        if at_one_point is not None:
            problem, solution = at_one_point
        theta_rad = solution.theta_rad
        verdict = judge(stops, solution.z, theta_rad)
        dropped = ~np.concatenate([stop.comparisons.used_at(problem.epsilon) for stop in stops])
        return PoseFit(
            solution.z, theta_rad, verdict.relaxed, verdict.met, verdict.total, region_polygon(problem),
            None if theta_rad is None else theta_interval(problem, theta_rad), pose_set(problem).covariance,
            np.union1d(np.flatnonzero(dropped), verdict.broken), problem.epsilon,
            diagnostics={"radius_m": solution.radius_m, "centre": solution.centre, "rows": len(problem.rows)},
        )  # fmt: skip

    def _reject_outliers(self, stops: Sequence[ComparedStop]) -> tuple[PartitionProblem, PartitionSolution]:
        """Raise ε until the rows agree [Wang2013], section 4.3.A."""
        have_margins = any(np.isfinite(stop.comparisons.margin).any() for stop in stops)
        problem, epsilon = self._build(stops, 0.0), 0.0
        solution = self._solve(problem)
        for larger in self._schedule()[1:] if have_margins else []:
            if solution.feasible or not any(stop.comparisons.used_at(larger).any() for stop in stops):
                break
            problem, epsilon = self._build(stops, larger), larger
            solution = self._solve(problem)
        if solution.feasible:
            return problem, solution
        why = f"up to ε = {epsilon:.2f}" if have_margins else "and carry no margins by which ε could choose"
        raise Infeasible(
            f"{len(problem.rows)} comparisons contradict each other, {why}; "
            "the method 'consistency' finds the pose that meets the most of them",
            rows=len(problem.rows), epsilon=epsilon, radius_m=solution.radius_m, method="consistency",
        )  # fmt: skip

    def _far_field(
        self, stops: Sequence[ComparedStop], problem: PartitionProblem
    ) -> tuple[PartitionProblem, PartitionSolution] | None:
        """Eq. 4 for the part as a whole, if all its tags can be in one place [Wang2013], section 4.2.C.

        That is so if and only if the cell of Eq. 8 holds a point with (c, s) = 0, and then it bounds no θ.
        """
        if problem.unknowns == 2:
            return None
        at_one_point = self._build(stops, problem.epsilon, as_object=True)
        solution = self._solve(at_one_point)
        return (at_one_point, solution) if solution.feasible else None

    def _schedule(self) -> list[float]:
        if self.epsilon_step <= 0.0:
            raise InputError(f"epsilon_step = {self.epsilon_step} does not rise", epsilon_step=self.epsilon_step)
        steps = int(np.floor(self.max_epsilon / self.epsilon_step + 1e-9))
        return [round(step * self.epsilon_step, 12) for step in range(steps + 1)]

    def _build(self, stops: Sequence[ComparedStop], epsilon: float, *, as_object: bool = False) -> PartitionProblem:
        return build_partition(
            stops, epsilon=epsilon, bounds_m=self.bounds_m,
            transitive_reduction=self.transitive_reduction, as_object=as_object,
        )  # fmt: skip

    def _solve(self, problem: PartitionProblem) -> PartitionSolution:
        return solve_partition(
            problem, centre=self.centre, solver=self.solver, extra_constraints=self.extra_constraints
        )  # fmt: skip
