"""Is this URDF usable? Every defect is named, not only the first."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from xml.etree.ElementTree import Element

from rfcompass.errors import RobotModelError
from rfcompass.robots.check_joints import MOVING, check_joints, check_tree, names_of
from rfcompass.robots.check_links import check_inertias, check_shapes
from rfcompass.robots.defect import Defect
from rfcompass.robots.kinematics import Kinematics
from rfcompass.robots.urdf_xml import read_urdf
from rfcompass.types.record import Record


@dataclass(frozen=True, slots=True)
class RobotReport(Record):
    """What was found in a URDF.

    Attributes:
        file: The URDF.
        name: Name of the robot; empty if the file could not be read.
        links: All links.
        joints: All joints.
        moving: Joints that move.
        defects: All that is wrong, in the order of the file.
    """

    file: str
    name: str = ""
    links: tuple[str, ...] = ()
    joints: tuple[str, ...] = ()
    moving: tuple[str, ...] = ()
    defects: tuple[Defect, ...] = ()

    @property
    def errors(self) -> tuple[Defect, ...]:
        """Defects with which the robot cannot be used."""
        return tuple(defect for defect in self.defects if defect.severity == "error")

    @property
    def ok(self) -> bool:
        """True if the robot can be used."""
        return not self.errors

    def require_ok(self) -> None:
        """Accept a usable robot.

        Raises:
            RobotModelError: If it has errors; names all of them.
        """
        if self.errors:
            listed = "; ".join(defect.message for defect in self.errors)
            kinds = sorted({defect.kind for defect in self.errors})
            raise RobotModelError(f"{self.file}: {len(self.errors)} errors: {listed}", file=self.file, kinds=kinds)


def check_urdf(path: str | Path, package_dirs: Sequence[str | Path] = (), frames: Sequence[str] = ()) -> RobotReport:
    """Look for everything that is wrong with a URDF.

    A file with a document type (external entities) is refused before any parser resolves it. If our own checks
    find no error, yourdfpy and pinocchio must accept the robot as well.

    Args:
        path: The URDF.
        package_dirs: Packages, or folders that hold packages, for `package://`; the URDF's parents are searched too.
        frames: Links that must exist, such as the tool frame and those of a tag layout.

    Returns:
        The report; nothing is raised for a broken file.
    """
    file = Path(path)
    try:
        root = read_urdf(file)
    except RobotModelError as error:
        kind = "document_type" if "doctype" in error.numbers else "unreadable"
        return RobotReport(str(file), defects=(Defect(kind, str(file), error.message),))
    defects = [
        *check_tree(root),
        *check_joints(root),
        *check_inertias(root),
        *check_shapes(root, file, [Path(folder) for folder in package_dirs]),
        *_missing_frames(root, frames),
    ]
    if not any(defect.severity == "error" and defect.kind not in _ABOUT_MESHES for defect in defects):
        defects += _loader_defects(file, root)
    joints = root.findall("joint")
    return RobotReport(
        file=str(file),
        name=root.get("name", ""),
        links=tuple(names_of(root, "link")),
        joints=tuple(names_of(root, "joint")),
        moving=tuple(joint.get("name", "") for joint in joints if joint.get("type") in MOVING),
        defects=tuple(defects),
    )


# Kinematics do without meshes.
_ABOUT_MESHES = ("missing_mesh", "unknown_package", "broken_mesh")


def _missing_frames(root: Element, frames: Sequence[str]) -> list[Defect]:
    links = names_of(root, "link")
    known = ", ".join(links)
    return [
        Defect("missing_frame", frame, f"there is no link {frame!r}; there are: {known}")
        for frame in dict.fromkeys(frames)
        if frame not in links
    ]


def _loader_defects(file: Path, root: Element) -> list[Defect]:
    """What the two libraries that use URDFs say to it."""
    import yourdfpy  # noqa: PLC0415 - takes seconds to import

    defects = []
    try:
        yourdfpy.URDF.load(str(file), load_meshes=False)
    except Exception as error:
        message = f"yourdfpy cannot load it: {type(error).__name__}: {error}"
        defects.append(Defect("yourdfpy", str(file), message))
    try:
        Kinematics(root)
    except RobotModelError as error:
        defects.append(Defect("pinocchio", str(file), error.message))
    return defects
