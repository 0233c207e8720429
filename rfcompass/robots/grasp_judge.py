"""Would a grasp hold? The readable judge: every question is a boolean of fcl between the part and a box.

What is modelled, in hand axes (`rfcompass.types.hands`):

1. The open hand comes down straight along its approach axis from beyond the part. What its boxes sweep must not
   touch the part.
2. The jaws close on what is between them, by equal amounts. A jaw that touches first pushes the part along the closing
   axis, without turning it, until the other touches too. So the left jaw touches at the farthest point of the part in
   front of one of its pads, s_L = max x, and the right one at s_R = min x; they end w = s_L - s_R apart. A pad is a
   rectangle, not a ray: on a box that is turned by δ it touches with an edge.
3. Each contact must lie inside the friction cone: the closing direction within atan(μ) of the part's normal. At an edge
   or a corner of the part the normal is that of the face which looks at the jaw most.
4. The contacts must be opposite. A pad yields by a little, and so touches the bounding rectangle of what lies that near
   to it. The gap g between both rectangles, across and along the approach, must not tilt the line of the forces out
   of the cone: g ≤ μ w [Nguyen1988].
5. The part must not be heavier than the payload, nor slip: m g ≤ 2 μ F.

Left out: a real hand turns a part that lies askew until its faces lie flat on the pads, and so holds some that
fail here in 3; a part may also turn while it is pushed, and swing when it is lifted far from its centre of mass.
"""

from itertools import product
from typing import Any

import fcl
import numpy as np

from rfcompass.arrays import FloatArray
from rfcompass.robots.fcl_collisions import fcl_shape
from rfcompass.robots.part_surface import facing_normal, surface_of
from rfcompass.robots.solids import body_solids
from rfcompass.types.grasps import Contacts, Failure
from rfcompass.types.hands import Hand
from rfcompass.types.shapes import Mesh, Shape, rigid_transform
from rfcompass.types.world import Body

GRAVITY_M_S2 = 9.81
# A contact's middle is that of what lies this near to the pad [m]; far above what fcl's booleans are good for.
_TOUCH_M = 1e-5
# Halvings of an interval: of 1 m to a nanometre.
_HALVINGS = 30


def judge_grasp(
    hand: Hand, shape: Shape, T_part_hand: FloatArray, *, opening_m: float | None = None, mass_kg: float | None = None
) -> Contacts | Failure:
    """Tell whether closing the hand here would hold a part.

    Args:
        hand: Which hand.
        shape: What it closes on.
        T_part_hand: Pose of the tool frame in the part frame, homogeneous, shape (4, 4).
        opening_m: Distance of the jaws as it comes down [m]; the greatest if None.
        mass_kg: How heavy the part is; not looked at if None.

    Returns:
        The contacts; or a failure: `"too_heavy"`, `"hand_hits_part"`, `"too_wide"` (what is between the jaws is wider
        than they open), `"nothing_between_jaws"`, `"outside_friction_cone"` or `"not_opposite"`.

    Raises:
        InputError: If the hand does not open so far.
        PartError: If the pose is no rigid transform.
    """
    scene = _Scene(hand, shape, rigid_transform(T_part_hand, "T_part_hand"), hand.opening(opening_m))
    if (failure := weight_failure(hand, mass_kg)) is not None:
        return failure
    if (hit := scene.hit_on_the_way()) is not None:
        return _too_wide(scene) or Failure("hand_hits_part", f"the {hit} touches the part on its way down")
    ends = scene.first_touches(scene.opening_m / 2)
    if ends is None:
        return Failure("nothing_between_jaws", "there is nothing between the jaws")
    if (width_m := ends[0] + ends[1]) < hand.least_m:
        message = f"the jaws stop {hand.least_m:.4g} m apart, and the part between them is {width_m:.4g} m wide"
        return Failure("nothing_between_jaws", message, (("width_m", width_m),))
    return _judge_contacts(hand, scene, ends)


def hit_on_the_way(hand: Hand, shape: Shape, T_part_hand: FloatArray, *, opening_m: float | None = None) -> str | None:
    """What of the open hand touches the part as it comes down.

    Args:
        hand: Which hand.
        shape: The part.
        T_part_hand: Pose of the tool frame in the part frame, homogeneous, shape (4, 4).
        opening_m: Distance of the jaws [m]; the greatest if None.

    Returns:
        `"palm"`, `"left jaw"`, `"right jaw"`; None if nothing does.

    Raises:
        InputError: If the hand does not open so far.
        PartError: If the pose is no rigid transform.
    """
    return _Scene(hand, shape, rigid_transform(T_part_hand, "T_part_hand"), hand.opening(opening_m)).hit_on_the_way()


