"""Inverse kinematics of the youBot beside pinocchio's damped least squares and pink, in one run on one thread.

Tasks are tool poses of random arm postures that touch nothing, so that five joints can do each of them, and the peers
are asked for the whole pose. *Warm* starts 0.1 rad beside the posture that made the task, *cold* from the posture
"scan". Solved means: within 1e-6 m and 1e-6 rad, inside the joint limits. What we solve touches nothing either; the
peers do not look. Times are medians of the CPU time of one solve, failures included; ours include the check of limits,
pose and collisions, without the certificate by fcl, which is timed apart.

    OMP_NUM_THREADS=1 python -m benchmarks.bench_ik [--fast]

pink is timed where it is installed (`pip install pin-pink daqp`).
"""

import importlib.util
import sys
import time
from collections.abc import Callable, Sequence

import numpy as np
import pinocchio as pin

from benchmarks.timing import Timing, show
from planners.closed_form import REACHED, solve_all
from planners.ik import IkRules, InverseKinematics
from planners.planar_arm import read_planar_arm
from rfcompass.arrays import FloatArray
from rfcompass.robots import CollisionModel, FclCollisions, QuickCollisions, YouBot
from rfcompass.types import Configuration, GraspTask, Solution

ROBOT = YouBot()
SCAN = ROBOT.posture("scan")
QUICK = QuickCollisions(CollisionModel(ROBOT))
STEPS = 200
Solver = Callable[["pin.SE3", FloatArray], FloatArray]


def run(fast: bool = False, seed: int = 31) -> list[Timing]:
    """Time everything; the names say how many tasks were solved."""
    batch, ours, theirs = (100, 10, 5) if fast else (10_000, 1000, 200)
    arms = free_arms(batch, np.random.default_rng(seed))
    peers: dict[str, Solver] = {"pinocchio damped least squares": damped_least_squares()}
    if importlib.util.find_spec("pink") is not None:
        peers["pink + daqp"] = with_pink()
    rng = np.random.default_rng(seed + 1)
    near = np.clip(arms + rng.uniform(-0.1, 0.1, arms.shape), ROBOT.limits.soft_lower[:5], ROBOT.limits.soft_upper[:5])
    starts = {"warm": near, "cold": np.tile(SCAN.joints[:5], (batch, 1))}
    batch_s, solved = closed_form_batch(arms)
    rows = []
    for how, begin in starts.items():
        single_s, single = time_ours("closed_form", arms[:ours], begin)
        nlp_s, nlp = time_ours("nlp", arms[:ours], begin)
        for name, peer in peers.items():
            peer_s, share, touching = time_peer(peer, arms[:theirs], begin)
            label = f"{name}, {how}, no check: {share:.1%}, {touching:.0%} touch"
            rows.append(
                Timing(f"IK, closed form, batch of {batch}: {solved:.1%} solved", batch_s, label, peer_s, np.nan)
            )
            rows.append(
                Timing(f"IK, closed form and collision check, {how}: {single:.1%}", single_s, label, peer_s, np.nan)
            )
            rows.append(Timing(f"IK, optimisation and collision check, {how}: {nlp:.1%}", nlp_s, label, peer_s, np.nan))
    rows.append(time_checks(arms[:ours]))
    return rows


def free_arms(count: int, rng: np.random.Generator) -> FloatArray:
    """Arm joints inside the soft limits that touch nothing with the hand open, (count, 5)."""
    found: list[FloatArray] = []
    while len(found) < count:
        arm = rng.uniform(ROBOT.limits.soft_lower[:5], ROBOT.limits.soft_upper[:5])
        if not QUICK.collides(whole(arm)):
            found.append(arm)
    return np.array(found)


def whole(arm: FloatArray) -> Configuration:
    """An arm posture with the hand open."""
    return Configuration(np.concatenate([arm, SCAN.joints[5:]]))


def task_of(arm: FloatArray) -> GraspTask:
    """Task that an arm posture does."""
    T = ROBOT.tool_pose(whole(arm)).homogeneous
    return GraspTask.of_pose(T, ROBOT.tool.approach_axis, ROBOT.tool.closing_axis)


def closed_form_batch(arms: FloatArray) -> tuple[float, float]:
    """Time of one pose in a batch [s], and the share solved."""
    tasks = [task_of(arm) for arm in arms]
    rows = np.array([np.concatenate([task.point_m, task.approach, task.closing]) for task in tasks])
    arm, near = read_planar_arm(ROBOT, soft=True), SCAN.joints[:5].copy()
    solve_all(arm, rows[:1], near, True)
    start = time.process_time()
    _, status, *_ = solve_all(arm, rows, near, True)
    return (time.process_time() - start) / len(rows), float((status == REACHED).any(axis=1).mean())


