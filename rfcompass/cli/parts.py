"""`rfcompass parts list | show | add | remove | import | export`."""

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import numpy as np
import typer

from rfcompass.cli.output import JsonFlag, answering, messages, print_json, print_table

if TYPE_CHECKING:
    from rfcompass.types.parts import Part

parts_app = typer.Typer(help="The part database: which tags are on which part, and where on it.", no_args_is_help=True)
PartName = Annotated[str, typer.Argument(help="Name of the part, for example table_leg_3.")]
Database = Annotated[Path | None, typer.Option(help="Database file; by default the user's own, or $RFCOMPASS_PARTS.")]
Replace = Annotated[bool, typer.Option(help="Put it in the place of what has the same name.")]


@parts_app.command("list")
def list_parts(database: Database = None, as_json: JsonFlag = False) -> None:
    """List all parts and products."""
    from rfcompass.recordings import PartDatabase

    with answering(as_json), PartDatabase(database) as parts:
        assemblies = {assembly.name: assembly.part_ids for assembly in parts.assemblies()}
        if as_json:
            print_json({"parts": parts.part_ids(), "assemblies": assemblies})
            return
        rows = (
            (part.part_id, " x ".join(f"{100 * side:.1f}" for side in part.size_m), f"{1000 * part.mass_kg:.0f}",
             len(part.tags.epcs), part.material)
            for part in parts.parts()
        )  # fmt: skip
        print_table(f"Parts in {parts.location}", ("name", "size [cm]", "mass [g]", "tags", "material"), rows)
        for name, part_ids in assemblies.items():
            typer.echo(f"{name}: {', '.join(part_ids)}")


@parts_app.command("show")
def show_part(part: PartName, database: Database = None, as_json: JsonFlag = False) -> None:
    """Show one part with its tags."""
    from rfcompass.recordings import PartDatabase

    with answering(as_json), PartDatabase(database) as parts:
        found = parts.part(part)
        if as_json:
            print_json(_content(found))
            return
        typer.echo(
            f"{found.part_id}: {found.material}, {found.mass_kg:.3f} kg, {'rigid' if found.rigid else 'deformable'}, "
            f"shortest side {100 * found.shortest_m:.1f} cm, longest {100 * found.longest_m:.1f} cm, "
            f"jaws close on {100 * found.grasp_width_m:.1f} cm"
        )
        tags = found.tags
        rows = (
            (epc, *(f"{value:.4f}" for value in point), tags.roles[k], _used_in(found, epc))
            for k, (epc, point) in enumerate(zip(tags.epcs, tags.points_m, strict=True))
        )
        print_table("Tags, part frame", ("EPC", "x [m]", "y [m]", "z [m]", "role", "layouts"), rows)


@parts_app.command("add")
def add_part(
    part: PartName,
    mesh: Annotated[Path | None, typer.Option(help="Mesh file: STL, OBJ, PLY or OFF.")] = None,
    box: Annotated[tuple[float, float, float] | None, typer.Option(help="Edges of a box [m].")] = None,
    unit: Annotated[str, typer.Option(help="Unit of the mesh file: m, cm, mm or inch.")] = "m",
    density: Annotated[float, typer.Option(help="Mass over volume [kg/m3].")] = 600.0,
    material: Annotated[str, typer.Option(help="In words.")] = "not stated",
    deformable: Annotated[bool, typer.Option(help="The item yields under load.")] = False,
    tag: Annotated[list[str] | None, typer.Option(help="Tag as EPC,x,y,z in the part frame [m]; repeat.")] = None,
    allow_open: Annotated[bool, typer.Option(help="Take the hull of a mesh with holes.")] = False,
    overwrite: Replace = False,
    database: Database = None,
    as_json: JsonFlag = False,
) -> None:
    """Add a part from a mesh, or from the edges of a box; mass, inertia and the rest are computed."""
    from rfcompass.errors import PartError
    from rfcompass.recordings import PartDatabase, part_from_mesh

    with answering(as_json):
        if (mesh is None) == (box is None):
            raise PartError(f"part {part}: give either --mesh or --box", part=part)
        if mesh is not None:
            made = part_from_mesh(
                mesh, part, density_kg_m3=density, unit=unit, allow_open=allow_open, material=material,
                rigid=not deformable,
            )  # fmt: skip
        else:
            made = _box_part(part, np.array(box), density, material, not deformable)
        made = _with_tags(made, tag or [])
        with PartDatabase(database) as parts:
            parts.add(made, replace=overwrite)
            messages().print(f"{part}: added to {parts.location}", markup=False)
        if as_json:
            print_json(_content(made))


