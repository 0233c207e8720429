"""What a grasp planner is asked, checked: a part, where it seems to lie, what stands around, where the arm is."""

from dataclasses import dataclass

import numpy as np

from rfcompass.arrays import FloatArray
from rfcompass.geometry.pose2 import Pose2
from rfcompass.robots import Robot
from rfcompass.types.configuration import Configuration
from rfcompass.types.estimate import PartEstimate
from rfcompass.types.grasps import Failure
from rfcompass.types.parts import Part
from rfcompass.types.record import Record
from rfcompass.types.shapes import Cylinder, Shape, Sphere
from rfcompass.types.world import Body, World

ORIENTATION_UNKNOWN, BAD_COVARIANCE, IN_THE_FLOOR = "orientation_unknown", "bad_covariance", "part_in_the_floor"

# Ours: how far a part may seem to lie in the floor, by what an estimate of its height is good for [m].
_IN_FLOOR_M = 0.002


@dataclass(frozen=True, slots=True)
class GraspQuestion(Record):
    """A question that can be answered.

    Attributes:
        part: What to grasp.
        estimate: Where it seems to lie, in the present base frame.
        world: Floor and bodies in the same frame, the part among them under its own name.
        start: Where the arm is; the base at the origin.
    """

    part: Part
    estimate: PartEstimate
    world: World
    start: Configuration

    @property
    def T_base_part(self) -> FloatArray:
        """Estimated pose of the part, upright as it lies, shape (4, 4)."""
        return pose_of(self.estimate)

    def from_base(self, base: Pose2) -> "GraspQuestion":
        """The same question, asked when the base has driven to a pose in the present frame."""
        back = base.inverse()
        T = np.eye(4)
        T[:2, :2], T[:2, 3] = back.rotation, back.translation_m
        bodies = [
            Body(body.name, body.shape, T @ body.T_parent_body, body.parent, body.may_touch)
            if body.stands_still
            else body
            for body in self.world.bodies
        ]
        world = World(tuple(bodies), self.world.floor_m)
        return GraspQuestion(self.part, self.estimate.in_frame(back), world, self.start)


def ask(
    robot: Robot, part: Part, estimate: PartEstimate, world: World, start: Configuration | None
) -> GraspQuestion | Failure:
    """Check what is asked.

    Args:
        robot: Robot with a hand.
        part: What to grasp. A body of its name in the world gives way to the estimate.
        estimate: Where it seems to lie, in the present base frame.
        world: Floor and other bodies in the same frame.
        start: Believed joints; the posture "scan", or at rest, if None. Its base pose is not looked at.

    Returns:
        A question; or a failure: `"orientation_unknown"`, `"bad_covariance"` if there are no samples and the
        covariance is none, `"part_in_the_floor"` if the estimate's height cannot be.

    Raises:
        ShapeError: If `start` is of another robot.
    """
    if estimate.theta_rad is None and not is_round(part.shape):
        message = "the estimate has no orientation, so the jaws have no direction to close"
        return Failure(ORIENTATION_UNKNOWN, message)
    if (failure := _covariance_failure(estimate) or _floor_failure(part, estimate, world)) is not None:
        return failure
    if start is None:
        start = robot.posture("scan") if "scan" in robot.description.postures else robot.configuration()
    joints = robot.configuration(start.joints)
    others = [body for body in world.bodies if body.name != part.part_id]
    body = Body(part.part_id, part.shape, pose_of(estimate))
    return GraspQuestion(part, estimate, World((*others, body), world.floor_m), joints)


def pose_of(estimate: PartEstimate) -> FloatArray:
    """Estimated pose of a part as a homogeneous pose in space, its heading 0 where that is not known, shape (4, 4)."""
    T = np.eye(4)
    T[:2, :2] = Pose2(0.0, 0.0, estimate.theta_rad or 0.0).rotation
    T[:2, 3], T[2, 3] = estimate.centre_m, estimate.height_m
    return T


def is_round(shape: Shape) -> bool:
    """True if a shape is the same whatever its heading."""
    return isinstance(shape, Sphere) or (isinstance(shape, Cylinder) and shape.axis == "z")


def _covariance_failure(estimate: PartEstimate) -> Failure | None:
    if len(estimate.samples) or estimate.covariance is None:
        return None
    known = 2 if estimate.theta_rad is None else 3
    covariance = estimate.covariance[:known, :known]
    spread = np.linalg.eigvalsh((covariance + covariance.T) / 2)
    if np.isfinite(spread).all() and spread[0] >= -1e-9 * max(spread[-1], 1e-12):
        return None
    message = f"the covariance has the eigenvalue {spread[0]:.3g}; none may be below 0"
    return Failure(BAD_COVARIANCE, message, (("least_eigenvalue", float(spread[0])),))


def _floor_failure(part: Part, estimate: PartEstimate, world: World) -> Failure | None:
    if world.floor_m is None:
        return None
    depth_m = world.floor_m - (estimate.height_m + float(part.shape.lower_m[2]))
    if depth_m <= _IN_FLOOR_M:
        return None
    message = (
        f"{part.part_id} would lie {depth_m * 1e3:.1f} mm deep in the floor: the estimate has its centre "
        f"{estimate.height_m:.3f} m up, and it rests at {part.resting_height_m:.3f} m"
    )
    return Failure(IN_THE_FLOOR, message, (("depth_m", depth_m), ("height_m", estimate.height_m)))
