"""Collision checks for the hot loop: pinocchio's geometry model, with coal underneath."""

from typing import Any

import coal
import numpy as np
import pinocchio as pin

from rfcompass.arrays import FloatArray
from rfcompass.geometry.pose2 import Pose2
from rfcompass.robots.collision_model import CollisionModel, homogeneous
from rfcompass.robots.solids import Solid
from rfcompass.types.configuration import Configuration
from rfcompass.types.world import FLOOR, WORLD, Clearance

# With coal's defaults one touch in 50 000 configurations was missed, 0.1 mm deep: without contacts it stops early.
_GJK_TOLERANCE = 1e-8


class QuickCollisions:
    """Booleans and signed distances at many configurations. Not to be shared among threads.

    Args:
        model: Robot and world.

    Attributes:
        pair_names: Owners of the solids of each pair (P).
        pair_solids: Indices of the two solids of each pair in `model.solids`; None for the floor (P).
    """

    def __init__(self, model: CollisionModel) -> None:
        self.model = model
        kinematics = model.robot.kinematics
        self._kinematics, self._pin = kinematics, kinematics.model
        self._T_root_base = kinematics.T_base_root.inverse()
        self._geometry = pin.GeometryModel()
        self._names = [self._add(solid) for solid in model.solids]
        self._add_pairs()
        self._data, self._geometry_data = self._pin.createData(), pin.GeometryData(self._geometry)
        for request in self._geometry_data.collisionRequests:
            request.enable_contact, request.gjk_tolerance = True, _GJK_TOLERANCE
        self._broad = pin.BroadPhaseManager_DynamicAABBTreeCollisionManager(
            self._pin, self._geometry, self._geometry_data
        )
        pairs = [(pair.first, pair.second) for pair in self._geometry.collisionPairs]
        count = len(model.solids)
        self.pair_names = [(self._names[i], self._names[j]) for i, j in pairs]
        self.pair_solids = [(i, j if j < count else None) for i, j in pairs]
        self._still = [i for i, solid in enumerate(model.solids) if solid.carrier == WORLD]
        # Kept, for making a Python object of each anew takes as long as computing the distances.
        self._results = list(self._geometry_data.distanceResults)
        self._base = Pose2()
        self._plain = _is_plain(kinematics)

    @property
    def pair_count(self) -> int:
        """Number of pairs of solids that are looked at, the floor included."""
        return len(self.pair_names)

    def collides(self, configuration: Configuration) -> bool:
        """True if anything touches that must not."""
        self._stand(configuration.base)
        q = self._q(configuration.joints)
        return bool(pin.computeCollisions(self._pin, self._data, self._broad, q, True))

    def distances(self, configuration: Configuration) -> FloatArray:
        """Signed distance of each pair [m], in the order of `pair_names`, shape (P,)."""
        self._compute_distances(configuration)
        return np.array([result.min_distance for result in self._results])

    def frame_of(self, i: int) -> "pin.SE3":
        """Pose of the frame of a solid's carrier in the joint that moves it."""
        carrier = self.model.solids[i].carrier
        if carrier == WORLD:
            return self._T_root_base
        return self._pin.frames[self._kinematics.frame_id(carrier)].placement

    def nearest(self, configuration: Configuration) -> Clearance | None:
        """The pair with the smallest signed distance; None where there is no pair."""
        if not self.pair_count:
            return None
        worst = self._compute_distances(configuration)
        return Clearance(*self.pair_names[worst], self._geometry_data.distanceResults[worst].min_distance)

    def touching(self, configuration: Configuration) -> tuple[Clearance, ...]:
        """Every pair that touches and must not, deepest first; one row for each two owners."""
        deepest: dict[tuple[str, str], float] = {}
        for names, distance_m in zip(self.pair_names, self.distances(configuration), strict=True):
            if distance_m <= 0:
                deepest[names] = min(distance_m, deepest.get(names, 0.0))
        return tuple(Clearance(*names, float(d)) for names, d in sorted(deepest.items(), key=lambda item: item[1]))

    def _compute_distances(self, configuration: Configuration) -> int:
        """Compute the distance of each pair; return the number of the nearest."""
        self._stand(configuration.base)
        q = self._q(configuration.joints)
        return int(pin.computeDistances(self._pin, self._data, self._geometry, self._geometry_data, q))

    def _add(self, solid: Solid) -> str:
        joint, T = self._place(solid)
        name = f"{solid.owner}/{self._geometry.ngeoms}"
        self._geometry.addGeometryObject(pin.GeometryObject(name, joint, 0, T, coal_shape(solid)))
        return solid.owner

    def _place(self, solid: Solid) -> "tuple[int, pin.SE3]":
        T = pin.SE3(solid.T_carrier_solid)
        if solid.carrier == WORLD:
            return 0, self._T_root_base * T
        frame = self._pin.frames[self._kinematics.frame_id(solid.carrier)]
        return frame.parentJoint, frame.placement * T

    def _add_pairs(self) -> None:
        for i, j in self.model.pairs:
            self._geometry.addCollisionPair(pin.CollisionPair(i, j))
        if self.model.world.floor_m is None:
            return
        ground = coal.Halfspace(np.array([0.0, 0.0, 1.0]), self.model.world.floor_m)
        floor = self._geometry.addGeometryObject(pin.GeometryObject(FLOOR, 0, 0, self._T_root_base, ground))
        self._names.append(FLOOR)
        for i in self.model.over_floor:
            self._geometry.addCollisionPair(pin.CollisionPair(i, floor))

    def _stand(self, base: Pose2) -> None:
        """Move the world about the base, for pinocchio's model has a root that does not move."""
        if base == self._base:
            return
        T_root_world = self._T_root_base * pin.SE3(homogeneous(base.inverse()))
        for i in self._still:
            T = T_root_world * pin.SE3(self.model.solids[i].T_carrier_solid)
            self._geometry.geometryObjects[i].placement = T
        self._base = base

    def _q(self, joints: FloatArray) -> FloatArray:
        return joints if self._plain else self._kinematics.model_q(joints)


def _is_plain(kinematics: Any) -> bool:  # noqa: ANN401 - pinocchio has no types
    """True if pinocchio's q is the joint values: no joint follows another, none turns without end."""
    joint_map = kinematics.joint_map
    if joint_map.gain.shape[0] != joint_map.gain.shape[1] or kinematics.model.nq != joint_map.gain.shape[0]:
        return False
    return bool((joint_map.gain == np.eye(len(joint_map.gain))).all() and not joint_map.offset.any())


def coal_shape(solid: Solid) -> Any:  # noqa: ANN401 - coal has no types
    """The solid as coal's geometry."""
    size_m = [float(value) for value in solid.dimensions_m]
    if solid.kind == "box":
        return coal.Box(*size_m)
    if solid.kind == "cylinder":
        return coal.Cylinder(*size_m)
    if solid.kind == "sphere":
        return coal.Sphere(*size_m)
    corners, faces = coal.StdVec_Vec3s(), coal.StdVec_Triangle()
    for corner in solid.corners_m:
        corners.append(corner)
    for triangle in solid.triangles:
        faces.append(coal.Triangle(*(int(i) for i in triangle)))
    return coal.Convex(corners, faces)
