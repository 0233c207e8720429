"""Parts and assemblies as JSON values, there and back. Reading what was written gives the same record."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from rfcompass.recordings.parts.node import Node
from rfcompass.types.parts import PART_FRAME, Assembly, Part, StablePose, TagSelection
from rfcompass.types.shapes import Box, Cylinder, Mesh, Shape, Sphere
from rfcompass.types.tags import TagLayout

Content = dict[str, Any]

_PART_KEYS = ("id", "shape", "mass_kg", "inertia_kg_m2", "grasp_width_m")
_OPTIONAL_PART_KEYS = ("tags", "layouts", "material", "rigid", "stable_poses")
_MESH_KEYS = ("kind", "vertices_m", "triangles", "pieces_m", "pieces_by", "T_part_file")


def part_content(part: Part) -> Content:
    """Return a part as JSON values."""
    return {
        "id": part.part_id,
        "shape": _shape_content(part.shape),
        "material": part.material,
        "rigid": part.rigid,
        "mass_kg": part.mass_kg,
        "inertia_kg_m2": part.inertia_kg_m2.tolist(),
        "grasp_width_m": part.grasp_width_m,
        "tags": _tags_content(part.tags),
        "layouts": [_selection_content(selection) for selection in part.selections],
        "stable_poses": [
            {"probability": pose.probability, "T_support_part": pose.T_support_part.tolist()}
            for pose in part.stable_poses
        ],
    }


def _shape_content(shape: Shape) -> Content:
    match shape:
        case Box():
            return {"kind": "box", "size_m": shape.size_m.tolist()}
        case Cylinder():
            return {"kind": "cylinder", "radius_m": shape.radius_m, "length_m": shape.length_m, "axis": shape.axis}
        case Sphere():
            return {"kind": "sphere", "radius_m": shape.radius_m}
        case Mesh():
            return {
                "kind": "mesh",
                "vertices_m": shape.vertices_m.tolist(),
                "triangles": shape.triangles.tolist(),
                "pieces_m": [piece.tolist() for piece in shape.pieces_m],
                "pieces_by": shape.pieces_by,
                "T_part_file": shape.T_part_file.tolist(),
            }


def _tags_content(tags: TagLayout) -> list[Content]:
    columns = zip(tags.epcs, tags.points_m.tolist(), tags.dipoles.tolist(), tags.roles, strict=True)
    return [{"epc": epc, "point_m": point_m, "dipole": dipole, "role": role} for epc, point_m, dipole, role in columns]


def _selection_content(selection: TagSelection) -> Content:
    content: Content = {"spacing": selection.spacing, "epcs": list(selection.epcs)}
    if selection.counterparts:
        content["counterparts"] = dict(selection.counterparts)
    return content


def parse_part(node: Node) -> Part:
    """Read a part.

    Raises:
        InputError: If the value breaks the schema or is no possible part; carries `file` and `key`.
    """
    content = node.fields(_PART_KEYS, _OPTIONAL_PART_KEYS)
    part_id = content["id"].text()
    empty = Node([], node.file)
    with node.naming():
        return Part(
            part_id=part_id,
            shape=_parse_shape(content["shape"]),
            mass_kg=content["mass_kg"].number(),
            inertia_kg_m2=np.array(content["inertia_kg_m2"].rows()),
            grasp_width_m=content["grasp_width_m"].number(),
            tags=_parse_tags(content.get("tags", empty), part_id),
            selections=tuple(_parse_selection(item) for item in content.get("layouts", empty).items()),
            stable_poses=tuple(_parse_stable_pose(item) for item in content.get("stable_poses", empty).items()),
            **_stated(content),
        )


def _stated(content: Mapping[str, Node]) -> Content:
    stated: Content = {}
    if "material" in content:
        stated["material"] = content["material"].text()
    if "rigid" in content:
        stated["rigid"] = content["rigid"].flag()
    return stated


def _parse_shape(node: Node) -> Shape:
    kind = node.entries().get("kind", Node(None, node.file, f"{node.key}.kind"))
    with node.naming():
        match kind.value:
            case "box":
                return Box(np.array(node.fields(("kind", "size_m"))["size_m"].numbers()))
            case "cylinder":
                content = node.fields(("kind", "radius_m", "length_m", "axis"))
                return Cylinder(content["radius_m"].number(), content["length_m"].number(), content["axis"].text())
            case "sphere":
                return Sphere(node.fields(("kind", "radius_m"))["radius_m"].number())
            case "mesh":
                return _parse_mesh(node)
    raise kind.defect(f"{kind.value!r} is none of box, cylinder, sphere, mesh")


def _parse_mesh(node: Node) -> Mesh:
    content = node.fields(_MESH_KEYS)
    pieces_m = tuple(np.array(piece.rows()) for piece in content["pieces_m"].items())
    return Mesh(
        vertices_m=np.array(content["vertices_m"].rows()),
        triangles=np.array(content["triangles"].integer_rows()),
        pieces_m=pieces_m,
        pieces_by=content["pieces_by"].text(),
        T_part_file=np.array(content["T_part_file"].rows()),
    )


def _parse_tags(node: Node, part_id: str) -> TagLayout:
    tags = [item.fields(("epc", "point_m", "dipole", "role")) for item in node.items()]
    with node.naming():
        return TagLayout(
            body=part_id,
            epcs=tuple(tag["epc"].text() for tag in tags),
            frames=(PART_FRAME,) * len(tags),
            points_m=_vectors([tag["point_m"] for tag in tags]),
            dipoles=_vectors([tag["dipole"] for tag in tags]),
            roles=tuple(tag["role"].text() for tag in tags),
        )


def _vectors(nodes: list[Node]) -> np.ndarray[Any, np.dtype[np.float64]]:
    vectors = [node.numbers() for node in nodes]
    for node, vector in zip(nodes, vectors, strict=True):
        if len(vector) != 3:
            raise node.defect(f"has {len(vector)} numbers, not 3")
    return np.array(vectors).reshape(-1, 3)


def _parse_selection(node: Node) -> TagSelection:
    content = node.fields(("spacing", "epcs"), ("counterparts",))
    counterparts = content.get("counterparts", Node({}, node.file)).entries()
    with node.naming():
        return TagSelection(
            epcs=tuple(item.text() for item in content["epcs"].items()),
            spacing=content["spacing"].text(),
            counterparts={role: epc.text() for role, epc in counterparts.items()},
        )


def _parse_stable_pose(node: Node) -> StablePose:
    content = node.fields(("probability", "T_support_part"))
    with node.naming():
        return StablePose(np.array(content["T_support_part"].rows()), content["probability"].number())


def assembly_content(assembly: Assembly) -> Content:
    """Return an assembly as JSON values."""
    return {"name": assembly.name, "parts": list(assembly.part_ids)}


def parse_assembly(node: Node) -> Assembly:
    """Read an assembly.

    Raises:
        InputError: If the value breaks the schema; carries `file` and `key`.
    """
    content = node.fields(("name", "parts"))
    with node.naming():
        return Assembly(content["name"].text(), tuple(item.text() for item in content["parts"].items()))
