"""The optimisation behind the numerical inverse kinematics, for any arm, with the base free if asked for.

    minimise over x    ½ |r(x)|² + ½ μ Σ_i w_i (x_i - x_i,ref)² + ½ μ_m m(x)²
    subject to         lower <= x <= upper,    h(x) >= clearance

x are the joints between base and tool, then x, y, θ of the base if it may drive. The residual r holds what the task
asks for [m], directions times `DIRECTION_WEIGHT_M`:

    tool(x) - point,    approach(x) - approach,    closing(x) - closing,    e_z·axes(x) - e_z·axes

each with a weight of 0 or 1; the last one, for tasks with any heading, replaces the two before. h holds the distance of
each moving link from the nearest of the floor, the boxes (the standing links, the world), and the other links, all
links as spheres (`link_spheres`).

The manipulability w = √det(J_p J_pᵀ) of the tool's position [Yoshikawa1985] enters as m = 1 / (1 + w / w0), which is
one where the arm is singular; w0 is its mean over random postures. μ_m is zero unless asked for.

The Gauss-Newton Hessian JᵀJ + μ W needs no second derivatives, and without a task the posture term makes it regular.
"""

import threading
from collections import OrderedDict
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import casadi as ca
import numpy as np

from planners.link_spheres import Spheres, cover
from planners.symbolic_fk import Pose, SymbolicKinematics, planar
from rfcompass.arrays import FloatArray
from rfcompass.robots import CollisionModel, Robot
from rfcompass.robots.solids import Solid
from rfcompass.robots.touching_links import random_joints
from rfcompass.types.world import WORLD

# Ours: a turn of 1 rad weighs as much as 0.2 m, about half the reach of a small arm.
DIRECTION_WEIGHT_M = 0.2
# Ours: the pull of the reference posture, small beside the task; the task is then met exactly by Newton steps.
POSTURE = 1e-5
# Programs that a thread keeps.
_KEPT = 8
_LOCAL = threading.local()
# A box parameter: rotation by columns, position, half edges.
BOX = 15

# daqp solves the quadratic programs. casadi's own qrqp is as fast and finds the same, but after some hundred of these
# problems the process ends with damaged memory (casadi 3.8.2).
_SQP: dict[str, Any] = {
    "print_header": False, "print_iteration": False, "print_status": False, "print_time": False, "error_on_fail": False,
    "max_iter": 25, "tol_pr": 1e-6, "tol_du": 1e-6, "qpsol": "daqp",
    "qpsol_options": {"print_time": False, "error_on_fail": False},
}  # fmt: skip
_IPOPT: dict[str, Any] = {
    "print_time": False, "ipopt.print_level": 0, "ipopt.sb": "yes", "ipopt.max_iter": 60, "error_on_fail": False,
}  # fmt: skip


