"""Defects of a URDF's links: inertia, shapes and meshes."""

from collections.abc import Iterator, Sequence
from functools import cache
from pathlib import Path
from xml.etree.ElementTree import Element

import numpy as np

from rfcompass.arrays import FloatArray
from rfcompass.errors import RobotModelError
from rfcompass.robots.check_joints import MOVING
from rfcompass.robots.defect import Defect, try_read
from rfcompass.robots.packages import resolve
from rfcompass.robots.shapes import dimensions_of
from rfcompass.robots.urdf_xml import first_child, link_of, pose, vector

_AXES = "xyz"


def check_inertias(root: Element) -> Iterator[Defect]:
    """Masses above zero, inertia matrices that a body can have, none missing on what moves and collides."""
    driven = {link_of(joint, "child") for joint in root.findall("joint") if joint.get("type") in MOVING}
    for link in root.findall("link"):
        name, inertial = link.get("name", ""), link.find("inertial")
        if inertial is not None:
            yield from _check_inertial(inertial, name)
        elif name in driven and link.find("collision") is not None:
            yield Defect("no_inertia", name, f"link {name!r} moves and has no mass", "warning")


def _check_inertial(inertial: Element, name: str) -> list[Defect]:
    defects: list[Defect] = []
    try_read(lambda: pose(inertial.find("origin")), name, defects)
    mass = try_read(lambda: float(vector(inertial.find("mass"), "value", (0.0,))[0]), name, defects)
    if mass is not None and mass <= 0:
        defects.append(Defect("zero_mass", name, f"link {name!r} has a mass of {mass:.6g} kg", "warning"))
    matrix = try_read(lambda: inertia_of(inertial.find("inertia")), name, defects)
    if matrix is None or (mass == 0 and not matrix.any()):
        return defects
    moments = np.linalg.eigvalsh(matrix)
    if moments[0] <= 0:
        message = f"link {name!r} has inertia with the principal moment {moments[0]:.3g} kg m²"
        defects.append(Defect("zero_inertia", name, message, "warning"))
    elif moments[2] > (moments[0] + moments[1]) * (1 + 1e-6):
        message = f"no body has the principal moments of link {name!r}: {moments[2]:.3g} > the sum of the others"
        defects.append(Defect("impossible_inertia", name, message, "warning"))
    return defects


def inertia_of(inertia: Element | None) -> FloatArray:
    """Inertia matrix [kg m²], shape (3, 3).

    Raises:
        RobotModelError: If an entry is no number.
    """
    matrix = np.zeros((3, 3))
    for i, j in ((0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)):
        matrix[i, j] = matrix[j, i] = vector(inertia, f"i{_AXES[i]}{_AXES[j]}", (0.0,))[0]
    return matrix


def check_shapes(root: Element, urdf: Path, package_dirs: Sequence[Path]) -> Iterator[Defect]:
    """Shapes with a size and a place, materials that exist, meshes that are there and can be read."""
    materials = {material.get("name") for material in root.iter("material") if len(material)}
    for material in root.iter("material"):
        yield from _check_colour(material)
    for link in root.findall("link"):
        for shape in [*link.findall("visual"), *link.findall("collision")]:
            yield from _check_shape(shape, link.get("name", ""), urdf, package_dirs)
            paint = shape.find("material")
            if paint is not None and not len(paint) and paint.get("name") not in materials:
                message = f"link {link.get('name')!r} is painted {paint.get('name')!r}, which is no material"
                yield Defect("unknown_material", link.get("name", ""), message, "warning")


def _check_colour(material: Element) -> list[Defect]:
    defects: list[Defect] = []
    colour = material.find("color")
    try_read(lambda: vector(colour, "rgba", (1.0, 1.0, 1.0, 1.0)), material.get("name", ""), defects)
    return defects


def _check_shape(shape: Element, name: str, urdf: Path, package_dirs: Sequence[Path]) -> Iterator[Defect]:
    defects: list[Defect] = []
    try_read(lambda: pose(shape.find("origin")), name, defects)
    geometry = shape.find("geometry")
    if geometry is None or (element := first_child(geometry)) is None:
        yield Defect("no_geometry", name, f"a <{shape.tag}> of link {name!r} has no shape")
        return
    size = try_read(lambda: dimensions_of(element), name, defects)
    if size is not None and (size <= 0).any() and not (element.tag == "mesh" and (size != 0).all()):
        defects.append(Defect("no_size", name, f"a {element.tag} of link {name!r} has the size {size.tolist()}"))
    yield from defects
    if element.tag == "mesh":
        yield from _check_mesh(element.get("filename", ""), name, urdf, package_dirs)


def _check_mesh(uri: str, name: str, urdf: Path, package_dirs: Sequence[Path]) -> Iterator[Defect]:
    try:
        file = resolve(uri, urdf, package_dirs)
    except RobotModelError as error:
        yield Defect("unknown_package", name, error.message)
        return
    if not uri or not file.is_file():
        yield Defect("missing_mesh", name, f"link {name!r}: there is no mesh {uri!r} (looked at {file})")
    elif file.suffix.lower() == ".dae":
        yield Defect("dae_mesh", name, f"{uri}: Collada meshes are not drawn; convert it to STL", "warning")
    elif (reason := _why_unreadable(file, file.stat().st_mtime_ns)) is not None:
        yield Defect("broken_mesh", name, f"{uri}: cannot be read as a mesh: {reason}")


@cache
def _why_unreadable(file: Path, changed_ns: int) -> str | None:  # noqa: ARG001 - part of the cache's key
    import trimesh  # noqa: PLC0415 - slow to import, and needed only here

    try:
        mesh = trimesh.load_mesh(file)
    except Exception as error:
        return f"{type(error).__name__}: {error}"
    return None if mesh.vertices.size else "it is empty"
