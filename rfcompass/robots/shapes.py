"""The visible and the solid shapes of a URDF, read without loading a mesh."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from xml.etree.ElementTree import Element

import numpy as np

from rfcompass.arrays import FloatArray
from rfcompass.errors import RobotModelError
from rfcompass.robots.packages import resolve
from rfcompass.robots.urdf_xml import first_child, pose, vector
from rfcompass.types.placed_shape import DRAWN_MESHES, PlacedShape

_GREY = (0.7, 0.7, 0.72, 1.0)


@dataclass(frozen=True, slots=True)
class LinkShape:
    """A shape at its place in a link; fields as in `PlacedShape`."""

    link: str
    kind: str
    dimensions_m: FloatArray
    T_link_shape: FloatArray
    rgba: FloatArray
    mesh: Path | None

    def placed(self, T_world_link: FloatArray) -> PlacedShape:
        """Put the shape into the world, with the link at a homogeneous pose of shape (4, 4)."""
        return PlacedShape(
            self.link, self.kind, self.dimensions_m, T_world_link @ self.T_link_shape, self.rgba, self.mesh
        )  # fmt: skip


def read_visuals(root: Element, urdf: Path, package_dirs: Sequence[Path]) -> tuple[LinkShape, ...]:
    """Read what to draw of a robot: every visual; of a link whose meshes cannot be drawn, its collision shapes.

    A mesh can be drawn if its file is there and is STL or OBJ; many URDFs have DAE for the eye and STL for collisions.
    What has neither is left out.

    Raises:
        RobotModelError: If a size, pose or colour is no number.
    """
    colours = {material.get("name", ""): colour for material in root.findall("material") if (colour := _rgba(material))}

    def read(link: Element, kind: str) -> list[LinkShape | None]:
        found, name = link.findall(kind), link.get("name", "")
        return [_read_shape(name, element, colours, (urdf, package_dirs)) for element in found]

    drawn: list[LinkShape] = []
    for link in root.findall("link"):
        seen = read(link, "visual")
        shown = [shape for shape in seen if shape is not None and _can_be_drawn(shape)]
        stand_in = [] if len(shown) == len(seen) else read(link, "collision")
        drawn += [shape for shape in stand_in if shape is not None and _can_be_drawn(shape)] or shown
    return tuple(drawn)


def _can_be_drawn(shape: LinkShape) -> bool:
    return shape.mesh is None or shape.mesh.suffix.lower() in DRAWN_MESHES


def read_collisions(root: Element, urdf: Path, package_dirs: Sequence[Path]) -> tuple[LinkShape, ...]:
    """Read every collision shape of a robot; a mesh that is nowhere is an error, since nobody would miss it.

    Raises:
        RobotModelError: If a size or pose is no number, or a mesh is missing; names link and file.
    """
    shapes = []
    for link in root.findall("link"):
        name = link.get("name", "")
        for solid in link.findall("collision"):
            if (shape := _read_shape(name, solid, {}, (urdf, package_dirs))) is None:
                mesh = None if (element := solid.find("geometry/mesh")) is None else element.get("filename")
                message = f"link {name!r}: its collision shape is missing: {mesh or 'no geometry'}"
                raise RobotModelError(message, link=name, file=mesh)
            shapes.append(shape)
    return tuple(shapes)


def _read_shape(
    link: str, visual: Element, colours: Mapping[str, tuple[float, ...]], place: tuple[Path, Sequence[Path]]
) -> LinkShape | None:
    geometry = visual.find("geometry")
    if geometry is None or (element := first_child(geometry)) is None:
        return None
    mesh = None
    if element.tag == "mesh" and (mesh := _mesh_file(element, *place)) is None:
        return None
    material = visual.find("material")
    name = "" if material is None else material.get("name", "")
    rgba = (None if material is None else _rgba(material)) or colours.get(name, _GREY)
    return LinkShape(link, element.tag, dimensions_of(element), pose(visual.find("origin")), np.array(rgba), mesh)


def dimensions_of(element: Element) -> FloatArray:
    """Numbers of a box, cylinder, sphere or mesh, as `PlacedShape.dimensions_m` wants them.

    Raises:
        RobotModelError: If they are no numbers, or the element is none of the four.
    """
    if element.tag == "box":
        return vector(element, "size", (0.0, 0.0, 0.0))
    if element.tag == "cylinder":
        return np.concatenate([vector(element, name, (0.0,)) for name in ("radius", "length")])
    if element.tag == "sphere":
        return vector(element, "radius", (0.0,))
    if element.tag == "mesh":
        return vector(element, "scale", (1.0, 1.0, 1.0))
    raise RobotModelError(f"<{element.tag}> is no box, cylinder, sphere or mesh", shape=element.tag)


def _mesh_file(mesh: Element, urdf: Path, package_dirs: Sequence[Path]) -> Path | None:
    try:
        file = resolve(mesh.get("filename", ""), urdf, package_dirs)
    except RobotModelError:
        return None
    return file if file.is_file() else None


def _rgba(material: Element) -> tuple[float, ...] | None:
    colour = material.find("color")
    return None if colour is None else tuple(vector(colour, "rgba", _GREY))
