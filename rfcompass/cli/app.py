"""The application: collects the commands, each of which imports what it needs when it runs."""

import logging
from typing import Annotated

import typer
from rich.logging import RichHandler

from rfcompass.cli.bench import bench
from rfcompass.cli.calibrate import calibrate
from rfcompass.cli.fetch import fetch
from rfcompass.cli.grasp import grasp_command
from rfcompass.cli.importing import import_recording
from rfcompass.cli.layout import layout_command
from rfcompass.cli.locate import locate
from rfcompass.cli.output import messages
from rfcompass.cli.partition import partition
from rfcompass.cli.parts import parts_app
from rfcompass.cli.proximity import proximity
from rfcompass.cli.rate import rate_command
from rfcompass.cli.reach import reach_command
from rfcompass.cli.record import record_command
from rfcompass.cli.robots import robots_app
from rfcompass.cli.search import search_command
from rfcompass.cli.study import study_app
from rfcompass.cli.survey import survey_command
from rfcompass.cli.view import view

app = typer.Typer(
    name="rfcompass",
    help="Find tags, and parts that carry them, with a robot that carries tags itself.",
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    add_completion=False,
    rich_markup_mode=None,  # brackets in a help text are brackets
)
app.command("fetch")(fetch)
app.command("search")(search_command)
app.command("locate")(locate)
app.command("grasp")(grasp_command)
app.command("rate")(rate_command)
app.command("survey")(survey_command)
app.command("calibrate")(calibrate)
app.command("proximity")(proximity)
app.command("partition")(partition)
app.command("record")(record_command)
app.command("import")(import_recording)
app.command("layout")(layout_command)
app.command("reach")(reach_command)
app.add_typer(parts_app, name="parts")
app.add_typer(robots_app, name="robots")
app.add_typer(study_app, name="study")
app.command("view")(view)
app.command("bench")(bench)


def _show_versions(wanted: bool) -> None:
    if wanted:
        from rfcompass.studies.versions import software_versions

        typer.echo(software_versions())
        raise typer.Exit


@app.callback()
def _options(
    verbose: Annotated[bool, typer.Option("--verbose", "-v", help="Show log messages.")] = False,
    version: Annotated[  # noqa: ARG001
        bool,
        typer.Option("--version", callback=_show_versions, is_eager=True, help="Show what is installed, and end."),
    ] = False,
) -> None:
    level = logging.INFO if verbose else logging.WARNING
    logging.basicConfig(level=level, format="%(message)s", handlers=[RichHandler(console=messages(), show_path=False)])


def main() -> None:
    """Entry point of the `rfcompass` program."""
    app()
