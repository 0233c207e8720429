"""`rfcompass rate IMAGE`: where a hand with two fingers can close in a depth image, and how likely it holds."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from rfcompass.cli.output import JsonFlag, answering, messages, print_json, print_table

if TYPE_CHECKING:
    from planners.best_grasps import ImageGrasp
    from rfcompass.arrays import FloatArray
    from rfcompass.types import DepthView, GraspMaps


_GROUND = 0.1  # ours: so much of what is seen, the lowest, may be the table


def rate_command(
    image: Annotated[
        Path, typer.Argument(help="File .npz with depth_m or depth_mm, intrinsics, T_world_camera; colour if you like.")
    ],
    best: Annotated[int, typer.Option(min=1, help="How many grasps to tell, 3 cm apart and more.")] = 5,
    table: Annotated[float, typer.Option(help="Height of the table in the world [m], to 8 mm.")] = 0.0,
    picture: Annotated[Path | None, typer.Option(help="Draw them into this file, .png, .svg or .pdf.")] = None,
    maps: Annotated[Path | None, typer.Option(help="Write quality, angle, width, depth of each pixel, .npz.")] = None,
    overwrite: Annotated[bool, typer.Option("--overwrite", help="Replace these files.")] = False,
    as_json: JsonFlag = False,
) -> None:
    """Rate the grasps of a depth image, from straight above; tell the best ones."""
    import numpy as np

    from planners import AntipodalQuality
    from planners.best_grasps import best_grasps
    from rfcompass.cli.depth_file import read_view
    from rfcompass.errors import NothingToGrasp

    with answering(as_json):
        for file, endings in ((picture, (".png", ".svg", ".pdf")), (maps, (".npz",))):
            _check_place(file, endings, image, overwrite=overwrite)
        view, quality = read_view(image), AntipodalQuality(table_m=table)
        rated = quality.quality(view)
        grasps = best_grasps(view, rated, best)
        heights_m = _heights_m(view, table)
        if heights_m.size and (ground_m := float(np.quantile(heights_m, _GROUND))) > quality.standing_m:
            messages().print(
                f"a tenth of what is seen is lower than {1000 * ground_m:.0f} mm over the table; if that is the table "
                "itself, its grasps are none: see --table",
                markup=False,
            )
        _write(view, rated, grasps, picture, maps)
        if not grasps:
            seen = f"{1000 * heights_m.min():.0f} to {1000 * heights_m.max():.0f} mm" if heights_m.size else "nothing"
            message = f"{image}: no pixel shows a grasp; over the table at {table:g} m it shows {seen}"
            raise NothingToGrasp(message, file=str(image), table_m=table, pixels=heights_m.size)
        if as_json:
            print_json({"grasps": [_json(grasp) for grasp in grasps]})
            return
        columns = ("chance", "row", "column", "x [m]", "y [m]", "z [m]", "jaws along [°]", "open [mm]")
        print_table(f"best grasps of {image}; pose of the tool", columns, map(_row, grasps))


def _heights_m(view: "DepthView", table_m: float) -> "FloatArray":
    """Heights of all that is seen over the table [m]."""
    import numpy as np

    from rfcompass.mapping.camera import points_image

    heights_m = points_image(view)[..., 2] - table_m
    return heights_m[np.isfinite(heights_m)]


def _check_place(file: Path | None, endings: tuple[str, ...], image: Path, *, overwrite: bool) -> None:
    from rfcompass.errors import InputError
    from rfcompass.recordings.result_folder import check_above

    if file is None:
        return
    if file.suffix not in endings:
        raise InputError(f"{file}: should end with {' or '.join(endings)}", file=str(file))
    check_above(file)
    if file.resolve() == image.resolve():
        raise InputError(f"{file}: is the image itself", file=str(file))
    if file.is_dir() or (file.exists() and not overwrite):
        raise InputError(f"{file} is there already; --overwrite replaces a file", file=str(file))


def _write(
    view: "DepthView", rated: "GraspMaps", grasps: "tuple[ImageGrasp, ...]", picture: Path | None, maps: Path | None
) -> None:
    """Write what was asked for; the picture is drawn before anything is written."""
    import numpy as np

    from rfcompass.files import write_atomic

    figure = None
    if picture is not None:
        from rfcompass.viz.grasp_maps import draw_grasp_maps

        figure = draw_grasp_maps(view, rated, [(grasp.row, grasp.column) for grasp in grasps])
    if maps is not None:
        images = {name: getattr(rated, name) for name in ("quality", "angle_rad", "width_m", "depth_m")}

        def store(draft: Path) -> None:
            with draft.open("wb") as file:  # a name that does not end with .npz would get that
                np.savez_compressed(file, **images)

        maps.parent.mkdir(parents=True, exist_ok=True)
        write_atomic(maps, store)
        messages().print(f"maps: {maps}", markup=False)
    if picture is not None and figure is not None:
        picture.parent.mkdir(parents=True, exist_ok=True)
        write_atomic(picture, lambda draft: figure.savefig(draft, dpi=110, format=picture.suffix[1:]))
        messages().print(f"picture: {picture}", markup=False)


def _json(grasp: "ImageGrasp") -> dict[str, Any]:
    return {
        "quality": grasp.quality,
        "row": grasp.row,
        "column": grasp.column,
        "T_world_hand": grasp.T_world_hand,
        "aperture_m": grasp.aperture_m,
    }


def _row(grasp: "ImageGrasp") -> tuple[str, ...]:
    import numpy as np

    T = grasp.T_world_hand
    along_deg = np.rad2deg(np.arctan2(T[1, 1], T[0, 1])) % 180
    place = (f"{value:.3f}" for value in T[:3, 3])
    numbers = (f"{along_deg:.0f}", f"{1000 * grasp.aperture_m:.0f}")
    return (f"{grasp.quality:.2f}", str(grasp.row), str(grasp.column), *place, *numbers)
