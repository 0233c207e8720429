"""A part from a mesh file: size, mass, inertia, convex pieces and stable poses, computed with trimesh."""

import logging
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from rfcompass.arrays import FloatArray
from rfcompass.errors import PartError
from rfcompass.types.parts import Part, StablePose, no_tags
from rfcompass.types.shapes import Mesh, positive

if TYPE_CHECKING:
    import trimesh

_log = logging.getLogger(__name__)

UNITS_M = {"m": 1.0, "cm": 0.01, "mm": 0.001, "inch": 0.0254}
SUFFIXES = (".stl", ".obj", ".ply", ".off")

# All ours.
LONGEST_M = 5.0  # nothing longer is picked up; a file in millimetres read as metres is
FLATTEST = 1e-6  # thickness over length below which there is no solid
LIKELY = 0.99  # share of the best pose's probability from which poses count as equally likely
MAX_POSES = 24  # a ball has as many stable poses as facets
HULL_CORNERS = 1000  # corners of the hull whose stable poses are looked for; 2 s
VHACD = {"maxConvexHulls": 16, "resolution": 50_000, "maxRecursionDepth": 6}  # 2 s for a torus


def part_from_mesh(
    path: Path | str,
    part_id: str,
    *,
    density_kg_m3: float,
    unit: str = "m",
    allow_open: bool = False,
    material: str = "not stated",
    rigid: bool = True,
) -> Part:
    """Compute a part from a mesh file. It has no tags yet; `Mesh.from_file_m` moves places from a drawing.

    The part frame: of all stable poses that are equally likely, and of all quarter turns that put the longer
    side of the footprint along x, it is the one that turns the file's axes least. Jaws close across that side,
    so the grasp width is the extent along y; `dataclasses.replace` states another one.

    Deviations: the pieces of a shape that is not convex approximate it (V-HACD), or are its hull where the
    decomposition is not installed; `Mesh.pieces_by` says so. Stable poses are those of the hull, of which at most
    1000 corners are kept, and are computed for a slow fall without bouncing.

    Args:
        path: STL, OBJ, PLY or OFF file.
        part_id: Name of the part.
        density_kg_m3: Mass over volume [kg/m³].
        unit: Unit of the file: `m`, `cm`, `mm` or `inch`.
        allow_open: Take the hull as the solid if the surface has holes.
        material: In words.
        rigid: False for an item that yields under load.

    Raises:
        PartError: If the file cannot be read, is flat, is longer than 5 m (wrong unit?), or has holes, or if its
            bodies overlap so far that they would hold more than their hull.
    """
    file = Path(path)
    surface = _load(file, _unit_m(unit))
    solid = _solid(surface, file, allow_open=allow_open)
    poses = _stable_poses(solid)
    T_part_file = _part_frame(solid, poses)
    solid.density = positive(density_kg_m3, "density_kg_m3")
    inertia = T_part_file[:3, :3] @ solid.moment_inertia @ T_part_file[:3, :3].T
    shape = _shape(surface, solid, T_part_file)
    return Part(
        part_id=part_id,
        shape=shape,
        mass_kg=float(solid.mass),
        inertia_kg_m2=(inertia + inertia.T) / 2,
        grasp_width_m=float(shape.upper_m[1] - shape.lower_m[1]),
        tags=no_tags(part_id),
        material=material,
        rigid=rigid,
        stable_poses=tuple(_in_part_frame(pose, T_part_file) for pose in poses[:MAX_POSES]),
    )


def _unit_m(unit: str) -> float:
    if unit not in UNITS_M:
        raise PartError(f"unit {unit!r} is none of {', '.join(UNITS_M)}", unit=unit)
    return UNITS_M[unit]


def _load(file: Path, unit_m: float) -> "trimesh.Trimesh":
    import trimesh  # noqa: PLC0415 - heavy, and most uses of the database read no mesh

    if file.suffix.lower() not in SUFFIXES:
        raise PartError(f"{file.name}: no mesh format we read ({', '.join(SUFFIXES)})", file=file.name)
    try:
        mesh = trimesh.load_mesh(file)
    except Exception as cause:  # a damaged file raises anything between struct.error and UnicodeDecodeError
        raise PartError(f"{file.name}: cannot be read as a mesh: {cause}", file=file.name) from cause
    if not isinstance(mesh, trimesh.Trimesh) or not len(mesh.faces):
        raise PartError(f"{file.name}: holds no triangles", file=file.name)
    if not np.isfinite(mesh.vertices).all():
        raise PartError(f"{file.name}: some corners are not finite", file=file.name)
    mesh.apply_scale(unit_m)  # type: ignore[no-untyped-call]
    _check_size(mesh, file)
    return mesh


def _check_size(mesh: "trimesh.Trimesh", file: Path) -> None:
    longest_m = float(mesh.extents.max())
    if longest_m > LONGEST_M:
        message = f"{file.name}: {longest_m:.4g} m long, more than {LONGEST_M:g} m; is the file in mm?"
        raise PartError(message, file=file.name, longest_m=longest_m)
    spread = np.linalg.svd(mesh.vertices - mesh.vertices.mean(axis=0), compute_uv=False)
    if spread[2] <= FLATTEST * spread[0]:
        raise PartError(f"{file.name}: is flat, there is no solid inside", file=file.name)