@dataclass(eq=False)
class IkProgram:
    """The functions of one robot among so many boxes.

    Args:
        model: Robot and world; only the number of the world's standing solids and whether there is a floor matter.
        base_free: The base may drive.
        manipulability: Weight μ_m of the manipulability term [m²].
    """

    model: CollisionModel
    base_free: bool
    manipulability: float = 0.0
    x: Any = field(init=False, repr=False)
    p: Any = field(init=False, repr=False)

    def __post_init__(self) -> None:
        """Make the variables and the parameters."""
        self.x = ca.SX.sym("x", len(self.robot.arm_joints) + 3 * self.base_free)
        self._parts = {
            "task": ca.SX.sym("task", 9),
            "weights": ca.SX.sym("weights", 3),
            "joints": ca.SX.sym("joints", len(self.robot.joint_names)),
            "reference": ca.SX.sym("reference", self.x.numel()),
            "pull": ca.SX.sym("pull", self.x.numel()),
            "size": ca.SX.sym("size", 1),
            "floor": ca.SX.sym("floor", 1),
            "boxes": ca.SX.sym("boxes", BOX * len(self.standing)),
        }
        self.p = ca.vertcat(*self._parts.values())

    @property
    def robot(self) -> Robot:
        """Whose arm."""
        return self.model.robot

    @cached_property
    def standing(self) -> list[Solid]:
        """Solids of the world that stand still."""
        return [solid for solid in self.model.solids if solid.carrier == WORLD]

    def parameters(self, **parts: FloatArray | float) -> FloatArray:
        """Values of the parameters by name, in their order."""
        return np.concatenate([np.ravel(parts[name]) for name in self._parts])

    @cached_property
    def columns(self) -> list[int]:
        """Places of the arm's joints among all joint values."""
        return [self.robot.joint_names.index(name) for name in self.robot.arm_joints]

    @cached_property
    def residual(self) -> Any:  # noqa: ANN401 - casadi has no types
        """Function (x, p) -> r, dr/dx."""
        r = self._residual
        return ca.Function("residual", [self.x, self.p], [r, ca.densify(ca.jacobian(r, self.x))])

    @cached_property
    def guard(self) -> Any:  # noqa: ANN401
        """Function (x, p) -> h, the distances [m]."""
        return ca.Function("guard", [self.x, self.p], [self._distances])

    @cached_property
    def plain(self) -> Any:  # noqa: ANN401
        """SQP solver without distances."""
        return self._sqp({"x": self.x, "p": self.p, "f": self._objective})

    @cached_property
    def guarded(self) -> Any:  # noqa: ANN401
        """SQP solver with distances."""
        return self._sqp({"x": self.x, "p": self.p, "f": self._objective, "g": self._distances})

    @cached_property
    def fallback(self) -> Any:  # noqa: ANN401
        """Interior-point solver with distances."""
        program = {"x": self.x, "p": self.p, "f": self._objective, "g": self._distances}
        return ca.nlpsol("fallback", "ipopt", program, _IPOPT)

    @cached_property
    def nearest(self) -> Any:  # noqa: ANN401
        """Interior-point solver without distances, for tasks out of reach: their residual stays, and it bends."""
        program = {"x": self.x, "p": self.p, "f": self._objective}
        return ca.nlpsol("nearest", "ipopt", program, _IPOPT)

    def _sqp(self, program: dict[str, Any]) -> Any:  # noqa: ANN401
        J = ca.jacobian(ca.vertcat(self._residual, self._dexterity), self.x)
        H = ca.densify(J.T @ J + ca.diag(POSTURE * self._parts["pull"]))
        rows = program["g"].numel() if "g" in program else 0
        scale, multipliers = ca.SX.sym("scale"), ca.SX.sym("multipliers", rows)
        hessian = ca.Function("hessian", [self.x, self.p, scale, multipliers], [scale * H])
        return ca.nlpsol("sqp", "sqpmethod", program, {**_SQP, "hess_lag": hessian})

    @cached_property
    def _objective(self) -> Any:  # noqa: ANN401
        away = self.x - self._parts["reference"]
        posture = ca.dot(self._parts["pull"], away**2)
        return 0.5 * (ca.sumsqr(self._residual) + ca.sumsqr(self._dexterity) + POSTURE * posture)

    @cached_property
    def _dexterity(self) -> Any:  # noqa: ANN401
        """√μ_m m(x); nothing without a weight."""
        if self.manipulability == 0.0:
            return ca.SX(0, 1)
        draws = random_joints(self.robot, np.random.default_rng(0), 100)[:, self.columns]
        w0 = np.mean([float(self.dexterity(draw)) for draw in draws])
        return np.sqrt(self.manipulability) / (1 + self._measure(self.x[: len(self.columns)]) / w0)

    @cached_property
    def dexterity(self) -> Any:  # noqa: ANN401
        """Function of the arm's joints -> w, the manipulability of the tool's position."""
        arm = ca.SX.sym("arm", len(self.columns))
        return ca.Function("dexterity", [arm], [self._measure(arm)])

    def _measure(self, arm: Any) -> Any:  # noqa: ANN401
        joints = ca.SX.zeros(len(self.robot.joint_names))
        turned = ca.SX.sym("turned", len(self.columns))
        for i, column in enumerate(self.columns):
            joints[column] = turned[i]
        position = SymbolicKinematics(self.robot, joints).pose(self.robot.tool.frame).p
        J = ca.jacobian(position, turned)
        w = ca.sqrt(ca.fmax(ca.det(J @ J.T), 1e-24))
        return ca.substitute(w, turned, arm)

    @cached_property
    def _kinematics(self) -> SymbolicKinematics:
        count = len(self.columns)
        joints = ca.SX(self._parts["joints"])
        for i, column in enumerate(self.columns):
            joints[column] = self.x[i]
        base = planar(*(self.x[count + i] for i in range(3))) if self.base_free else None
        return SymbolicKinematics(self.robot, joints, base)

    @cached_property
    def _residual(self) -> Any:  # noqa: ANN401
        tool, w = self.robot.tool, self._parts["weights"]
        pose = self._kinematics.pose(tool.frame)
        approach, closing = pose.R @ tool.approach_axis, pose.R @ tool.closing_axis
        point, a, c = (self._parts["task"][3 * i : 3 * i + 3] for i in range(3))
        heights = [w[0] * (approach[2] - a[2]), w[1] * (closing[2] - c[2])]
        heights.append(w[0] * w[1] * (ca.cross(approach, closing)[2] - ca.cross(a, c)[2]))
        fixed = 1 - w[2]
        turned = [w[0] * fixed * (approach - a), w[1] * fixed * (closing - c), w[2] * ca.vertcat(*heights)]
        return ca.vertcat(pose.p - point, *(DIRECTION_WEIGHT_M * row for row in turned))

    @cached_property
    def _distances(self) -> Any:  # noqa: ANN401
        """For each moving solid: from the floor, from the nearest box, from the nearest other solid."""
        moving, boxes = self._moving, self._boxes
        near: dict[int, list[Any]] = {i: [] for i in moving}
        floor = [self._lowest(moving[i]) for i in self.model.over_floor if i in moving]
        for i, j in self.model.pairs:
            for a, b in ((i, j), (j, i)):
                if a in moving and b in boxes:
                    near[a].append(self._from_box(moving[a], boxes[b]))
        joints = self.model.joints_of_solids
        linked = [(i, j) for i, j in self.model.pairs if joints[i] > 0 and joints[j] > 0]
        links = [self._apart(moving[i], moving[j]) for i, j in linked]
        return ca.vertcat(*floor, *(_smallest(rows) for rows in near.values() if rows), *links)

    @cached_property
    def _moving(self) -> dict[int, "_Placed"]:
        """Solids that move against the world, as placed spheres."""
        least = 0 if self.base_free else 1
        chosen = [i for i, joint in enumerate(self.model.joints_of_solids) if joint >= least]
        return {i: self._placed(cover(self.model.solids[i])) for i in chosen}

    @cached_property
    def _boxes(self) -> dict[int, "_Box"]:
        """Standing links, where the base stands or is driven, and the world's boxes, which are parameters."""
        boxes = {}
        for i, solid in enumerate(self.model.solids):
            if self.model.joints_of_solids[i] == 0:
                T = solid.T_carrier_box
                local = Pose(ca.DM(T[:3, :3]), ca.DM(T[:3, 3]))
                boxes[i] = _Box(self._kinematics.pose(solid.carrier) @ local, ca.DM(solid.half_size_m))
        world = [i for i, solid in enumerate(self.model.solids) if solid.carrier == WORLD]
        for k, i in enumerate(world):
            row = self._parts["boxes"][BOX * k : BOX * (k + 1)]
            boxes[i] = _Box(Pose(ca.reshape(row[:9], 3, 3), row[9:12]), row[12:15])
        return boxes

    def _placed(self, spheres: Spheres) -> "_Placed":
        pose = self._kinematics.pose(spheres.carrier)
        size = self._parts["size"]
        radius = (1 - size) * spheres.inner_m + size * spheres.outer_m
        return _Placed([pose.act(ca.DM(centre)) for centre in spheres.centres_m], radius)

    def _lowest(self, placed: "_Placed") -> Any:  # noqa: ANN401
        return _smallest([centre[2] - placed.radius - self._parts["floor"] for centre in placed.centres])

    @staticmethod
    def _from_box(placed: "_Placed", box: "_Box") -> Any:  # noqa: ANN401
        return _smallest([box.distance(centre) for centre in placed.centres]) - placed.radius

    @staticmethod
    def _apart(first: "_Placed", second: "_Placed") -> Any:  # noqa: ANN401
        pairs = [(a, b) for a in first.centres for b in second.centres]
        return _smallest([_length(a - b) for a, b in pairs]) - first.radius - second.radius


