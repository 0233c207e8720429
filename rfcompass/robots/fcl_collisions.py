"""Collision checks by python-fcl: the certificate, independent of what the hot loop computes with."""

from typing import Any

import fcl
import numpy as np

from rfcompass.arrays import FloatArray
from rfcompass.robots.collision_model import CollisionModel, homogeneous
from rfcompass.robots.solids import Solid
from rfcompass.types.configuration import Configuration
from rfcompass.types.world import FLOOR, WORLD

# More contacts than any configuration has: neighbours overlap, and their contacts come along with the others.
_MANY = 100_000


class FclCollisions:
    """Booleans through fcl's broad-phase manager, signed distances pair by pair. Not to be shared among threads.

    Trust the booleans. fcl's distances of boxes are upper bounds: one pair in 150 is too large, by up to centimetres,
    where faces or edges are parallel. Distances of plans therefore come from `QuickCollisions`, and a certificate of a
    clearance is the boolean of a model that is padded by it.

    The floor is a half-space: fcl checks it as one, but has no distance to it; ours is the height of the lowest point
    of each solid, which is exact.

    Args:
        model: Robot and world.
    """

    def __init__(self, model: CollisionModel) -> None:
        self.model = model
        kinematics = model.robot.kinematics
        self._kinematics = kinematics
        self._frames = [kinematics.frame_id(link) for link in model.carriers]
        self._shapes = [fcl_shape(solid) for solid in model.solids]
        self._objects = [fcl.CollisionObject(shape) for shape in self._shapes]
        self._pairs = set(model.pairs)
        self._number = {id(shape): i for i, shape in enumerate(self._shapes)}
        self._manager = fcl.DynamicAABBTreeCollisionManager()
        self._manager.registerObjects(self._objects)
        self._manager.setup()

    @property
    def pair_count(self) -> int:
        """Number of pairs of solids that are looked at, the floor included."""
        return len(self.model.pairs) + len(self.model.over_floor)

    def collides(self, configuration: Configuration) -> bool:
        """True if anything touches that must not."""
        poses = self._move(configuration)
        if self._floor_m is not None and any(self._height_m(i, poses[i]) <= 0 for i in self.model.over_floor):
            return True
        data = fcl.CollisionData(request=fcl.CollisionRequest(num_max_contacts=_MANY, enable_contact=True))
        self._manager.collide(data, fcl.defaultCollisionCallback)
        hits = ((self._number[id(contact.o1)], self._number[id(contact.o2)]) for contact in data.result.contacts)
        return any((min(pair), max(pair)) in self._pairs for pair in hits)

    def distances(self, configuration: Configuration) -> FloatArray:
        """Signed distance of each pair, then of each solid over the floor [m], in the order of the model."""
        poses = self._move(configuration)
        between = [self._distance_m(i, j) for i, j in self.model.pairs]
        over = [self._height_m(i, poses[i]) for i in self.model.over_floor]
        return np.array([*between, *over])

    @property
    def pair_names(self) -> list[tuple[str, str]]:
        """Owners of the solids of each pair (P)."""
        solids = self.model.solids
        between = [(solids[i].owner, solids[j].owner) for i, j in self.model.pairs]
        return [*between, *((solids[i].owner, FLOOR) for i in self.model.over_floor)]

    @property
    def _floor_m(self) -> float | None:
        return self.model.world.floor_m

    def _height_m(self, i: int, T: FloatArray) -> float:
        return self.model.solids[i].lowest_m(T) - (self._floor_m or 0.0)

    def _move(self, configuration: Configuration) -> list[FloatArray]:
        """Put every object where it is in the world; return the poses."""
        T_world_base = homogeneous(configuration.base)
        links = self._kinematics.poses(configuration.joints, self._frames)
        T_world = {WORLD: np.eye(4)} | {
            link: T_world_base @ T.homogeneous for link, T in zip(self.model.carriers, links, strict=True)
        }
        poses = [T_world[solid.carrier] @ solid.T_carrier_solid for solid in self.model.solids]
        for thing, T in zip(self._objects, poses, strict=True):
            thing.setTransform(fcl.Transform(T[:3, :3], T[:3, 3]))
        self._manager.update()
        return poses

    def _distance_m(self, i: int, j: int) -> float:
        request = fcl.DistanceRequest(enable_signed_distance=True)
        return float(fcl.distance(self._objects[i], self._objects[j], request, fcl.DistanceResult()))


def fcl_shape(solid: Solid) -> Any:  # noqa: ANN401 - fcl has no types
    """The solid as fcl's geometry."""
    size_m = [float(value) for value in solid.dimensions_m]
    if solid.kind == "box":
        return fcl.Box(*size_m)
    if solid.kind == "cylinder":
        return fcl.Cylinder(*size_m)
    if solid.kind == "sphere":
        return fcl.Sphere(*size_m)
    faces = np.column_stack([np.full(len(solid.triangles), 3), solid.triangles])
    return fcl.Convex(np.array(solid.corners_m), len(solid.triangles), faces.ravel())
