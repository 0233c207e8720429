"""Joint limits of a URDF: the mechanical ones and the narrower ones of a safety controller."""

from collections.abc import Sequence
from dataclasses import dataclass
from xml.etree.ElementTree import Element

import numpy as np

from rfcompass.arrays import FloatArray, read_only
from rfcompass.errors import JointLimitError, RobotModelError
from rfcompass.robots.urdf_xml import vector
from rfcompass.types.record import Record

# A value this far outside still counts as inside: rounding, not motion.
_SLACK = 1e-9


@dataclass(frozen=True, slots=True)
class JointLimits(Record):
    """Limits of each moving joint, revolute [rad] or prismatic [m]; infinite where there is none.

    Attributes:
        names: Joints, in the order of a configuration (Q).
        lower: Mechanical lower limit, shape (Q,).
        upper: Mechanical upper limit, shape (Q,).
        soft_lower: Limit of the safety controller, the mechanical one where there is none, shape (Q,).
        soft_upper: The same above, shape (Q,).
        velocity: Largest speed [rad/s or m/s], shape (Q,).
    """

    names: tuple[str, ...]
    lower: FloatArray
    upper: FloatArray
    soft_lower: FloatArray
    soft_upper: FloatArray
    velocity: FloatArray

    def __post_init__(self) -> None:
        """Freeze the arrays."""
        for name in ("lower", "upper", "soft_lower", "soft_upper", "velocity"):
            values = read_only(getattr(self, name), f"JointLimits.{name}", (len(self.names),), finite=False)
            object.__setattr__(self, name, values)

    def check(self, joints: FloatArray, *, soft: bool = False) -> None:
        """Accept joint values inside their limits; joints (Q,).

        Raises:
            JointLimitError: For the first joint outside; names joint, value and limits.
        """
        lower, upper = (self.soft_lower, self.soft_upper) if soft else (self.lower, self.upper)
        for name, value, low, high in zip(self.names, joints, lower, upper, strict=True):
            if not low - _SLACK <= value <= high + _SLACK:
                message = f"joint {name} is at {value:.6g}, outside its limits {low:.6g} .. {high:.6g}"
                raise JointLimitError(message, joint=name, value=float(value), lower=float(low), upper=float(high))


def read_limits(root: Element, names: Sequence[str]) -> JointLimits:
    """Read the limits of the given joints.

    Raises:
        RobotModelError: If a limit is no number, or a revolute or prismatic joint has none.
    """
    joints = {joint.get("name"): joint for joint in root.findall("joint")}
    rows = [_limits_of(joints[name]) for name in names]
    columns = np.array(rows).reshape(-1, 5).T
    return JointLimits(tuple(names), *columns)


def _limits_of(joint: Element) -> list[float]:
    """Lower, upper, soft lower, soft upper, velocity."""
    limit, safety, endless = joint.find("limit"), joint.find("safety_controller"), joint.get("type") == "continuous"
    if limit is None and not endless:
        raise RobotModelError(f"joint {joint.get('name')} has no limit", joint=joint.get("name"))
    lower, upper = (-np.inf, np.inf) if endless else (_number(limit, "lower", 0.0), _number(limit, "upper", 0.0))
    velocity = _number(limit, "velocity", np.inf)
    return [
        lower,
        upper,
        _number(safety, "soft_lower_limit", lower),
        _number(safety, "soft_upper_limit", upper),
        velocity,
    ]


def _number(element: Element | None, attribute: str, default: float) -> float:
    return float(vector(element, attribute, (default,))[0])
