"""The report of a study: ours, the interval, a reference and what differs, as Markdown and as one HTML page."""

import base64
import html
import io
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from rfcompass.evaluation.records import CellValue
from rfcompass.files import write_text_atomic
from rfcompass.studies.folder import read_rows
from rfcompass.studies.study import Study
from rfcompass.studies.summary import RunFacts, SummaryRow, run_facts, summarise

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_STYLE = """
body { font: 15px/1.5 system-ui, sans-serif; color: #1a1a1a; max-width: 76rem; margin: 2rem auto; padding: 0 1rem; }
h1 { font-size: 1.5rem; margin-bottom: .2rem; }
h2 { font-size: 1.1rem; margin-top: 2rem; }
p { max-width: 50rem; }
.kind { border: 1px solid #888; border-radius: .3rem; font-size: .85rem; padding: .1rem .4rem; }
.table { overflow-x: auto; }
table { border-collapse: collapse; font-variant-numeric: tabular-nums; }
th, td { border-bottom: 1px solid #ddd; padding: .3rem .7rem; text-align: left; vertical-align: top; }
th { border-bottom: 2px solid #888; }
td.number { text-align: right; white-space: nowrap; }
td.ours { font-weight: 600; }
figure { margin: 2rem 0; }
figure img { max-width: 100%; }
figcaption, footer { color: #555; font-size: .85rem; }
@media (prefers-color-scheme: dark) {
  body { background: #16181c; color: #e4e4e4; }
  th, td { border-color: #444; }
  figcaption, footer { color: #aaa; }
  figure img { background: white; }
}
"""

_OUR_COLUMNS = (
    "metric",
    "unit",
    "n",
    "failed",
    "ours",
    "95 % interval",
    "reference",
    "source",
    "what differs",
    "data",
)
_NUMBERS = frozenset({"n", "failed", "ours", "95 % interval", "reference"})


def markdown_table(study: Study, rows: Sequence[SummaryRow]) -> str:
    """Format summary rows as a Markdown table, one line for each."""
    columns = _columns(study)
    lines = [columns, ["---:" if name in _NUMBERS else "---" for name in columns]]
    lines += [[_escape_markdown(text) for text in _texts(study, row)] for row in rows]
    return "".join(f"| {' | '.join(line)} |\n" for line in lines)


def markdown_report(study: Study, rows: Sequence[SummaryRow], facts: RunFacts) -> str:
    """Format a whole report as Markdown: title, table and how it came about."""
    note = f"{study.note}\n\n" if study.note else ""
    return f"# {study.title} ({study.kind})\n\n{note}{markdown_table(study, rows)}\n{_facts(study, facts)}\n"


def html_page(
    study: Study, rows: Sequence[SummaryRow], facts: RunFacts, figures: Mapping[str, bytes] | None = None
) -> str:
    """Format a report as one HTML page that needs no other file.

    Args:
        study: The study.
        rows: Its summary.
        facts: What is known about the run.
        figures: PNG files by caption, shown below the table in this order.
    """
    title, note = html.escape(study.title), html.escape(study.note)
    columns = _columns(study)
    head = "".join(f"<th>{html.escape(name)}</th>" for name in columns)
    body = "\n".join(f"<tr>{_html_cells(columns, _texts(study, row))}</tr>" for row in rows)
    shown = "\n".join(_html_figure(caption, png) for caption, png in (figures or {}).items())
    return (
        f'<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        f'<meta name="viewport" content="width=device-width, initial-scale=1">\n'
        f"<title>{title}</title>\n<style>{_STYLE}</style>\n</head>\n<body>\n"
        f'<h1>{title}</h1>\n<p><span class="kind">{study.kind}</span> {note}</p>\n'
        f'<div class="table"><table>\n<thead><tr>{head}</tr></thead>\n<tbody>\n{body}\n</tbody>\n</table></div>\n'
        f"{shown}\n<footer><p>{html.escape(_facts(study, facts))}</p></footer>\n</body>\n</html>\n"
    )


def write_report(study: Study, out: Path | str) -> tuple[SummaryRow, ...]:
    """Summarise the rows in a study's folder and write `report.md` and `report.html` beside them.

    Args:
        study: The study; what it draws goes into the page.
        out: Folder of its run.

    Raises:
        StudyError: If the folder holds no rows of this study.
    """
    out = Path(out)
    table = read_rows(out, study)
    rows, facts = summarise(study, table), run_facts(table)
    figures = {caption: _png(figure) for caption, figure in (study.draws(table) if study.draws else {}).items()}
    write_text_atomic(out / "report.md", markdown_report(study, rows, facts))
    write_text_atomic(out / "report.html", html_page(study, rows, facts, figures))
    return rows


def _columns(study: Study) -> list[str]:
    return [*study.factors, *_OUR_COLUMNS]


def _texts(study: Study, row: SummaryRow) -> list[str]:
    """Texts of one line, in the order of the columns."""
    metric, paper, interval = study.metric(row.metric), row.paper, row.interval
    return [
        *(_cell_text(value) for value in row.cell.values()),
        f"{metric.title or metric.name}, {_summary_text(row.summary)}",
        metric.unit,
        str(row.n),
        str(row.failures),
        metric.shown(row.value),
        f"{metric.shown(interval.low)} … {metric.shown(interval.high)}" if interval else "–",
        metric.shown(paper.value) if paper else "–",
        paper.source if paper else "",
        paper.differs if paper else "",
        study.kind,
    ]


def _facts(study: Study, facts: RunFacts) -> str:
    failed = ", ".join(f"{count} × {kind}" for kind, count in facts.failures.items()) or "none"
    return (
        f"Study {study.name}: {facts.trials} trials over {facts.seeds} seeds, {facts.runtime_s:.1f} s of computing. "
        f"Failed trials: {failed}; they count as no in a share of trials and have no value elsewhere. "
        f"Computed by {'; '.join(facts.versions)}."
    )


def _summary_text(summary: str) -> str:
    if summary.startswith("max"):
        return f"median of the largest of {summary[3:]}"
    return f"{int(summary[1:])} % quantile" if summary.startswith("p") else summary


def _cell_text(value: CellValue) -> str:
    if value is None:
        return "–"
    return {True: "yes", False: "no"}[value] if isinstance(value, bool) else str(value)


def _escape_markdown(text: str) -> str:
    return html.escape(text, quote=False).replace("\\", "\\\\").replace("|", "\\|").replace("\n", " ")


def _html_cells(columns: Sequence[str], texts: Sequence[str]) -> str:
    return "".join(
        f"<td{_html_class(column)}>{html.escape(text)}</td>" for column, text in zip(columns, texts, strict=True)
    )


def _html_class(column: str) -> str:
    names = ["number"] * (column in _NUMBERS) + ["ours"] * (column == "ours")
    return f' class="{" ".join(names)}"' if names else ""


def _png(figure: "Figure") -> bytes:
    buffer = io.BytesIO()
    figure.savefig(buffer, format="png", dpi=110)
    return buffer.getvalue()


def _html_figure(caption: str, png: bytes) -> str:
    data, text = base64.b64encode(png).decode("ascii"), html.escape(caption)
    return f'<figure><img alt="{text}" src="data:image/png;base64,{data}"><figcaption>{text}</figcaption></figure>'
