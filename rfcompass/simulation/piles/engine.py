"""MuJoCo, loaded when it is first needed, and the model of a pile that it is given."""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

import numpy as np

from rfcompass.arrays import FloatArray
from rfcompass.errors import MissingExtra, PileError
from rfcompass.simulation.piles.items import PANELS, PileItem
from rfcompass.types.record import Record

# Of the joints of one item: place and quaternion (w, x, y, z) of its middle panel, then its hinges from -x to +x [rad].
# Of a cushion: those of the whole thing before it gives way, fixed to its lower half, then the slide of the upper [m].
ROOT = 7
GRAVITY_M_S2 = 9.81
# Cushions, all ours; not in `PilePhysics`, which is part of the hash of every stored scene. The upper half slides down
# by at most this share of the thickness. Where it has gone down by the share s, its spring takes the weight of that
# half and A s + C s³ on top of it, A and C in newton; the slide's damping [N·s/m].
CUSHION_GIVES = 0.45
CUSHION_A_N, CUSHION_C_N, CUSHION_DAMPING_N_S_M = 0.8, 33.0, 3.0


@dataclass(frozen=True, slots=True)
class PilePhysics(Record):
    """Constants of the simulation, all ours.

    Elliptic friction cones with `impratio` 300 are what lets a pile come to rest: soft contacts creep in proportion to
    1 / impratio. Rolling and torsional friction stand for surfaces that give way, or round things never stop.

    Attributes:
        timestep_s: Step [s].
        friction: Coefficient of sliding friction.
        torsion_m: Coefficient of torsional friction [m].
        rolling_m: Coefficient of rolling friction [m].
        contact_time_s: Time constant of a contact, critically damped [s].
        impratio: Stiffness of friction over that of the normal force.
        hinge_damping_n_m_s: Damping of a cover's hinges [N·m·s].
        hinge_friction_n_m: Dry friction of a hinge; lets a cover come to rest half bent [N·m].
        hinge_armature_kg_m2: Inertia added to a hinge, so that a light panel does not blow up [kg·m²].
        hinge_range_rad: Furthest that a hinge turns to either side [rad].
    """

    timestep_s: float = 0.004
    friction: float = 0.8
    torsion_m: float = 0.02
    rolling_m: float = 0.005
    contact_time_s: float = 0.02
    impratio: float = 300.0
    hinge_damping_n_m_s: float = 0.002
    hinge_friction_n_m: float = 0.0005
    hinge_armature_kg_m2: float = 5e-5
    hinge_range_rad: float = 1.0

    def __post_init__(self) -> None:
        """Check that no number is negative, and time passes."""
        for name in self.__slots__:
            if not (np.isfinite(value := getattr(self, name)) and value >= 0):
                raise PileError(f"physics: {name} is {value!r}, not a finite number >= 0", key=name, got=value)
        if not self.timestep_s > 0:
            raise PileError("physics: timestep_s is 0", key="timestep_s", got=self.timestep_s)


@dataclass(frozen=True, slots=True)
class HandXml(Record):
    """What a hand adds to the model of a pile, as MJCF; nothing by default.

    Attributes:
        bodies: Bodies under the world.
        excluded: Pairs that never touch.
        equalities: Couplings of joints, and what can be tied to the hand.
        actuators: Its drives.
    """

    bodies: str = ""
    excluded: str = ""
    equalities: str = ""
    actuators: str = ""


@contextmanager
def quiet_mujoco() -> Iterator[None]:
    """Keep MuJoCo from printing warnings, and from writing them to a file where one works; it still counts them."""
    engine = load_mujoco()
    before = engine.get_mju_user_warning()
    engine.set_mju_user_warning(lambda _: None)
    try:
        yield
    finally:
        engine.set_mju_user_warning(before)


