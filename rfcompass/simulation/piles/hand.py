"""The two-finger hand of executed grasps, as a MuJoCo model.

It is that of `urdf/ur5e_2f85.urdf`: a body and two fingers that slide, coupled as a 2F-85's are. It hangs on one
vertical slide with a servo, so that what it meets on its way down pushes back. Tool frame: y is the closing axis, z the
approach; the tips are 13 mm beyond its origin.
"""

from dataclasses import dataclass

import numpy as np

from rfcompass.arrays import FloatArray
from rfcompass.errors import PileError
from rfcompass.simulation.piles.engine import HandXml
from rfcompass.types.record import Record

# Tool frame [m]: half sizes and middles of the hand's boxes along x (across), y (closing) and z (approach), as in the
# URDF; the fingers at their closed place.
_BODY = (("box", (0.02, 0.06, 0.0225), (0.0, 0.0, -0.0675)), ("cylinder", (0.0375, 0.03), (0.0, 0.0, -0.12)))
GEOMS_OF_BODY = len(_BODY)
FINGER_HALF_M, _FINGER_Z_M = (0.011, 0.006, 0.029), -0.016
TIP_M = 0.013
# Servo of the slide and of each finger; ours.
_SLIDE_N_M, _SLIDE_N_S_M, _FINGER_N_M, _FINGER_N_S_M = 20_000.0, 400.0, 8_000.0, 250.0
# Contacts of the pads are five times as quick as those between items: light things would sink centimetres into pads
# that press with 40 N. Ours.
_PAD_S = 0.004
_TIE_S = 0.04  # how quickly what ties a cover gives in; ours
_HAND_GROUP = 3  # of geoms; items are in 0


@dataclass(frozen=True, slots=True, kw_only=True)
class PileHand(Record):
    """The hand's numbers, all ours but the opening.

    Attributes:
        opening_m: Furthest that the jaws open, the 2F-85's [m].
        grip_n: Force of each jaw [N]; a 2F-85 has 20 to 235.
        friction: Coefficient between jaw and item; of the pair the larger one counts.
        blocked_n: Vertical force at which the hand stops going down [N].
        pinch_n: Vertical force at which a tip has a cover [N].
        cloth_gives_m: How far cloth gives way under one tip, so that the other reaches it too [m].
        pinch_holds_n: Pull at which a pinched cover is lost [N].
        speed_m_s: Of going down and up [m/s].
        lift_m: How high it is lifted [m].
    """

    opening_m: float = 0.085
    grip_n: float = 40.0
    friction: float = 0.8
    blocked_n: float = 25.0
    pinch_n: float = 2.0
    cloth_gives_m: float = 0.03
    pinch_holds_n: float = 15.0
    speed_m_s: float = 0.2
    lift_m: float = 0.12

    def __post_init__(self) -> None:
        """Check that every number is above 0; friction may be 0."""
        for name in self.__slots__:
            value = getattr(self, name)
            if not (np.isfinite(value) and (value > 0 or (name == "friction" and value == 0))):
                raise PileError(f"hand: {name} is {value!r}", key=name, got=value)


def hand_xml(T_world_hand: FloatArray, start_m: float, hand: PileHand, covers: list[tuple[int, int]]) -> HandXml:
    """The hand as MJCF: at a place and yaw, its tool frame at a height from which it goes down."""
    R, half = T_world_hand[:3, :3], " ".join(map(str, FINGER_HALF_M))
    axes = " ".join(map(str, [*R[:, 0], *R[:, 1]]))
    friction = f'friction="{hand.friction} 0.02 0.005" solref="{_PAD_S} 1" solmix="1000"'
    body = "".join(
        f'<geom type="{kind}" size="{" ".join(map(str, size))}" pos="{" ".join(map(str, pos))}" mass="0.4" '
        f'group="{_HAND_GROUP}"/>'
        for kind, size, pos in _BODY
    )
    fingers = "".join(
        f'<body name="finger_{side}" gravcomp="1"><joint name="jaw_{side}" type="slide" axis="0 {sign} 0" '
        f'range="-0.001 {hand.opening_m / 2}" damping="{_FINGER_N_S_M}" frictionloss="0" armature="0.05"/>'
        f'<geom type="box" size="{half}" pos="0 {sign * FINGER_HALF_M[1]} {_FINGER_Z_M}" mass="0.04" {friction} '
        f'group="{_HAND_GROUP}"/>'
        "</body>"
        for side, sign in (("left", 1), ("right", -1))
    )
    slide = (
        f'<joint name="slide" type="slide" axis="0 0 -1" limited="false" damping="{_SLIDE_N_S_M}" frictionloss="0" '
        'armature="0.1"/>'
    )
    place = f"{T_world_hand[0, 3]} {T_world_hand[1, 3]} {start_m}"
    ties = "".join(
        f'<connect name="tie_{number}_{panel}" active="false" body1="hand" body2="{number}_{panel}" anchor="0 0 0" '
        f'solref="{_TIE_S} 1"/>'
        for number, panel in covers
    )
    return HandXml(
        f'<body name="hand" pos="{place}" xyaxes="{axes}" gravcomp="1">{slide}{body}{fingers}</body>',
        '<exclude body1="finger_left" body2="finger_right"/>',
        '<joint name="coupled" joint1="jaw_left" joint2="jaw_right" polycoef="0 1 0 0 0" solref="0.01 1"/>' + ties,
        f'<position joint="slide" kp="{_SLIDE_N_M}" ctrlrange="-1 1" ctrllimited="false"/>'
        + "".join(
            f'<position joint="jaw_{side}" kp="{_FINGER_N_M}" forcerange="{-hand.grip_n} {hand.grip_n}"/>'
            for side in ("left", "right")
        ),
    )
