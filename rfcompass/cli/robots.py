"""`rfcompass robots list | check | tag | serve`."""

from pathlib import Path
from typing import Annotated

import typer

from rfcompass.cli.output import EXIT_BAD_INPUT, JsonFlag, answering, messages, print_json, print_table
from rfcompass.cli.serve import serve

robots_app = typer.Typer(
    help="Robots as data: list them, check a URDF, put tags on one, serve a simulated one.", no_args_is_help=True
)
robots_app.command("serve")(serve)


@robots_app.command("list")
def list_robots(as_json: JsonFlag = False) -> None:
    """List the robots that are known by name."""
    from rfcompass.robots import described_robots, known_layouts, known_robots

    with answering(as_json):
        described, layouts = described_robots(), known_layouts()
        if as_json:
            print_json({"robots": known_robots(), "with_tags_and_tool": described, "layouts": layouts})
            return
        rows = ((name, "yes" if name in described else "") for name in known_robots())
        print_table("Robots", ("name", "tags and tool"), rows)
        typer.echo(f"layouts: {', '.join(layouts)}")


@robots_app.command("check")
def check(
    urdf: Annotated[Path, typer.Argument(help="URDF file; or a robot by name.")],
    package_dir: Annotated[list[Path] | None, typer.Option(help="Where package:// paths lead; repeat.")] = None,
    frame: Annotated[list[str] | None, typer.Option(help="Link that must exist; may be repeated.")] = None,
    as_json: JsonFlag = False,
) -> None:
    """Name everything that is wrong with a URDF. Exit code 2 if the robot cannot be used."""
    from rfcompass.robots import check_urdf

    with answering(as_json):
        file, named = _urdf_of(urdf)
        report = check_urdf(file, package_dir or (), (*named, *(frame or ())))
        found = [(defect.severity, defect.kind, defect.where, defect.message) for defect in report.defects]
        if as_json:
            keys = ("severity", "kind", "where", "message")
            answer = {"file": report.file, "name": report.name, "ok": report.ok, "moving": report.moving}
            print_json({**answer, "defects": [dict(zip(keys, row, strict=True)) for row in found]})
        elif found:
            print_table(f"{report.file}", ("severity", "kind", "where", "what"), found)
        summary = f"{len(report.links)} links, {len(report.moving)} moving joints, {len(report.errors)} errors"
        messages().print(f"{report.name or report.file}: {summary}", markup=False)
        if not report.ok:
            raise typer.Exit(EXIT_BAD_INPUT)


def _urdf_of(given: Path) -> tuple[Path, tuple[str, ...]]:
    """A URDF, given as a file or by the name of a robot; and the links that the robot's description names."""
    from rfcompass.robots import describe_robot, known_robots

    if given.exists() or str(given) not in known_robots():
        return given, ()
    robot = describe_robot(str(given))
    tool = () if robot.tool is None else (robot.tool.frame,)
    return robot.urdf, tuple(name for name in (robot.base_frame, *tool, *robot.layout.frames) if name)


@robots_app.command("tag")
def tag(
    urdf: Annotated[Path, typer.Argument(help="URDF file.")],
    layout: Annotated[str, typer.Argument(help="Tag layout: a name or a JSON file.")],
    out: Annotated[Path, typer.Option(help="Tagged URDF to write.")],
    as_json: JsonFlag = False,
) -> None:
    """Write a URDF in which every tag of a layout is a link."""
    from rfcompass.robots import load_layout, tag_urdf
    from rfcompass.robots.layouts import find_layout

    with answering(as_json):
        mounted = load_layout(find_layout(layout))
        written = tag_urdf(urdf, mounted, out)
        messages().print(f"{written}: {len(mounted.epcs)} tags", markup=False)
        if as_json:
            print_json({"urdf": str(written), "tags": len(mounted.epcs)})
