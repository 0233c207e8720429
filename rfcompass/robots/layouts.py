"""Tag layouts as JSON files: where the tags of a robot are mounted.

`counterparts` says, for K tags on a part, which of them belongs to the hand's left and right tag when the hand
holds the part across its middle. Part tags are counted from 0, from the part's -x to its +x end.
"""

import json
from importlib.resources import files
from pathlib import Path
from typing import Any

import numpy as np

from rfcompass.errors import InputError, RobotModelError, UnknownRobot
from rfcompass.files import write_text_atomic
from rfcompass.robots.json_files import JsonFile
from rfcompass.types.epc import canonical_epc
from rfcompass.types.tags import TagLayout

SCHEMA = "rfcompass-tags/1"


def data_folder() -> Path:
    """Folder of the robot, part and layout files that we ship."""
    return Path(str(files("urdf")))


def no_tags() -> TagLayout:
    """Layout of a robot without tags."""
    return TagLayout("robot", (), (), np.empty((0, 3)), np.empty((0, 3)), ())


def known_layouts() -> tuple[str, ...]:
    """Names of the layouts that we ship, sorted."""
    return tuple(sorted(file.stem for file in (data_folder() / "layouts").glob("*.json")))


def find_layout(name: str, robot: str = "") -> Path:
    """File of a layout.

    Args:
        name: A shipped name ("youbot_x4"; with `robot` given, "x4" will do) or the path of a JSON file.
        robot: Name of the robot that it is for.

    Raises:
        UnknownRobot: If there is no such layout; lists those that there are.
    """
    for stem in (f"{robot}_{name}", name):
        if stem in known_layouts():
            return data_folder() / "layouts" / f"{stem}.json"
    if (file := Path(name)).suffix == ".json" and file.is_file():
        return file
    known = known_layouts()
    message = f"no tag layout {name!r}; known: {', '.join(known)}, or the path of a JSON file"
    raise UnknownRobot(message, name=name, known=list(known))


def load_layout(path: str | Path) -> TagLayout:
    """Read a tag layout from a JSON file.

    Raises:
        RobotModelError: If the file breaks the format; names the key.
        DuplicateEpc: If an EPC stands twice.
    """
    file = JsonFile(Path(path), SCHEMA)
    tags = file.objects("tags")
    try:
        return TagLayout(
            body="robot",
            epcs=tuple(_epc(file, tag) for tag in tags),
            frames=tuple(file.text_of(tag, "link") for tag in tags),
            points_m=np.array([file.vector_of(tag, "point_m") for tag in tags]).reshape(-1, 3),
            dipoles=np.array([file.vector_of(tag, "dipole") for tag in tags]).reshape(-1, 3),
            roles=tuple(file.text_of(tag, "role") for tag in tags),
            counterparts=_counterparts(file),
        )
    except RobotModelError:
        raise
    except InputError as error:
        raise type(error)(f"{path}: {error.message}", **error.numbers, file=str(path)) from error


def write_layout(layout: TagLayout, path: str | Path, description: str = "") -> Path:
    """Write a robot's tag layout as a JSON file that `load_layout` reads.

    Args:
        layout: The tags.
        path: File to write; one that is there is replaced.
        description: What the layout is for.
    """
    tags = [
        {"epc": epc, "link": link, "point_m": point_m, "dipole": dipole, "role": role}
        for epc, link, point_m, dipole, role in zip(
            layout.epcs, layout.frames, layout.points_m.tolist(), layout.dipoles.tolist(), layout.roles, strict=True
        )
    ]
    counterparts = {str(K): dict(pairs) for K, pairs in layout.counterparts.items()}
    content = {"schema": SCHEMA, "description": description, "tags": tags, "counterparts": counterparts}
    write_text_atomic(Path(path), json.dumps(content, indent=2, ensure_ascii=False) + "\n")
    return Path(path)


def _epc(file: JsonFile, tag: dict[str, Any]) -> str:
    text = file.text_of(tag, "epc")
    try:
        return canonical_epc(text)
    except InputError as error:
        raise file.error(error.message, **error.numbers, key="epc") from error


def _counterparts(file: JsonFile) -> dict[int, dict[str, int]]:
    found: dict[int, dict[str, int]] = {}
    for text, pairs in file.mapping("counterparts").items():
        K = int(text) if text.isdecimal() else 0
        sides = isinstance(pairs, dict) and set(pairs) == {"hand_left", "hand_right"}
        if not sides or not all(type(i) is int and 0 <= i < K for i in pairs.values()):
            message = f"counterparts of {text} part tags must be hand_left and hand_right, each from 0 to {K - 1}"
            raise file.error(message, key="counterparts")
        found[K] = pairs
    return found
