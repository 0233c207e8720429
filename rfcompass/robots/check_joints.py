"""Defects of a URDF's tree: links and joints, limits, axes and mimic rules."""

from collections import Counter
from collections.abc import Iterator
from xml.etree.ElementTree import Element

import numpy as np

from rfcompass.errors import RobotModelError
from rfcompass.robots.defect import Defect, try_read
from rfcompass.robots.joint_map import read_joint_map
from rfcompass.robots.urdf_xml import axis_of, link_of, pose, vector

MOVING = ("revolute", "continuous", "prismatic")


def names_of(root: Element, tag: str) -> list[str]:
    """Names of the robot's links or joints, in order."""
    return [element.get("name", "") for element in root.findall(tag)]


def check_tree(root: Element) -> Iterator[Defect]:
    """Names given once, joints between links that exist, one root, nothing left over."""
    if not root.get("name"):
        yield Defect("no_name", "robot", "<robot> has no name")
    if any(isinstance(element.tag, str) and element.tag.startswith("xacro:") for element in root.iter()):
        yield Defect("xacro", "robot", "holds xacro macros; expand them first (xacro robot.xacro > robot.urdf)")
    for tag in ("link", "joint"):
        for name, count in Counter(names_of(root, tag)).items():
            if not name:
                yield Defect(f"unnamed_{tag}", "robot", f"{count} <{tag}> without a name")
            elif count > 1:
                yield Defect(f"duplicate_{tag}", name, f"{tag} {name!r} stands {count} times")
    yield from _check_ends(root)
    yield from _check_connected(root)


def _check_ends(root: Element) -> Iterator[Defect]:
    links, parent_of = set(names_of(root, "link")), dict[str, str]()
    for joint in root.findall("joint"):
        name = joint.get("name", "")
        for end in ("parent", "child"):
            if (link := link_of(joint, end)) not in links:
                known = f"{link!r}, which is no link" if link else "nothing"
                yield Defect(f"unknown_{end}", name, f"joint {name!r} has as {end} {known}")
        child = link_of(joint, "child")
        if child in parent_of:
            message = f"link {child!r} hangs on two joints, {parent_of[child]!r} and {name!r}"
            yield Defect("two_parents", child, message)
        parent_of[child] = name


def _check_connected(root: Element) -> Iterator[Defect]:
    links = names_of(root, "link")
    children: dict[str, list[str]] = {}
    for joint in root.findall("joint"):
        children.setdefault(link_of(joint, "parent"), []).append(link_of(joint, "child"))
    hanging = {child for siblings in children.values() for child in siblings}
    roots = [link for link in links if link not in hanging]
    if not links:
        yield Defect("no_link", "robot", "there is no link")
    elif not roots:
        yield Defect("ring", "robot", "every link hangs on a joint: the joints form a ring")
    for extra in roots[1:]:
        yield Defect("two_roots", extra, f"link {extra!r} hangs on nothing, and so does {roots[0]!r}")
    reached = _reachable(roots, children)
    for link in links:
        if roots and link not in reached:
            yield Defect("ring", link, f"link {link!r} hangs in a ring of joints, not on a root")


def _reachable(roots: list[str], children: dict[str, list[str]]) -> set[str]:
    reached, waiting = set[str](), list(roots)
    while waiting:
        if (link := waiting.pop()) not in reached:
            reached.add(link)
            waiting += children.get(link, [])
    return reached


def check_joints(root: Element) -> Iterator[Defect]:
    """Types, places, axes, limits and mimic rules of the joints."""
    joints = set(names_of(root, "joint"))
    for joint in root.findall("joint"):
        yield from _check_joint(joint)
        if (mimic := joint.find("mimic")) is not None and mimic.get("joint") not in joints:
            name = joint.get("name", "")
            yield Defect("unknown_mimic", name, f"joint {name!r} follows {mimic.get('joint')!r}, which is no joint")
    yield from _check_rings(root)


