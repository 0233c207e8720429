"""URDF text: read without ever resolving an entity, and the few look-ups that everything else needs.

A URDF from elsewhere is not to be trusted: a document type could make a parser read other files or the
network (external entities) or fill the memory (nested entities). A URDF needs neither, so any document
type is refused before a parser resolves it.
"""

from pathlib import Path
from typing import NoReturn
from xml.etree.ElementTree import Element, TreeBuilder, tostring
from xml.parsers import expat

import numpy as np

from rfcompass.arrays import FloatArray
from rfcompass.errors import RobotModelError

# No robot nests its elements deeper; a file that does wants to exhaust our stack.
_DEEPEST = 100


def read_urdf(path: str | Path) -> Element:
    """Read the file of a robot as XML; comments in front of the root are kept inside it.

    Raises:
        RobotModelError: If the file cannot be read, is no XML, declares a document type, or is no `<robot>`.
    """
    file = Path(path)
    try:
        data = file.read_bytes()
    except OSError as cause:
        raise RobotModelError(f"{file}: cannot be read: {cause.strerror}", file=str(file)) from cause
    return parse_urdf(data, str(file))


def parse_urdf(data: bytes, name: str) -> Element:
    """Read URDF text; `name` is what to call it in errors.

    Raises:
        RobotModelError: As `read_urdf` does.
    """
    try:
        root = _Reader(name).read(data)
    except expat.ExpatError as cause:
        raise RobotModelError(f"{name}: is no XML: {cause}", file=name) from cause
    if root.tag != "robot":
        raise RobotModelError(f"{name}: the root is <{root.tag}>, not <robot>", file=name)
    return root


def urdf_text(root: Element) -> str:
    """Write a robot back as text."""
    return '<?xml version="1.0" encoding="utf-8"?>\n' + tostring(root, encoding="unicode") + "\n"


class _Reader:
    """Feeds expat's events to a tree builder, and stops at the first sign of a document type."""

    def __init__(self, name: str) -> None:
        self._name, self._depth, self._prolog = name, 0, list[str]()
        self._builder = TreeBuilder(insert_comments=True)

    def read(self, data: bytes) -> Element:
        parser = expat.ParserCreate()
        parser.buffer_text = True
        parser.StartDoctypeDeclHandler = self._refuse_doctype
        parser.StartElementHandler = self._start
        parser.EndElementHandler = self._end
        parser.CharacterDataHandler = self._builder.data
        parser.CommentHandler = self._comment
        parser.Parse(data, True)
        return self._builder.close()

    def _refuse_doctype(self, doctype: str, *_: object) -> NoReturn:
        message = f"{self._name}: declares a document type ({doctype}), which could pull in other files; refused"
        raise RobotModelError(message, file=self._name, doctype=doctype)

    def _start(self, tag: str, attributes: dict[str, str]) -> None:
        self._depth += 1
        if self._depth > _DEEPEST:
            raise RobotModelError(f"{self._name}: nests more than {_DEEPEST} elements", file=self._name)
        self._builder.start(tag, attributes)
        while self._prolog and self._depth == 1:
            self._builder.comment(self._prolog.pop(0))

    def _end(self, tag: str) -> None:
        self._depth -= 1
        self._builder.end(tag)

    def _comment(self, text: str) -> None:
        if self._depth:
            self._builder.comment(text)
        else:
            self._prolog.append(text)


def vector(element: Element | None, attribute: str, default: tuple[float, ...]) -> FloatArray:
    """Read an attribute with as many numbers as `default` has.

    Raises:
        RobotModelError: If it holds something else.
    """
    text = None if element is None else element.get(attribute)
    if text is None:
        return np.array(default, dtype=np.float64)
    try:
        values = np.array([float(word) for word in text.split()])
    except ValueError:
        values = np.empty(0)
    if values.shape != (len(default),) or not np.isfinite(values).all():
        raise RobotModelError(f'{attribute}="{text}" is not {len(default)} finite numbers', attribute=attribute)
    return values


def pose(origin: Element | None) -> FloatArray:
    """Read an `<origin>` as a homogeneous pose, shape (4, 4): R = Rz(yaw) Ry(pitch) Rx(roll).

    Raises:
        RobotModelError: If xyz or rpy are not three finite numbers.
    """
    T = np.eye(4)
    T[:3, 3] = vector(origin, "xyz", (0.0, 0.0, 0.0))
    roll, pitch, yaw = vector(origin, "rpy", (0.0, 0.0, 0.0))
    T[:3, :3] = _turn(2, yaw) @ _turn(1, pitch) @ _turn(0, roll)
    return T


def _turn(axis: int, angle_rad: float) -> FloatArray:
    """Rotation about x (0), y (1) or z (2), shape (3, 3)."""
    R, (j, k) = np.eye(3), ((axis + 1) % 3, (axis + 2) % 3)
    R[j, j] = R[k, k] = np.cos(angle_rad)
    R[k, j] = np.sin(angle_rad)
    R[j, k] = -R[k, j]
    return R


def axis_of(joint: Element) -> FloatArray:
    """Unit vector that a joint turns about or slides along, in the joint's frame, shape (3,); x if it names none.

    Raises:
        RobotModelError: If the axis has no direction.
    """
    element, name = joint.find("axis"), joint.get("name")
    axis = vector(element, "xyz", (1.0, 0.0, 0.0) if element is None else (0.0, 0.0, 0.0))
    length = np.linalg.norm(axis)
    if length < 1e-12:
        raise RobotModelError(f"the axis of joint {name!r} has length zero", joint=name)
    return np.asarray(axis / length)


def words(values: FloatArray) -> str:
    """Write numbers as an attribute, without loss."""
    return " ".join(repr(float(value) + 0.0) for value in values)


def first_child(element: Element) -> Element | None:
    """First child that is no comment."""
    return next((child for child in element if isinstance(child.tag, str)), None)


def link_of(joint: Element, end: str) -> str:
    """Name of a joint's `"parent"` or `"child"` link; empty if there is none."""
    element = joint.find(end)
    return "" if element is None else element.get("link", "")