def weight_failure(hand: Hand, mass_kg: float | None) -> Failure | None:
    """The failure `"too_heavy"`, if a part of this mass is.

    Raises:
        PartError: If the mass is no number.
    """
    if mass_kg is None:
        return None
    holds_kg = 2 * hand.friction * hand.grip_n / GRAVITY_M_S2
    most_kg = min(hand.payload_kg, holds_kg)
    if mass_kg <= most_kg:
        return None
    why = "the payload" if hand.payload_kg <= holds_kg else "what friction holds"
    numbers = (("mass_kg", float(mass_kg)), ("most_kg", float(most_kg)))
    return Failure("too_heavy", f"{mass_kg:.3g} kg are more than {why}, {most_kg:.3g} kg", numbers)


def _too_wide(scene: "_Scene") -> Failure | None:
    ends = scene.first_touches(scene.beyond_m)
    if ends is None or (width_m := ends[0] + ends[1]) <= scene.opening_m:
        return None
    message = f"between the jaws the part is {width_m:.4g} m wide, and they open to {scene.opening_m:.4g} m"
    return Failure("too_wide", message, (("width_m", width_m), ("opening_m", scene.opening_m)))


def _judge_contacts(hand: Hand, scene: "_Scene", ends: tuple[float, float]) -> Contacts | Failure:
    contacts = scene.contacts(ends)
    limit_rad = float(np.arctan(hand.friction))
    if (worst_rad := float(contacts.angles_rad.max())) > limit_rad:
        degrees = f"{np.degrees(worst_rad):.1f}° from the closing direction, more than {np.degrees(limit_rad):.1f}°"
        return Failure("outside_friction_cone", f"a face is {degrees}", (("angle_rad", worst_rad),))
    gap_m = scene.gap_m(ends)
    if gap_m > hand.friction * contacts.width_m:
        message = f"the jaws touch {gap_m:.4g} m beside each other, with {contacts.width_m:.4g} m between them"
        return Failure("not_opposite", message, (("gap_m", gap_m), ("width_m", contacts.width_m)))
    return contacts


