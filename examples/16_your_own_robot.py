"""Your own robot: a URDF, where its tags are, and along which axes its tool works. Nothing else is asked.

Two arms are made usable from scratch: a UR5e with a two-finger hand, whose URDF is a plain file, and a Franka Panda out
of the robots extra, whose URDF names its files by package and has meshes that only its collision shapes can stand in
for. For each: what is wrong with the URDF, where the tags are, how to grasp a table leg, where else one could grasp.

You will see the tags' positions from forward kinematics, a posture that grasps, the share of grasps from above that the
arm can do, a plan with its chance, and get `my_ur5e.html` and `my_panda.html`, pages with the arm lifting the leg and a
map of its reach. Takes 20 s.
"""

import json
import sys
from importlib.resources import files
from pathlib import Path

import numpy as np

from planners import GraspPlanner, IkRules, InverseKinematics, MapMaker, TaskMap, top_down
from rfcompass import Part, PartDatabase, PartEstimate, Robot, load_robot, view
from rfcompass.robots import CollisionModel, always_touching, check_urdf, hand_of, known_robots
from rfcompass.types import Body, GraspPlan, GraspTask, SearchVolume, Solution, World

EXTRA = "package://example-robot-data/robots/panda_description/urdf/panda.urdf"
DOWN, FORE_AFT = np.array([0, 0, -1.0]), np.array([1.0, 0, 0])
UR5E = {
    "schema": "rfcompass-robot/1", "name": "my_ur5e", "base": "fixed", "base_frame": "base_link",
    "tool_frame": "gripper_tool_link", "approach_axis": [0, 0, 1], "closing_axis": [0, 1, 0],
    "postures": {"ready": {
        "shoulder_lift_joint": -1.6, "elbow_joint": -1.9, "wrist_1_joint": -1.2,
        "wrist_2_joint": 1.57, "gripper_finger_joint_l": 0.0425, "gripper_finger_joint_r": 0.0425,
    }},
}  # fmt: skip
PANDA = {
    "schema": "rfcompass-robot/1", "name": "my_panda", "urdf": EXTRA, "base": "fixed", "base_frame": "panda_link0",
    "tool_frame": "panda_hand_tcp", "approach_axis": [0, 0, 1], "closing_axis": [0, 1, 0],
    "postures": {"ready": {
        "panda_joint2": -0.785, "panda_joint4": -2.356, "panda_joint6": 1.571, "panda_joint7": 0.785,
        "panda_finger_joint1": 0.04,
    }},
}  # fmt: skip


def main(fast: bool = False, out: Path = Path("runs/16_your_own_robot")) -> dict[str, float]:
    """Describe, check and use two arms; return the share of grasps from above that each can do."""
    out.mkdir(parents=True, exist_ok=True)
    urdf = Path(str(files("urdf"))) / "ur5e_2f85.urdf"  # yours comes from anywhere
    shares = {"my_ur5e": use(describe(out, {**UR5E, "urdf": str(urdf)}, hand="gripper_palm_link"), fast, out)}
    if "panda" in known_robots():
        shares["my_panda"] = use(describe(out, PANDA, hand="panda_hand"), fast, out)
    else:
        print("for the Panda: pip install 'rfcompass[robots]'")
    return shares


def describe(out: Path, robot: dict[str, object], hand: str) -> Robot:
    """Write the two files that make a robot out of a URDF, and load it: four tags around its hand, two on its foot."""
    around_hand = [(0, 0.08, 0.02), (0, -0.08, 0.02), (0.08, 0, 0.02), (-0.08, 0, 0.02)]
    on_foot = [(0.1, 0.05, 0.06), (0.1, -0.05, 0.06)]
    places = [(hand, point_m, "hand") for point_m in around_hand]
    places += [(robot["base_frame"], point_m, "base_front") for point_m in on_foot]
    tags = [
        {"epc": f"3008{index:020x}", "link": link, "point_m": point_m, "dipole": [0, 0, 1], "role": role}
        for index, (link, point_m, role) in enumerate(places)
    ]
    layout = {"schema": "rfcompass-tags/1", "description": "Never mounted on a real one.", "tags": tags}
    (out / f"{robot['name']}_tags.json").write_text(json.dumps(layout, indent=1))
    file = out / f"{robot['name']}.json"
    file.write_text(json.dumps({**robot, "tag_layout": f"{robot['name']}_tags.json"}, indent=1))
    return load_robot(file)


def use(robot: Robot, fast: bool, out: Path) -> float:
    """Check a robot, find its tags, grasp with it, map its reach, and draw all that."""
    report = check_urdf(robot.description.urdf)
    print(f"{robot.name}: {len(report.moving)} moving joints, {len(report.errors)} errors")
    for defect in report.defects[:2]:
        print(f"  {defect.severity}: {defect.message}")

    print(f"  its hand opens to {1e3 * hand_of(robot).greatest_m:.0f} mm")

    ready = robot.posture("ready")
    for link, point_m in zip(robot.layout.frames, robot.tag_positions(ready).points_m, strict=True):
        print(f"  a tag on {link} is at {point_m.round(3)} m")

    leg = PartDatabase().part("table_leg_3")
    model = around(robot, leg)
    answer = InverseKinematics(robot, model=model).solve(GraspTask([0.5, 0.0, 0.04], DOWN, FORE_AFT), ready)
    posture = np.rad2deg(answer.configuration.joints[:6]).round(0) if isinstance(answer, Solution) else answer.message
    print(f"  around a table leg: {posture}")

    reach = ahead(robot, model, fast)
    spread = np.diag([0.01**2, 0.008**2, np.deg2rad(4) ** 2])  # the leg lies across, known to a centimetre, 4 degrees
    estimate = PartEstimate(leg.part_id, [0.5, 0.0], np.pi / 2, "told", 1, leg.resting_height_m, covariance=spread)
    plan = GraspPlanner(robot).plan(leg, estimate, start=ready)
    told = f"succeeds with {plan.success_probability:.2f}" if isinstance(plan, GraspPlan) else plan.message
    print(f"  the best of {len(plan.candidates)} grasps: {told}; rejected: {plan.reasons}")
    page = view(robot, estimate, plan, part=leg, reach=reach.reach_map, at=ready).save(out / f"{robot.name}.html")
    print(f"  picture: {page}")
    return float(reach.reached.mean())


def around(robot: Robot, leg: Part) -> CollisionModel:
    """What the robot must not touch: the floor, and the leg across in front of it."""
    T_base_leg = np.eye(4)
    T_base_leg[:2, :2], T_base_leg[:3, 3] = [[0, -1], [1, 0]], (0.5, 0.0, leg.resting_height_m)
    world = World((Body("leg", leg.shape, T_base_leg),))
    return CollisionModel(robot, world, allowed=always_touching(robot))


def ahead(robot: Robot, model: CollisionModel, fast: bool) -> TaskMap:
    """Which grasps from above the arm can do in front of it."""
    rules = IkRules(certify=False, explain=False)
    empty = CollisionModel(robot, allowed=model.allowed)
    volume = SearchVolume([0.3, -0.3, 0.05], [0.9, 0.3, 0.06])
    maker = MapMaker(ik=InverseKinematics(robot, model=empty, rules=rules), spacing_m=0.3 if fast else 0.1, spread=True)
    made = maker.make(volume, top_down(2 if fast else 4), robot.posture("ready"), np.random.default_rng(0))
    print(f"  of {made.reached.size} grasps from above the arm can do {made.reached.mean():.0%}")
    return made


if __name__ == "__main__":
    main(fast="--fast" in sys.argv)