@parts_app.command("remove")
def remove_part(part: PartName, database: Database = None, as_json: JsonFlag = False) -> None:
    """Remove a part."""
    from rfcompass.recordings import PartDatabase

    with answering(as_json), PartDatabase(database) as parts:
        parts.remove(part)
        if as_json:
            print_json({"removed": part})


@parts_app.command("import")
def import_parts(
    file: Annotated[Path, typer.Argument(help="JSON file of parts.")],
    overwrite: Replace = False,
    database: Database = None,
    as_json: JsonFlag = False,
) -> None:
    """Add everything that a JSON file of parts holds, or nothing."""
    from rfcompass.recordings import PartDatabase

    with answering(as_json), PartDatabase(database) as parts:
        added = parts.import_file(file, replace=overwrite)
        if as_json:
            print_json({"parts": [part.part_id for part in added.parts]})


@parts_app.command("export")
def export_parts(
    file: Annotated[Path, typer.Argument(help="JSON file to write.")],
    database: Database = None,
    as_json: JsonFlag = False,
) -> None:
    """Write the whole database into a JSON file."""
    from rfcompass.recordings import PartDatabase

    with answering(as_json), PartDatabase(database) as parts:
        parts.export_file(file)
        if as_json:
            print_json({"file": str(file), "parts": parts.part_ids()})


def _content(part: "Part") -> dict[str, object]:
    return {
        "part": part.part_id,
        "size_m": part.size_m,
        "shortest_m": part.shortest_m,
        "longest_m": part.longest_m,
        "mass_kg": part.mass_kg,
        "inertia_kg_m2": part.inertia_kg_m2,
        "grasp_width_m": part.grasp_width_m,
        "material": part.material,
        "rigid": part.rigid,
        "tags": [
            {"epc": epc, "point_m": part.tags.points_m[k], "dipole": part.tags.dipoles[k], "role": part.tags.roles[k]}
            for k, epc in enumerate(part.tags.epcs)
        ],
        "layouts": [{"K": chosen.K, "spacing": chosen.spacing, "epcs": chosen.epcs} for chosen in part.selections],
        "stable_poses": [
            {"T_support_part": pose.T_support_part, "probability": pose.probability} for pose in part.stable_poses
        ],
    }


def _used_in(part: "Part", epc: str) -> str:
    return ", ".join(f"K={chosen.K} {chosen.spacing}" for chosen in part.selections if epc in chosen.epcs)


def _box_part(part_id: str, size_m: np.ndarray, density: float, material: str, rigid: bool) -> "Part":
    from rfcompass.types.parts import Part, no_tags
    from rfcompass.types.shapes import Box

    shape = Box(size_m)
    mass_kg = density * shape.volume_m3
    width_m = float(size_m[:2].min())
    inertia = mass_kg * shape.inertia_per_mass_m2
    return Part(part_id, shape, mass_kg, inertia, width_m, no_tags(part_id), material=material, rigid=rigid)


def _with_tags(part: "Part", tags: list[str]) -> "Part":
    """Mount tags given as `EPC,x,y,z`; all of them together are the part's one layout."""
    from rfcompass.errors import PartError
    from rfcompass.types.epc import canonical_epc
    from rfcompass.types.parts import TagSelection
    from rfcompass.types.tags import TagLayout

    if not tags:
        return part
    try:
        fields = [(canonical_epc(epc), [float(x), float(y), float(z)]) for epc, x, y, z in (t.split(",") for t in tags)]
    except ValueError as cause:
        raise PartError(f"a tag is EPC,x,y,z in metres, got {', '.join(tags)}: {cause}", tags=tags) from cause
    epcs = tuple(epc for epc, _ in fields)
    points_m, vertical = np.array([point for _, point in fields]), np.tile([0.0, 0.0, 1.0], (len(epcs), 1))
    roles = ("part",) * len(epcs)
    layout = TagLayout(part.part_id, epcs, ("part",) * len(epcs), points_m, vertical, roles)
    return replace(part, tags=layout, selections=(TagSelection(epcs),))