def load_mujoco() -> Any:  # noqa: ANN401 - an extra: the checks must not depend on whether it is installed
    """Return the module `mujoco`.

    Raises:
        MissingExtra: If it is not installed, or older than version 4, whose rays are called otherwise.
    """
    how = "pip install 'rfcompass[piles]'"
    try:
        import mujoco  # noqa: PLC0415 - an extra
    except ImportError as cause:
        raise MissingExtra(f"piles need MuJoCo: {how}", extra="piles", name=cause.name) from cause
    if int(mujoco.__version__.split(".")[0]) < 4:
        message = f"piles need MuJoCo 4, not {mujoco.__version__}: {how}"
        raise MissingExtra(message, extra="piles", name="mujoco", version=mujoco.__version__)
    return mujoco


def compile_pile(items: Sequence[PileItem], physics: PilePhysics, hand: HandXml | None = None) -> Any:  # noqa: ANN401 - see load_mujoco
    """Compile a model of items on a table; the table is the plane z = 0 of the world frame, geom 0.

    Bodies and geoms come in the order of the items, the panels of a cover from -x to +x; see `panel_order`. Those of a
    hand, if there is one, come after them.
    """
    return load_mujoco().MjModel.from_xml_string(pile_xml(items, physics, hand))


def panel_order(item: PileItem) -> tuple[int, ...]:
    """Panels of an item in MuJoCo's order of bodies: the middle one, then to +x, then to -x; a cushion's upwards."""
    if item.kind == "cushion":
        return (0, 1)
    if item.kind != "cover":
        return (0,)
    middle = PANELS // 2
    return (*range(middle, PANELS), *range(middle - 1, -1, -1))


def joint_order(item: PileItem) -> tuple[int, ...]:
    """Hinges of a state, from -x to +x, in the order of MuJoCo's joints; hinge h is between panels h and h + 1."""
    if item.kind == "cushion":
        return (0,)
    if item.kind != "cover":
        return ()
    middle = PANELS // 2
    return (*range(middle, PANELS - 1), *range(middle - 1, -1, -1))


def pile_xml(items: Sequence[PileItem], physics: PilePhysics, hand: HandXml | None = None) -> str:
    """Write the model as MJCF."""
    hand = HandXml() if hand is None else hand
    contact = (
        f'friction="{physics.friction} {physics.torsion_m} {physics.rolling_m}" condim="6" '
        f'solref="{physics.contact_time_s} 1" solimp="0.95 0.99 0.0005"'
    )
    hinge = (
        f'range="{-physics.hinge_range_rad} {physics.hinge_range_rad}" damping="{physics.hinge_damping_n_m_s}" '
        f'frictionloss="{physics.hinge_friction_n_m}" armature="{physics.hinge_armature_kg_m2}"'
    )
    return f"""<mujoco>
<compiler angle="radian"/>
<option timestep="{physics.timestep_s}" integrator="implicitfast" cone="elliptic" impratio="{physics.impratio}"
 tolerance="1e-10" iterations="100"/>
<size memory="64M"/>
<default><geom {contact}/><joint limited="true" {hinge}/></default>
<worldbody><geom type="plane" size="1 1 0.1"/>
{"".join(_body_xml(item) for item in items)}{hand.bodies}</worldbody>
<contact>{"".join(_excluded_xml(item) for item in items)}{hand.excluded}</contact>
<equality>{hand.equalities}</equality><actuator>{hand.actuators}</actuator></mujoco>"""


