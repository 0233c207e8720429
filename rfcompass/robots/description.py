"""A robot as data: a URDF, a tag layout, and the names that the URDF does not give a meaning to."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from rfcompass.arrays import FloatArray, read_only
from rfcompass.errors import RobotModelError
from rfcompass.robots.json_files import JsonFile
from rfcompass.robots.layouts import find_layout, load_layout, no_tags
from rfcompass.robots.packages import resolve
from rfcompass.types.record import Record, frozen_mapping
from rfcompass.types.tags import TagLayout

SCHEMA = "rfcompass-robot/1"
BASES = ("planar", "fixed")


@dataclass(frozen=True, slots=True)
class Tool(Record):
    """Where a robot grasps.

    Attributes:
        frame: URDF link whose origin is the grasp point.
        approach_axis: Direction in which the hand moves towards a part, in that frame, unit vector, shape (3,).
        closing_axis: Direction along which the fingers close, in that frame, unit vector, shape (3,).
        payload_kg: Heaviest thing that the arm may carry [kg]; infinite if nobody said so.
    """

    frame: str
    approach_axis: FloatArray
    closing_axis: FloatArray
    payload_kg: float = np.inf

    def __post_init__(self) -> None:
        """Freeze the axes; they must be perpendicular and of length one, and the payload above zero."""
        if not self.payload_kg > 0:
            raise RobotModelError(f"tool {self.frame}: payload {self.payload_kg} kg is not above 0", frame=self.frame)
        for name in ("approach_axis", "closing_axis"):
            object.__setattr__(self, name, read_only(getattr(self, name), f"Tool.{name}", (3,)))
        axes = np.array([self.approach_axis, self.closing_axis])
        if not np.allclose(axes @ axes.T, np.eye(2), atol=1e-6):
            message = f"tool {self.frame}: approach and closing axis {axes.tolist()} are no perpendicular unit vectors"
            raise RobotModelError(message, frame=self.frame)


@dataclass(frozen=True, slots=True)
class RobotDescription(Record):
    """All that makes a robot out of a URDF.

    Attributes:
        name: What to call it.
        urdf: URDF file.
        layout: Tags on it.
        layout_name: What to call that layout; empty if there is none.
        base: `"planar"` (drives in x, y, θ) or `"fixed"`.
        base_frame: Link that is the frame "base", rigid to the URDF's root; the root if empty. Heights count from it.
        tool: Where it grasps; None if nobody said so.
        postures: Named joint values, `{posture: {joint: value}}`; joints left out are at rest.
        package_dirs: Where to look for the packages that the URDF names.
    """

    name: str
    urdf: Path
    layout: TagLayout = field(default_factory=no_tags)
    layout_name: str = ""
    base: str = "fixed"
    base_frame: str = ""
    tool: Tool | None = None
    postures: Mapping[str, Mapping[str, float]] = field(default_factory=dict)
    package_dirs: tuple[Path, ...] = ()

    def __post_init__(self) -> None:
        """Check the kind of base; freeze the postures."""
        if self.base not in BASES:
            raise RobotModelError(f"robot {self.name}: base {self.base!r} is none of {BASES}", base=self.base)
        frozen = {name: frozen_mapping(joints) for name, joints in self.postures.items()}
        object.__setattr__(self, "postures", frozen_mapping(frozen))


def load_description(path: str | Path, layout: str | None = None) -> RobotDescription:
    """Read a robot from a JSON file.

    Args:
        path: File of schema `rfcompass-robot/1`; the files it names may be relative to it, or `package://`.
        layout: Tag layout to use in place of the robot's own: a name or a path.

    Raises:
        RobotModelError: If the file or the layout breaks the format.
        UnknownRobot: If there is no such layout.
    """
    file = JsonFile(Path(path), SCHEMA)
    name = file.text("name")
    package_dirs = tuple(file.path.parent / folder for folder in file.texts("package_dirs"))
    layout_file = find_layout(layout, name) if layout else _layout_file(file)
    return RobotDescription(
        name=name,
        urdf=resolve(file.text("urdf"), file.path, package_dirs),
        layout=load_layout(layout_file) if layout_file else no_tags(),
        layout_name=layout_file.stem if layout_file else "",
        base=file.text("base"),
        base_frame=file.text("base_frame", ""),
        tool=_read_tool(file),
        postures=_read_postures(file),
        package_dirs=package_dirs,
    )


def _layout_file(file: JsonFile) -> Path | None:
    own = file.text("tag_layout", "")
    return file.path.parent / own if own else None


def _read_tool(file: JsonFile) -> Tool | None:
    frame = file.text("tool_frame", "")
    if not frame:
        return None
    approach_axis = file.vector("approach_axis", (0.0, 0.0, 1.0))
    closing_axis = file.vector("closing_axis", (0.0, 1.0, 0.0))
    return Tool(frame, approach_axis, closing_axis, file.number("payload_kg", np.inf))


def _read_postures(file: JsonFile) -> dict[str, dict[str, float]]:
    postures = file.mapping("postures")
    for name, joints in postures.items():
        numbers = isinstance(joints, dict) and all(type(value) in (int, float) for value in joints.values())
        if not numbers:
            raise file.error(f"posture {name} is no object of joint values", key="postures")
    return postures
