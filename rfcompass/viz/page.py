"""One self-contained HTML page: figures as embedded images, tables as HTML, no other file or address."""

import base64
import html
import io
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, TypeAlias

from rfcompass.files import write_text_atomic

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_STYLE = """
body { font: 16px/1.5 system-ui, sans-serif; max-width: 60rem; margin: 2rem auto; padding: 0 1rem; color: #1d2733; }
h1 { font-size: 1.5rem; } h2 { font-size: 1.15rem; margin-top: 2rem; }
img { max-width: 100%; } figcaption { color: #51606f; }
table { border-collapse: collapse; }
th, td { padding: .25rem .75rem; border-bottom: 1px solid #d5dce3; text-align: right; }
th:first-child, td:first-child { text-align: left; font-family: ui-monospace, monospace; }
"""


@dataclass(frozen=True, slots=True)
class PageTable:
    """A table with a heading: column names and rows of cells, already formatted."""

    title: str
    columns: Sequence[str]
    rows: Sequence[Sequence[object]]


@dataclass(frozen=True, slots=True)
class PageFigure:
    """A matplotlib figure with its caption."""

    caption: str
    figure: "Figure"


PagePart: TypeAlias = PageTable | PageFigure | str


def page_html(title: str, parts: Iterable[PagePart]) -> str:
    """Lay out a page: strings become paragraphs, in the order given."""
    body = "\n".join(_part_html(part) for part in parts)
    head = f'<meta charset="utf-8"><title>{html.escape(title)}</title><style>{_STYLE}</style>'
    heading = f"<h1>{html.escape(title)}</h1>"
    return f"<!doctype html>\n<html lang='en'><head>{head}</head>\n<body>\n{heading}\n{body}\n</body></html>\n"


def write_page(path: Path, title: str, parts: Iterable[PagePart]) -> None:
    """Write a page atomically."""
    write_text_atomic(path, page_html(title, parts))


def _part_html(part: PagePart) -> str:
    if isinstance(part, str):
        return f"<p>{html.escape(part)}</p>"
    if isinstance(part, PageTable):
        return f"<h2>{html.escape(part.title)}</h2>\n{_table_html(part)}"
    image = base64.b64encode(_png(part.figure)).decode()
    caption = html.escape(part.caption)
    return (
        f"<figure><img alt='{caption}' src='data:image/png;base64,{image}'><figcaption>{caption}</figcaption></figure>"
    )


def _table_html(table: PageTable) -> str:
    head = "".join(f"<th>{html.escape(column)}</th>" for column in table.columns)
    rows = ("".join(f"<td>{html.escape(str(cell))}</td>" for cell in row) for row in table.rows)
    return f"<table><tr>{head}</tr>" + "".join(f"<tr>{row}</tr>" for row in rows) + "</table>"


def _png(figure: "Figure") -> bytes:
    buffer = io.BytesIO()
    figure.savefig(buffer, format="png", dpi=130)
    return buffer.getvalue()