def time_ours(method: str, arms: FloatArray, starts: FloatArray) -> tuple[float, float]:
    """Median time of one call of `InverseKinematics.solve` [s], and the share solved."""
    ik = InverseKinematics(ROBOT, rules=IkRules(method=method, certify=False))
    ik.solve(task_of(arms[0]), SCAN)
    times, solved = [], 0
    for arm, start in zip(arms, starts, strict=False):
        task, begin = task_of(arm), whole(start)
        clock = time.process_time()
        solved += isinstance(ik.solve(task, begin), Solution)
        times.append(time.process_time() - clock)
    return float(np.median(times)), solved / len(arms)


def time_peer(solve: Solver, arms: FloatArray, starts: FloatArray) -> tuple[float, float, float]:
    """Median time of one solve [s], the share solved, and the share of those in which something touches."""
    times, solved, touching = [], 0, 0
    for arm, start in zip(arms, starts, strict=False):
        target = ROBOT.tool_pose(whole(arm))
        clock = time.process_time()
        answer = solve(target, start)
        times.append(time.process_time() - clock)
        if (found := _does(answer, target)) and QUICK.collides(whole(answer)):
            touching += 1
        solved += found
    return float(np.median(times)), solved / len(arms), touching / max(1, solved)


def _does(arm: FloatArray, target: "pin.SE3") -> bool:
    T = ROBOT.tool_pose(whole(arm))
    near = np.linalg.norm(T.translation - target.translation) < 1e-6
    turned = np.linalg.norm(pin.log3(T.rotation.T @ target.rotation)) < 1e-6
    lower, upper = ROBOT.limits.soft_lower[:5], ROBOT.limits.soft_upper[:5]
    return bool(near and turned and (arm >= lower - 1e-9).all() and (arm <= upper + 1e-9).all())


def arm_model() -> tuple["pin.Model", int, "pin.SE3"]:
    """Pinocchio's model of the arm alone, the number of the tool's frame in it, and the base over its root."""
    model = ROBOT.kinematics.model
    locked = [model.getJointId(name) for name in ROBOT.joint_names[5:]]
    reduced = pin.buildReducedModel(model, locked, np.zeros(model.nq))
    reduced.lowerPositionLimit, reduced.upperPositionLimit = ROBOT.limits.soft_lower[:5], ROBOT.limits.soft_upper[:5]
    return reduced, reduced.getFrameId(ROBOT.tool.frame), ROBOT.kinematics.T_base_root.inverse()


def damped_least_squares(damping: float = 1e-4) -> Solver:
    """The loop of pinocchio's own example, with whole steps, clipped to the joint limits."""
    model, frame, T_root_base = arm_model()
    data = model.createData()

    def solve(target: "pin.SE3", start: FloatArray) -> FloatArray:
        q, goal = start.copy(), T_root_base * target
        for _ in range(STEPS):
            pin.framesForwardKinematics(model, data, q)
            error = pin.log6(data.oMf[frame].actInv(goal)).vector
            if np.linalg.norm(error) < 5e-7:
                break
            J = pin.computeFrameJacobian(model, data, q, frame)
            step = J.T @ np.linalg.solve(J @ J.T + damping * np.eye(6), error)
            q = np.clip(q + step, model.lowerPositionLimit, model.upperPositionLimit)
        return q

    return solve


def with_pink() -> Solver:
    """Run the loop of pink: one frame task, the limits of the joints, daqp."""
    import pink  # noqa: PLC0415 - a peer, not a dependency
    from pink.limits import ConfigurationLimit  # noqa: PLC0415

    model, _, T_root_base = arm_model()
    data = model.createData()
    limits = [ConfigurationLimit(model)]

    def solve(target: "pin.SE3", start: FloatArray) -> FloatArray:
        configuration = pink.Configuration(model, data, start)
        task = pink.FrameTask(ROBOT.tool.frame, position_cost=1.0, orientation_cost=0.2)
        task.set_target(T_root_base * target)
        for _ in range(STEPS):
            if np.linalg.norm(task.compute_error(configuration)) < 5e-7:
                break
            velocity = pink.solve_ik(configuration, [task], 1.0, solver="daqp", limits=limits, safety_break=False)
            q = np.clip(configuration.integrate(velocity, 1.0), model.lowerPositionLimit, model.upperPositionLimit)
            configuration.update(q)
        return np.asarray(configuration.q)

    return solve


def time_checks(arms: FloatArray) -> Timing:
    """One collision check in the hot loop beside fcl's certificate, and how often they disagree."""
    slow = FclCollisions(QUICK.model)
    seconds, answers = [], []
    for checker in (QUICK, slow):
        start = time.process_time()
        answers.append([checker.collides(whole(arm)) for arm in arms])
        seconds.append((time.process_time() - start) / len(arms))
    differ = float(np.mean(np.array(answers[0]) != answers[1]))
    return Timing("collision check of a free posture", seconds[0], "python-fcl's manager", seconds[1], differ)


def main(argv: Sequence[str] | None = None) -> int:
    """Print the table."""
    show(run("--fast" in (sys.argv[1:] if argv is None else argv)))
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