def _body_xml(item: PileItem) -> str:
    if item.kind == "cushion":
        return _cushion_xml(item)
    name, geom = f'name="{item.number}_{PANELS // 2}"', _geom_xml(item)
    if item.kind != "cover":
        return f"<body {name}><freejoint/>{geom}</body>\n"
    sides = "".join(_chain_xml(item, range(PANELS // 2 + sign, PANELS if sign > 0 else -1, sign)) for sign in (1, -1))
    return f"<body {name}><freejoint/>{geom}{sides}</body>\n"


def _cushion_xml(item: PileItem) -> str:
    """Two halves, parent and child, which MuJoCo does not let push each other; the upper one slides on a spring."""
    thick_m = float(item.size_m[2])
    slide = (
        f'<joint type="slide" axis="0 0 1" range="{-CUSHION_GIVES * thick_m} 0" {_spring_xml(item)} '
        f'damping="{CUSHION_DAMPING_N_S_M}" frictionloss="0" armature="0" solreflimit="0.01 1" '
        'solimplimit="0.999 0.999 0.0005"/>'
    )
    lower, upper = (f'<geom pos="0 0 {sign * thick_m / 4}"{_geom_xml(item)[5:]}' for sign in (-1, 1))
    inner = f'<body name="{item.number}_1">{slide}{upper}</body>'
    return f'<body name="{item.number}_0"><freejoint/>{lower}{inner}</body>\n'


def _spring_xml(item: PileItem) -> str:
    """Spring of a cushion, which MuJoCo lets pull by -(a x + b x² + c x³), x from where it would be free [m].

    That is P(s) = w + A s + C s³ about its root, s = -r: x is -(s + r) thicknesses. w is the weight of one half, so
    that a cushion with nothing on it keeps its height.
    """
    thick_m, half_n = float(item.size_m[2]), item.mass_kg * GRAVITY_M_S2 / 2
    roots = np.roots([CUSHION_C_N, 0.0, CUSHION_A_N, -half_n])
    r = float(roots[np.isreal(roots)].real.max())
    terms = ((CUSHION_A_N + 3 * CUSHION_C_N * r**2) / thick_m, 3 * CUSHION_C_N * r / thick_m**2)
    stiffness = " ".join(map(str, (*terms, CUSHION_C_N / thick_m**3)))
    return f'stiffness="{stiffness}" springref="{r * thick_m}"'


def _chain_xml(item: PileItem, panels: range) -> str:
    """Panels that hang on each other, away from the middle one.

    Every hinge turns about +y from the panel at -x to the one at +x; those on the side of -x hang the other way round.
    """
    if not panels:
        return ""
    step_m = panels.step * float(item.size_m[0]) / PANELS
    hinge = f'<joint type="hinge" axis="0 {panels.step} 0" pos="{-step_m / 2} 0 0"/>'
    inner = _chain_xml(item, panels[1:])
    return f'<body name="{item.number}_{panels[0]}" pos="{step_m} 0 0">{hinge}{_geom_xml(item)}{inner}</body>'


def _excluded_xml(item: PileItem) -> str:
    """Panels of one cover do not push each other: squeezed folds would blow up. Neighbours never do in MuJoCo."""
    apart = [(a, b) for a in range(PANELS) for b in range(a + 2, PANELS)] if item.kind == "cover" else []
    return "".join(f'<exclude body1="{item.number}_{a}" body2="{item.number}_{b}"/>' for a, b in apart)


def _geom_xml(item: PileItem) -> str:
    x, y, z = (float(edge) / 2 for edge in item.panel_size_m)
    kind, size = {
        "cylinder": ("cylinder", (x, z)),
        "capsule": ("capsule", (x, z - x)),
        "ellipsoid": ("ellipsoid", (x, y, z)),
    }.get(item.kind, ("box", (x, y, z)))
    mass_kg = item.mass_kg / len(panel_order(item))
    return f'<geom type="{kind}" size="{" ".join(map(str, size))}" mass="{mass_kg}"/>'


def flat_state(item: PileItem, T_world_item: FloatArray) -> FloatArray:
    """State of an item at a pose (4, 4), a cover spread out, a cushion not pressed; shape (7 + joints,)."""
    quaternion = np.empty(4)
    load_mujoco().mju_mat2Quat(quaternion, np.ascontiguousarray(T_world_item[:3, :3]).reshape(9))
    return np.concatenate([T_world_item[:3, 3], quaternion, np.zeros(item.joints)])
