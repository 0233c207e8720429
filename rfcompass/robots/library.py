"""Robots by name: ours, and those of the robots extra (`pip install rfcompass[robots]`)."""

from collections import Counter
from dataclasses import replace
from pathlib import Path

from rfcompass.errors import UnknownRobot
from rfcompass.robots.description import RobotDescription, load_description
from rfcompass.robots.layouts import data_folder, find_layout, load_layout
from rfcompass.robots.packages import extra_folder
from rfcompass.robots.robot import Robot

# A file of the extra that no parser accepts: it is empty.
_UNUSABLE = frozenset({"ur3"})


def known_robots() -> tuple[str, ...]:
    """Names that `load_robot` takes, sorted; those of the extra only if it is installed."""
    return tuple(sorted({**_extra_urdfs(), **_described()}))


def described_robots() -> tuple[str, ...]:
    """Names of the robots for which we ship tags and tool axes, sorted; of the extra only if it is installed."""
    return tuple(sorted(_described()))


def load_robot(name: str | Path, layout: str | None = None) -> Robot:
    """Make a robot.

    Args:
        name: A known name, the path of a robot description (`.json`), or the path of a URDF. A robot of the extra for
            which we ship no description, and a bare URDF, have a fixed base, no tool and, without `layout`, no tags.
        layout: Tag layout to use in place of the robot's own: a shipped name or the path of a JSON file.

    Raises:
        UnknownRobot: If there is no such robot or layout; lists those that there are.
        RobotModelError: If a file breaks its format, or the layout does not fit the robot.
    """
    return Robot(describe_robot(name, layout))


def describe_robot(name: str | Path, layout: str | None = None) -> RobotDescription:
    """Find a robot's description without loading its URDF; arguments and errors as for `load_robot`."""
    file = Path(name)
    if (description := _described().get(str(name))) is not None:
        return load_description(description, layout)
    if file.suffix == ".json" and file.is_file():
        return load_description(file, layout)
    if (urdf := _extra_urdfs().get(str(name))) is not None:
        return _bare(str(name), urdf, layout)
    if file.suffix == ".urdf" and file.is_file():
        return _bare(file.stem, file, layout)
    raise _unknown(str(name))


def _bare(name: str, urdf: Path, layout: str | None) -> RobotDescription:
    bare = RobotDescription(name=name, urdf=urdf)
    if layout is None:
        return bare
    file = find_layout(layout, name)
    return replace(bare, layout=load_layout(file), layout_name=file.stem)


def _described() -> dict[str, Path]:
    """Descriptions that we ship, except those of a missing extra."""
    files = (data_folder() / "robots").glob("*.json")
    extra = extra_folder() is not None
    return {file.stem: file for file in files if extra or not file.read_text(encoding="utf-8").count("package://")}


def _extra_urdfs() -> dict[str, Path]:
    """URDFs of the extra by name: that of the file, with its package in front where two share it."""
    folder = extra_folder()
    files = sorted((folder / "robots").rglob("*.urdf")) if folder else []
    count = Counter(file.stem for file in files)
    named = {(f"{_package_of(file)}/{file.stem}" if count[file.stem] > 1 else file.stem): file for file in files}
    return {name: file for name, file in named.items() if name not in _UNUSABLE}


def _package_of(file: Path) -> str:
    return file.parent.parent.name.removesuffix("_description")


def _unknown(name: str) -> UnknownRobot:
    known = known_robots()
    hint = "" if extra_folder() else "; many more come with `pip install rfcompass[robots]`"
    message = f"no robot {name!r}; known: {', '.join(known)}{hint}, or the path of a .urdf or .json file"
    return UnknownRobot(message, name=name, known=list(known))