def _solid(surface: "trimesh.Trimesh", file: Path, *, allow_open: bool) -> "trimesh.Trimesh":
    if surface.is_watertight and not surface.is_volume:
        surface.fix_normals()
    if surface.is_volume:
        hull_m3 = float(surface.convex_hull.volume)
        if surface.volume > hull_m3 * (1 + 1e-6):
            message = f"{file.name}: holds {surface.volume:.4g} m³ in a hull of {hull_m3:.4g} m³; its bodies overlap"
            raise PartError(message, file=file.name, volume_m3=float(surface.volume), hull_m3=hull_m3)
        return surface.copy()
    if not allow_open:
        message = f"{file.name}: the surface is not closed, so it has no volume; allow_open takes its hull instead"
        raise PartError(message, file=file.name, watertight=bool(surface.is_watertight))
    return surface.convex_hull


def _stable_poses(solid: "trimesh.Trimesh") -> list[StablePose]:
    from trimesh.poses import compute_stable_poses  # noqa: PLC0415

    transforms, probabilities = compute_stable_poses(_coarse_hull(solid), center_mass=solid.center_mass)
    if not len(transforms):
        raise PartError("the shape has no stable pose")
    order = np.argsort(-probabilities, kind="stable")
    # The centre of mass stands over the origin; the probabilities sum to one but for rounding.
    return [StablePose(_over_origin(transforms[i], solid), min(float(probabilities[i]), 1.0)) for i in order]


def _over_origin(T_support_file: FloatArray, solid: "trimesh.Trimesh") -> FloatArray:
    T = np.array(T_support_file)
    T[:2, 3] = -T[:2, :3] @ solid.center_mass
    T[2, 3] = -(solid.vertices @ T[2, :3]).min()
    return T


def _coarse_hull(solid: "trimesh.Trimesh") -> "trimesh.Trimesh":
    import trimesh  # noqa: PLC0415

    hull = solid.convex_hull
    if len(hull.vertices) <= HULL_CORNERS:
        return hull
    reached = np.unique((_directions(HULL_CORNERS) @ hull.vertices.T).argmax(axis=1))
    return trimesh.convex.convex_hull(hull.vertices[reached])


def _directions(count: int) -> FloatArray:
    """Unit vectors spread over the sphere on a golden spiral, shape (count, 3)."""
    step = np.arange(count) + 0.5
    height, turn = 1 - 2 * step / count, np.pi * (1 + np.sqrt(5)) * step
    radius = np.sqrt(1 - height**2)
    return np.column_stack([radius * np.cos(turn), radius * np.sin(turn), height])


def _part_frame(solid: "trimesh.Trimesh", poses: list[StablePose]) -> FloatArray:
    likely = [pose for pose in poses if pose.probability >= LIKELY * poses[0].probability]
    frames = [R for pose in likely for R in _lengthwise(pose.T_support_part[:3, :3], solid)]
    R_part_file = max(frames, key=np.trace)
    T_part_file = np.eye(4)
    T_part_file[:3, :3] = R_part_file
    T_part_file[:3, 3] = -R_part_file @ solid.center_mass
    return T_part_file


def _lengthwise(R_support_file: FloatArray, solid: "trimesh.Trimesh") -> Iterator[FloatArray]:
    """Turn about the vertical until the narrowest footprint lies along x; yields each turn that does."""
    from trimesh.bounds import oriented_bounds_2D  # noqa: PLC0415

    corners = solid.convex_hull.vertices @ R_support_file.T
    T_box_support, _ = oriented_bounds_2D(corners[:, :2])  # type: ignore[no-untyped-call]
    aligned = np.eye(3)
    aligned[:2, :2] = T_box_support[:2, :2]
    quarter = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    for _ in range(4):
        aligned = quarter @ aligned
        size_x, size_y, _ = np.ptp(corners @ aligned.T, axis=0)
        if size_x >= size_y * (1 - 1e-6):
            yield aligned @ R_support_file


def _shape(surface: "trimesh.Trimesh", solid: "trimesh.Trimesh", T_part_file: FloatArray) -> Mesh:
    R, t = T_part_file[:3, :3], T_part_file[:3, 3]
    pieces, pieces_by = _convex_pieces(surface, solid)
    return Mesh(
        vertices_m=surface.vertices @ R.T + t,
        triangles=np.asarray(surface.faces, dtype=np.int64),
        pieces_m=tuple(piece @ R.T + t for piece in pieces),
        pieces_by=pieces_by,
        T_part_file=T_part_file,
    )


def _convex_pieces(surface: "trimesh.Trimesh", solid: "trimesh.Trimesh") -> tuple[list[FloatArray], str]:
    hull = np.asarray(solid.convex_hull.vertices)
    if surface.is_volume and surface.is_convex:
        return [hull], "convex"
    if not surface.is_volume:
        return [hull], "hull"
    try:
        return [np.asarray(piece.vertices) for piece in solid.convex_decomposition(**VHACD)], "vhacd"
    except ImportError:
        _log.warning("vhacdx is not installed: the convex hull stands for a shape that is not convex")
        return [hull], "hull"


def _in_part_frame(pose: StablePose, T_part_file: FloatArray) -> StablePose:
    T_support_part = pose.T_support_part @ np.linalg.inv(T_part_file)
    T_support_part[3] = (0, 0, 0, 1)
    return StablePose(T_support_part, pose.probability)
