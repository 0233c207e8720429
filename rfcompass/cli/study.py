"""`rfcompass study list | run | report`."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn

from rfcompass.cli.output import JsonFlag, answering, messages, print_json, print_table

if TYPE_CHECKING:
    from rfcompass.studies.runner import Progress as StudyProgress
    from rfcompass.studies.summary import SummaryRow

study_app = typer.Typer(help="Seeded, resumable studies: the figures and tables that we report.", no_args_is_help=True)


@study_app.command("list")
def list_studies(as_json: JsonFlag = False) -> None:
    """List the studies."""
    from rfcompass.studies.registry import all_studies

    with answering(as_json):
        studies = all_studies().values()
        if as_json:
            print_json({"studies": [{"name": s.name, "title": s.title, "kind": s.kind} for s in studies]})
        else:
            print_table("Studies", ("name", "reads", "title"), ((s.name, s.kind, s.title) for s in studies))


@study_app.command("run")
def run(
    name: Annotated[str, typer.Argument(help="Name of the study; see `rfcompass study list`.")],
    out: Annotated[Path | None, typer.Option(help="Folder for the rows; by default runs/NAME.")] = None,
    trials: Annotated[int | None, typer.Option(min=1, help="Seeds in each cell; all by default.")] = None,
    workers: Annotated[int, typer.Option(min=1, help="Workers on this machine; a cluster has its own.")] = 1,
    backend: Annotated[
        str, typer.Option(help="loky (processes of this machine), dask or ray (extras), threading or sequential.")
    ] = "loky",
    scheduler: Annotated[
        str | None,
        typer.Option(help="Address of a dask or ray cluster, as tcp://HOST:8786; by default one is started here."),
    ] = None,
    trial_seconds: Annotated[
        float | None, typer.Option(help="A trial that takes longer is ended: a row with failure timed_out.")
    ] = None,
    trial_megabytes: Annotated[
        float | None,
        typer.Option(help="A trial that takes more memory is ended: a row with failure out_of_memory."),
    ] = None,
    resume: Annotated[bool, typer.Option(help="Go on with the rows that are there.")] = False,
    as_json: JsonFlag = False,
) -> None:
    """Run a study, write its rows and its report, and print the table.

    The rows are the same on every backend and for any number of workers.
    """
    from rfcompass.studies.limits import TrialLimits
    from rfcompass.studies.registry import study
    from rfcompass.studies.runner import run_study

    with answering(as_json):
        chosen, folder = study(name), out or Path("runs") / name
        with _progress_bar() as bar:
            task = bar.add_task(name, total=None, left="")

            def show(progress: "StudyProgress") -> None:
                left = "" if progress.left_s is None else f"{progress.left_s:.0f} s left"
                bar.update(task, total=progress.total, completed=progress.done, left=left)

            run_study(
                chosen,
                folder,
                trials=trials,
                workers=workers,
                backend=backend,
                scheduler=scheduler,
                limits=TrialLimits(seconds=trial_seconds, megabytes=trial_megabytes),
                resume=resume,
                progress=show,
            )
        _report(folder, as_json)


@study_app.command("report")
def report(run_folder: Annotated[Path, typer.Argument(help="Folder of a run.")], as_json: JsonFlag = False) -> None:
    """Write the report of a run (HTML and Markdown) and print its table."""
    with answering(as_json):
        _report(run_folder, as_json)


def _report(folder: Path, as_json: bool) -> None:
    from rfcompass.studies.folder import read_manifest
    from rfcompass.studies.registry import study
    from rfcompass.studies.report import markdown_table, write_report

    chosen = study(str(read_manifest(folder)["name"]))
    rows = write_report(chosen, folder)
    messages().print(f"report: {folder / 'report.html'} and {folder / 'report.md'}", markup=False)
    if as_json:
        print_json({"study": chosen.name, "rows": [_row(row) for row in rows]})
    else:
        typer.echo(markdown_table(chosen, rows))


def _row(row: "SummaryRow") -> dict[str, object]:
    return {
        "cell": row.cell,
        "metric": row.metric,
        "summary": row.summary,
        "n": row.n,
        "failures": row.failures,
        "value": row.value,
        "interval": None if row.interval is None else [row.interval.low, row.interval.high],
        "paper": None if row.paper is None else row.paper.value,
    }


def _progress_bar() -> Progress:
    return Progress(
        TextColumn("{task.description}"),
        BarColumn(),
        MofNCompleteColumn(),
        TimeElapsedColumn(),
        TextColumn("{task.fields[left]}"),
        console=messages(),
    )