def _check_joint(joint: Element) -> list[Defect]:
    defects: list[Defect] = []
    name, kind = joint.get("name", ""), joint.get("type")
    if kind not in (*MOVING, "fixed"):
        message = f"joint {name!r} is of type {kind!r}; known are {', '.join(MOVING)} and fixed"
        defects.append(Defect("joint_type", name, message))
    try_read(lambda: pose(joint.find("origin")), name, defects)
    if kind in MOVING:
        _check_axis(joint, name, defects)
        _check_limits(joint, name, defects)
    return defects


def _check_axis(joint: Element, name: str, defects: list[Defect]) -> None:
    axis = try_read(lambda: vector(joint.find("axis"), "xyz", (1.0, 0.0, 0.0)), name, defects)
    if axis is None:
        return
    try:
        axis_of(joint)
    except RobotModelError as error:
        defects.append(Defect("zero_axis", name, error.message))
        return
    length = float(np.linalg.norm(axis))
    if abs(length - 1) > 1e-3:
        message = f"the axis of joint {name!r} has length {length:.6g}, not one"
        defects.append(Defect("axis_length", name, message, "warning"))


def _check_limits(joint: Element, name: str, defects: list[Defect]) -> None:
    limit = joint.find("limit")
    if limit is None:
        if joint.get("type") != "continuous":
            defects.append(Defect("no_limit", name, f"joint {name!r} has no limit"))
        return
    read = _Numbers(name, defects)
    lower, upper = read(limit, "lower", 0.0), read(limit, "upper", 0.0)
    if joint.get("type") != "continuous" and lower is not None and upper is not None:
        _check_range(name, (lower, upper), defects)
        _check_soft_limits(joint, (lower, upper), read)
    for attribute in ("velocity", "effort"):
        if limit.get(attribute) is None:
            defects.append(Defect("no_limit", name, f"the limit of joint {name!r} says no {attribute}"))
        elif (value := read(limit, attribute, 0.0)) is not None and value < 0:
            defects.append(Defect("negative_limit", name, f"the {attribute} of joint {name!r} is {value:.6g}"))


class _Numbers:
    """Reads single numbers of one joint, and notes what is none."""

    def __init__(self, name: str, defects: list[Defect]) -> None:
        self.name, self.defects = name, defects

    def __call__(self, element: Element, attribute: str, default: float) -> float | None:
        return try_read(lambda: float(vector(element, attribute, (default,))[0]), self.name, self.defects)


def _check_range(name: str, limits: tuple[float, float], defects: list[Defect]) -> None:
    lower, upper = limits
    if lower > upper:
        message = f"the limits of joint {name!r} are reversed: {lower:.6g} .. {upper:.6g}"
        defects.append(Defect("reversed_limits", name, message))
    elif lower == upper:
        message = f"joint {name!r} cannot move: its limits are {lower:.6g} .. {upper:.6g}"
        defects.append(Defect("no_range", name, message, "warning"))


def _check_soft_limits(joint: Element, limits: tuple[float, float], read: _Numbers) -> None:
    if (safety := joint.find("safety_controller")) is None:
        return
    lower, upper = read(safety, "soft_lower_limit", limits[0]), read(safety, "soft_upper_limit", limits[1])
    if lower is not None and upper is not None and not limits[0] <= lower <= upper <= limits[1]:
        message = (
            f"the soft limits of joint {read.name!r}, {lower:.6g} .. {upper:.6g}, are not inside "
            f"{limits[0]:.6g} .. {limits[1]:.6g}"
        )
        read.defects.append(Defect("soft_limits", read.name, message, "warning"))


def _check_rings(root: Element) -> Iterator[Defect]:
    moving = [joint.get("name", "") for joint in root.findall("joint") if joint.get("type") in MOVING]
    try:
        read_joint_map(root, moving)
    except RobotModelError as error:
        yield Defect("mimic", str(error.numbers.get("joint", "robot")), error.message)