class _Scene:
    """A part and a hand at one pose, as questions to fcl."""

    def __init__(self, hand: Hand, shape: Shape, T_part_hand: FloatArray, opening_m: float) -> None:
        self.hand, self.shape, self.opening_m = hand, shape, opening_m
        self._R = T_part_hand[:3, :3] @ hand.R_tool_hand
        self._origin_m = T_part_hand[:3, 3]
        self._part = fcl_part(shape)
        corners = np.array(list(product(*zip(shape.lower_m, shape.upper_m, strict=True))))
        # Farther than any point of the part from the hand: from where the hand comes, and how far a jaw could go.
        self.beyond_m = float(np.linalg.norm(corners - self._origin_m, axis=1).max()) + 1.0

    def touches(self, lower_m: FloatArray, upper_m: FloatArray) -> bool:
        """True if the part has a point in a box of the hand's axes, corners of shape (3,)."""
        box = fcl.Box(*np.maximum(upper_m - lower_m, 1e-9))
        centre_m = self._origin_m + self._R @ ((lower_m + upper_m) / 2)
        thing = fcl.CollisionObject(box, fcl.Transform(self._R, centre_m))
        request = fcl.CollisionRequest()
        return any(fcl.collide(thing, piece, request, fcl.CollisionResult()) > 0 for piece in self._part)

    def hit_on_the_way(self) -> str | None:
        """What touches the part while the open hand comes down: `"palm"`, `"left jaw"`, `"right jaw"`, or None."""
        names = ["palm"] * len(self.hand.palm_m) + ["left jaw"] * len(self.hand.left.boxes_m)
        names += ["right jaw"] * len(self.hand.right.boxes_m)
        for name, (lower_m, upper_m) in zip(names, self.hand.boxes_m(self.opening_m), strict=True):
            start_m = np.array([lower_m[0], lower_m[1], -self.beyond_m])
            if self.touches(start_m, upper_m):
                return name
        return None

    def first_touches(self, within_m: float) -> tuple[float, float] | None:
        """Outward x at which the left and the right jaw first touch [m]; None if one finds nothing.

        Args:
            within_m: How far outwards to look [m]: the open jaws, for what lies beyond them they do not close on.
        """
        left, right = (self._first_touch(side, within_m) for side in (1, -1))
        return None if left is None or right is None else (left, right)

    def _first_touch(self, side: int, within_m: float) -> float | None:
        """Largest outward x at which there is part in front of a pad."""
        low, high = -within_m, within_m
        if not self._in_front(side, low, high):
            return None
        for _ in range(_HALVINGS):
            middle = (low + high) / 2
            low, high = (middle, high) if self._in_front(side, middle, high) else (low, middle)
        return low

    def _in_front(self, side: int, inner_m: float, outer_m: float, within: FloatArray | None = None) -> bool:
        """True if part is in front of a pad, at outward x in [inner, outer], inside a window (2, 2) of the pads."""
        jaw = self.hand.left if side > 0 else self.hand.right
        inner_m, outer_m = (inner_m, outer_m) if side > 0 else (-outer_m, -inner_m)
        for pad in jaw.pads_m:
            lower, upper = pad if within is None else (np.maximum(pad[0], within[0]), np.minimum(pad[1], within[1]))
            if (lower <= upper).all() and self.touches(np.array([inner_m, *lower]), np.array([outer_m, *upper])):
                return True
        return False

    def contacts(self, ends: tuple[float, float]) -> Contacts:
        """Where the jaws touch when they have closed; the part has been pushed along with them."""
        points_m, normals, angles_rad = [], [], []
        surface = surface_of(self.shape)
        for side, end_m in zip((1, -1), ends, strict=True):
            window = self._touched(side, end_m, _TOUCH_M)
            point_m = self._origin_m + self._R @ np.array([side * end_m, *window.mean(axis=0)])
            towards = side * self._R[:, 0]
            normal = facing_normal(surface, point_m, towards)
            points_m.append(point_m)
            normals.append(normal)
            angles_rad.append(np.arccos(np.clip(normal @ towards, -1, 1)))
        return Contacts(np.array(points_m), np.array(normals), ends[0] + ends[1], np.array(angles_rad))

    def gap_m(self, ends: tuple[float, float]) -> float:
        """Distance in the pad plane between what the two yielding pads touch."""
        left, right = (
            self._touched(side, end_m, self.hand.give_m) for side, end_m in zip((1, -1), ends, strict=True)
        )  # fmt: skip
        beside = np.maximum(left[0] - right[1], right[0] - left[1])
        return float(np.linalg.norm(np.maximum(beside, 0.0)))

    def _touched(self, side: int, end_m: float, depth_m: float) -> FloatArray:
        """Bounding rectangle of what lies within a depth of the closed pads, lower and upper corner (2, 2)."""
        jaw = self.hand.left if side > 0 else self.hand.right
        whole = np.array([jaw.pads_m[:, 0].min(axis=0), jaw.pads_m[:, 1].max(axis=0)])
        found = whole.copy()
        for corner, axis in product((0, 1), (0, 1)):
            empty, full = whole[corner, axis], whole[1 - corner, axis]
            for _ in range(_HALVINGS):
                window = whole.copy()
                window[1 - corner, axis] = (empty + full) / 2
                if self._in_front(side, end_m - depth_m, self.opening_m / 2, window):
                    full = window[1 - corner, axis]
                else:
                    empty = window[1 - corner, axis]
            found[corner, axis] = full
        return found


def fcl_part(shape: Shape) -> list[Any]:
    """Collision objects of a part at the origin; the surface of a mesh, or its hull where that stands for it."""
    if isinstance(shape, Mesh) and shape.pieces_by != "hull":
        surface = fcl.BVHModel()
        surface.beginModel(len(shape.vertices_m), len(shape.triangles))
        surface.addSubModel(shape.vertices_m, shape.triangles)
        surface.endModel()
        return [fcl.CollisionObject(surface, fcl.Transform())]
    solids = body_solids(Body("part", shape, np.eye(4)))
    poses = [solid.T_carrier_solid for solid in solids]
    return [
        fcl.CollisionObject(fcl_shape(solid), fcl.Transform(T[:3, :3], T[:3, 3]))
        for solid, T in zip(solids, poses, strict=True)
    ]