@dataclass(frozen=True, slots=True)
class _Placed:
    centres: list[Any]
    radius: Any


@dataclass(frozen=True, slots=True)
class _Box:
    pose: Pose
    half: Any

    def distance(self, point: Any) -> Any:  # noqa: ANN401
        """Signed distance of a point from the box [m]."""
        beyond = ca.fabs(self.pose.R.T @ (point - self.pose.p)) - self.half
        inside = ca.fmin(ca.fmax(ca.fmax(beyond[0], beyond[1]), beyond[2]), 0)
        return _length(ca.fmax(beyond, 0)) + inside


def _length(vector: Any) -> Any:  # noqa: ANN401
    """Length with a derivative everywhere: a nanometre is added."""
    return ca.sqrt(ca.sumsqr(vector) + 1e-18)


def _smallest(rows: Sequence[Any]) -> Any:  # noqa: ANN401
    smallest = rows[0]
    for row in rows[1:]:
        smallest = ca.fmin(smallest, row)
    return smallest


def recent_program(model: CollisionModel, base_free: bool, manipulability: float = 0.0) -> IkProgram:
    """A program for a model; one that was made for a like world, if this thread made one lately.

    Worlds are alike if the same robot looks at the same pairs among as many standing solids: where these stand and how
    large they are, are parameters. Making a program takes up to 0.2 s, most of it for the distances.
    """
    recent: OrderedDict[tuple[object, ...], IkProgram] = _LOCAL.__dict__.setdefault("recent", OrderedDict())
    standing = sum(solid.carrier == WORLD for solid in model.solids)
    links = model.solids[: len(model.solids) - standing]
    sizes = tuple((solid.carrier, *solid.half_size_m.tolist(), *solid.T_carrier_box.ravel()) for solid in links)
    key = (id(model.robot), base_free, manipulability, standing, sizes, model.pairs, model.over_floor)
    if key not in recent:
        recent[key] = IkProgram(model, base_free, manipulability)
    recent.move_to_end(key)
    while len(recent) > _KEPT:
        recent.popitem(last=False)
    return recent[key]


def box_parameters(solids: Sequence[Solid]) -> FloatArray:
    """Parameters of the world's boxes: bounding boxes of solids, shape (15 B,)."""
    rows = [[T[:3, :3].T.ravel(), T[:3, 3], solid.half_size_m] for solid in solids for T in [solid.T_carrier_box]]
    return np.concatenate([np.zeros(0), *(np.concatenate(row) for row in rows)])
