"""Choose a grasp of a part whose pose is only estimated, plan every motion of it, and say why if there is none.

You will see a grasp of a table leg from an estimate that is good to half a centimetre, what stands behind it (chance,
certificates, reasons against the other candidates), how a pillar beside the leg moves the grasp along it, a turned
leg from an STL file, three refusals with their reasons, when it pays to measure once more first, and get `plan.html`
and `turned_leg.html`, pages with the robot going through the plan and all grasps that it chose from. Takes 10 s, the
first time a minute longer: numba compiles.
"""

import sys
from pathlib import Path

import numpy as np
import trimesh

from planners import GraspPlanner, GraspRules, MeasureAgain
from planners.hand_stops import HandStops
from rfcompass import PartDatabase, PartEstimate, YouBot, view
from rfcompass.localization import NoiseModel
from rfcompass.recordings import part_from_mesh
from rfcompass.robots import hand_of
from rfcompass.types import Body, Box, GraspFailure, GraspPlan, Part, World

# Radius [m] of a turned leg against its length [m]: it has waists, so it is not convex.
PROFILE_M = [[0, -0.2], [0.02, -0.2], [0.025, -0.1], [0.015, 0.0], [0.022, 0.1], [0.012, 0.2], [0, 0.2]]


def main(fast: bool = False, out: Path = Path("runs/14_plan_a_grasp")) -> float:
    """Plan, move aside, refuse, measure again; return the chance of the first plan."""
    robot, leg = YouBot(), PartDatabase().part("table_leg_3")
    planner = GraspPlanner(robot, rules=GraspRules(samples=200 if fast else 1000))

    print("a leg across, known to 5 mm and 3 degrees")
    plan = planner.plan(leg, seen(leg, 5e-3, 3.0))
    tell(plan)
    for row in plan.certificates:
        print(f"  {row.stage:<9} {row.pairs} pairs, fcl looked {row.fcl_checks} times, "
              f"never nearer than {1e3 * row.at_least_m:.1f} mm")  # fmt: skip

    print("a pillar stands beside its middle")
    T = np.eye(4)
    T[:3, 3] = 0.50, 0.0, 0.25
    tell(planner.plan(leg, seen(leg, 5e-3, 3.0), World((Body("pillar", Box(np.array([0.04, 0.06, 0.5])), T),))))

    print("a turned leg from a file")
    out.mkdir(parents=True, exist_ok=True)
    trimesh.creation.revolve(np.array(PROFILE_M), sections=32).export(out / "leg.stl")
    turned = part_from_mesh(out / "leg.stl", "turned_leg", density_kg_m3=500.0)
    lying = seen(turned, 5e-3, 3.0)
    answer = planner.plan(turned, lying)
    tell(answer)

    print("what is refused, and why")
    for estimate in (
        PartEstimate(leg.part_id, [0.42, 0.0], None, "told", 1, leg.resting_height_m),
        seen(leg, 5e-3, 3.0, x_m=1.5),
        seen(leg, 5e-3, 3.0, height_m=0.0),
    ):
        tell(planner.plan(leg, estimate))

    measure_first(planner, leg)
    print(f"picture: {view(robot, seen(leg, 5e-3, 3.0), plan, part=leg).save(out / 'plan.html')}")
    print(f"picture: {view(robot, lying, answer, part=turned).save(out / 'turned_leg.html')}")
    return plan.success_probability


def seen(part: Part, sd_m: float, sd_deg: float, x_m: float = 0.42, height_m: float | None = None) -> PartEstimate:
    """A part across, ahead of the base, as a localizer would tell."""
    covariance = np.diag([sd_m**2, sd_m**2, np.deg2rad(sd_deg) ** 2])
    mean = np.array([x_m, 0.0, np.pi / 2])
    samples = np.random.default_rng(0).multivariate_normal(mean, covariance, 1000)
    height_m = part.resting_height_m if height_m is None else height_m
    return PartEstimate(part.part_id, mean[:2], mean[2], "told", 1, height_m, covariance, samples=samples)


def tell(answer: GraspPlan | GraspFailure) -> None:
    """Say what was found, or why nothing was."""
    if isinstance(answer, GraspFailure):
        print(f"  {answer.kind}: {answer.message}")
        return
    along_m = answer.T_part_hand[0, 3]
    print(f"  success {answer.success_probability:.2f}, {100 * along_m:+.1f} cm along the part, "
          f"{answer.duration_s:.1f} s, at least {1e3 * answer.clearance_m:.1f} mm from everything")  # fmt: skip
    against = ", ".join(f"{count} {kind}" for kind, count in answer.reasons.items())
    print(f"  of {len(answer.candidates)} candidates: {against}")


def measure_first(planner: GraspPlanner, leg: Part) -> None:
    """A leg that is known to 12 mm and 6 degrees: grasp now, or measure once more?"""
    print("known to 12 mm and 6 degrees only")
    robot, vague, rng = planner.robot, seen(leg, 12e-3, 6.0), np.random.default_rng(0)
    plan = planner.plan(leg, vague)
    adviser = MeasureAgain(robot, hand_of(robot), HandStops(robot=robot, count=12), NoiseModel(alpha_m=0.01))
    advice = adviser.advise(plan, leg, vague, robot.posture("scan"), leg.layout(4), rng)
    print(f"  {advice.message if advice else 'grasp now: another stop would not help'}")


if __name__ == "__main__":
    main(fast="--fast" in sys.argv)
