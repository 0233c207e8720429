import base64
import re
from dataclasses import replace
from html.parser import HTMLParser

import pytest
from matplotlib.figure import Figure
from toy_study import METRICS, toy_study

from rfcompass.errors import StudyError
from rfcompass.studies.report import html_page, markdown_table, write_report
from rfcompass.studies.runner import run_study
from rfcompass.studies.study import PaperValue
from rfcompass.studies.summary import RunFacts

FACTS = RunFacts(32, 8, {"TooFewReads": 2}, ("numpy <2>",), 1.0)


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    out = tmp_path_factory.mktemp("run")
    run_study(toy_study(), out, backend="sequential")
    return out


@pytest.fixture
def rows(run):
    return write_report(toy_study(), run)


class Cells(HTMLParser):
    """Collects the table of a page."""

    def __init__(self):
        super().__init__()
        self.rows, self.tags, self.in_cell = [], [], False

    def handle_starttag(self, tag, attrs):
        self.tags.append((tag, dict(attrs)))
        if tag == "tr":
            self.rows.append([])
        self.in_cell = tag in ("td", "th")
        if self.in_cell:
            self.rows[-1].append("")

    def handle_endtag(self, tag):
        self.in_cell = False

    def handle_data(self, data):
        if self.in_cell:
            self.rows[-1][-1] += data


def split(line):
    return [cell.strip().replace("\\|", "|") for cell in re.split(r"(?<!\\)\|", line)[1:-1]]


def test_the_markdown_table_puts_ours_beside_the_papers(rows):
    lines = [split(line) for line in markdown_table(toy_study(), rows).splitlines()]
    assert lines[0][-8:] == ["n", "failed", "ours", "95 % interval", "reference", "source", "what differs", "data"]
    assert {len(line) for line in lines} == {len(lines[0])}
    first = dict(zip(lines[0], lines[2], strict=True))
    assert first["metric"] == "error, median"
    assert first["ours"] == f"{100 * rows[0].value:.1f}"
    assert (first["reference"], first["what differs"]) == ("2.0", "another | room")
    assert first["data"] == "simulated"


def test_the_page_shows_the_same_table_as_markdown(rows):
    study = toy_study()
    page = Cells()
    page.feed(html_page(study, rows, FACTS))
    lines = [split(line) for line in markdown_table(study, rows).splitlines()]
    assert page.rows == [lines[0], *lines[2:]]


def test_the_page_needs_no_other_file(rows):
    png = b"\x89PNG\r\n\x1a\n rest"
    text = html_page(toy_study(), rows, FACTS, {"A & B": png})
    page = Cells()
    page.feed(text)
    assert not [tag for tag, _ in page.tags if tag in ("link", "script", "iframe")]
    (image,) = [attributes for tag, attributes in page.tags if tag == "img"]
    assert image["alt"] == "A & B"
    assert base64.b64decode(image["src"].removeprefix("data:image/png;base64,")) == png
    assert "http" not in text


def test_text_from_a_study_cannot_break_the_report(rows):
    paper = (PaperValue("error_m", "median", 0.02, "<b>|\n", "a\\|b", {"noise_m": 0.1}),)
    study = toy_study(title="<script>", note="1 < 2", paper=paper)
    hostile = [replace(row, paper=paper[0]) for row in rows if row.paper]
    table = markdown_table(study, hostile)
    assert len(table.splitlines()) == 2 + len(hostile)
    assert "&lt;b&gt;\\|" in table
    assert "a\\\\\\|b" in table
    page = html_page(study, hostile, FACTS)
    assert "<script>" not in page
    assert "<b>" not in page
    assert "numpy &lt;2&gt;" in page


def test_a_report_lies_beside_its_rows_and_repeats(run, rows):
    first = {name: (run / name).read_bytes() for name in ("report.md", "report.html")}
    assert write_report(toy_study(), run) == rows
    assert {name: (run / name).read_bytes() for name in first} == first
    assert b"TooFewReads" in first["report.md"]


def test_rows_of_another_study_are_not_reported(run):
    with pytest.raises(StudyError):
        write_report(toy_study(metrics=METRICS[:1]), run)


def test_what_a_study_draws_stands_in_its_page(run):
    def draws(table):
        figure = Figure()
        figure.add_subplot().plot(table.column("seed").to_numpy())
        return {"seeds & all": figure}

    write_report(replace(toy_study(), draws=draws), run)
    page = (run / "report.html").read_text(encoding="utf-8")
    (data,) = re.findall(r'src="data:image/png;base64,([^"]+)"', page)
    assert base64.b64decode(data).startswith(b"\x89PNG")
    assert "<figcaption>seeds &amp; all</figcaption>" in page
