"""Tags in a URDF: fixed links `tag_1`, `tag_2`, … whose z axis is the tag's dipole."""

import copy
import re
from pathlib import Path
from xml.etree.ElementTree import Element, SubElement

import numpy as np

from rfcompass.arrays import FloatArray
from rfcompass.errors import RobotModelError
from rfcompass.files import write_text_atomic
from rfcompass.robots.urdf_xml import link_of, read_urdf, urdf_text, words
from rfcompass.types.tags import TagLayout

# Drawn size of a tag [m]: an inlay of about 97 x 11 mm, as a rod, since a layout does not say where it faces.
TAG_SIZE_M = (0.011, 0.011, 0.097)

_TAG_LINK = re.compile(r"tag_\d+")


def tag_urdf(urdf_path: str | Path, layout: TagLayout, out_path: str | Path) -> Path:
    """Write a copy of a URDF that carries the tags of a layout, all of it or nothing.

    Tag links that are there already are replaced. EPCs and roles do not fit into a URDF: keep the layout file.

    Args:
        urdf_path: URDF to read.
        layout: Tags to mount; tag i becomes link `tag_i`, counted from 1.
        out_path: File to write; replaced if it exists.

    Returns:
        `out_path`.

    Raises:
        RobotModelError: If the URDF cannot be read, or the layout names a link that it does not have.
    """
    out = Path(out_path)
    root = read_urdf(urdf_path)
    text = urdf_text(with_tags(root, layout))
    try:
        write_text_atomic(out, text)
    except OSError as cause:
        raise RobotModelError(f"{out}: cannot be written: {cause.strerror}", file=str(out)) from cause
    return out


def tag_links(layout: TagLayout) -> tuple[str, ...]:
    """Names of the links that the tags of a layout become (N)."""
    return tuple(f"tag_{i}" for i in range(1, len(layout.epcs) + 1))


def with_tags(root: Element, layout: TagLayout) -> Element:
    """Return a copy of a robot with its tag links replaced by those of a layout.

    Raises:
        RobotModelError: If the layout names a link that the robot does not have; lists those it has.
    """
    tagged = copy.deepcopy(root)
    _remove_tags(tagged)
    links = {link.get("name", "") for link in tagged.findall("link")}
    if unknown := sorted(set(layout.frames) - links):
        message = (
            f"robot {root.get('name')!r} has no link {unknown[0]!r} to put a tag on; it has: {', '.join(sorted(links))}"
        )
        raise RobotModelError(message, link=unknown[0], links=sorted(links))
    if taken := sorted(set(tag_links(layout)) & links):
        raise RobotModelError(f"link {taken[0]!r} of robot {root.get('name')!r} is no tag of ours", link=taken[0])
    for name, parent, point_m, dipole in zip(
        tag_links(layout), layout.frames, layout.points_m, layout.dipoles, strict=True
    ):
        _add_tag(tagged, name, parent, point_m, dipole)
    return tagged


def _remove_tags(root: Element) -> None:
    """Remove the fixed links `tag_<number>` that carry nothing else."""
    parents = {link_of(joint, "parent") for joint in root.findall("joint")}
    for joint in root.findall("joint"):
        child = link_of(joint, "child")
        if _TAG_LINK.fullmatch(child) and joint.get("type") == "fixed" and child not in parents:
            root.remove(joint)
            for link in [link for link in root.findall("link") if link.get("name") == child]:
                root.remove(link)


def _add_tag(root: Element, name: str, parent: str, point_m: FloatArray, dipole: FloatArray) -> None:
    link = SubElement(root, "link", name=name)
    visual = SubElement(link, "visual")
    SubElement(SubElement(visual, "geometry"), "box", size=words(np.array(TAG_SIZE_M)))
    material = SubElement(visual, "material", name="rfid_tag")
    SubElement(material, "color", rgba="0.1 0.7 0.35 1")
    joint = SubElement(root, "joint", name=f"{name}_joint", type="fixed")
    SubElement(joint, "parent", link=parent)
    SubElement(joint, "child", link=name)
    SubElement(joint, "origin", xyz=words(point_m), rpy=words(rpy_of_axis(dipole)))


def rpy_of_axis(axis: FloatArray) -> FloatArray:
    """Roll, pitch and yaw (yaw 0) of a frame whose z axis is the unit vector `axis` [rad], shape (3,).

    Rz(0) Ry(pitch) Rx(roll) e_z = [sin(pitch) cos(roll), -sin(roll), cos(pitch) cos(roll)].
    """
    x, y, z = axis
    return np.array([-np.arctan2(y, np.hypot(x, z)), np.arctan2(x, z), 0.0])
