"""Rewrite the results table of the README from study runs and a benchmark: `make results`.

Usage: python docs/write_results.py RUNS_FOLDER. Reads RUNS/measured-survey, RUNS/measured-proximity and RUNS/bench.json;
what is not there is left out, and the table says so.
"""

import json
import sys
from pathlib import Path

from rfcompass.errors import StudyError
from rfcompass.studies.folder import read_rows
from rfcompass.studies.registry import study
from rfcompass.studies.summary import SummaryRow, summarise

README = Path(__file__).resolve().parent.parent / "README.md"
BEGIN, END = "<!-- results -->", "<!-- /results -->"
SURVEY = [("x_error_m", "median", "error along the path, median"), ("plane_error_m", "median", "error in the plane, median"),
          ("x_order", "share", "tag pairs in the right order")]
PROXIMITY = [("correct", "share", "comparisons that are right"), ("correct_far", "share", "right for gaps of 20 cm and more")]
HEAD = ("| what | ours | 95 % interval | other | what differs | reads | command |", "|---|---:|---:|---:|---|---|---|")


def shown(row: SummaryRow, name: str) -> list[str]:
    """Value, interval, the other's value and what differs, in the unit of the report."""
    metric = study(name).metric(row.metric)
    unit = f" {metric.unit}" if metric.unit else ""
    low, high = (row.interval.low, row.interval.high) if row.interval else (None, None)
    other = "–" if row.paper is None else f"{metric.shown(row.paper.value)}{unit}"
    differs = "" if row.paper is None else f"pilot study: {row.paper.differs}"
    return [f"{metric.shown(row.value)}{unit}", f"{metric.shown(low)} … {metric.shown(high)}", other, differs]


def study_lines(runs: Path, name: str, factor: str, values: tuple[str, ...], wanted: list[tuple[str, str, str]]) -> list[str]:
    """One line for each family, value of the factor, and wanted summary."""
    chosen = study(name)
    try:
        rows = summarise(chosen, read_rows(runs / name, chosen))
    except StudyError as error:
        return [f"| {chosen.title}: not run ({error.kind}) | | | | | | `rfcompass study run {name}` |"]
    lines = []
    for row in rows:
        title = {(metric, summary): title for metric, summary, title in wanted}.get((row.metric, row.summary))
        if title is None or row.cell[factor] not in values or row.value is None:
            continue
        what = f"{row.cell['family']}, {row.cell[factor]}: {title} (n = {row.n})"
        lines.append(f"| {what} | " + " | ".join(shown(row, name)) + f" | {chosen.kind} | `rfcompass study run {name}` |")
    return lines


def bench_lines(runs: Path) -> list[str]:
    """One line for each timing."""
    file = runs / "bench.json"
    if not file.is_file():
        return ["| timings: not run | | | | | | `rfcompass bench` |"]
    timings = json.loads(file.read_text(encoding="utf-8"))["timings"]
    return [
        f"| {t['name']} | {1e3 * t['ours_s']:.3g} ms | | {1e3 * t['peer_s']:.3g} ms ({t['peer']}) | "
        f"{t['ratio']:.0f} times faster | computed | `rfcompass bench` |"
        for t in timings
    ]


def main(runs: Path) -> None:
    """Replace what stands between the two markers."""
    lines = [
        *HEAD,
        *study_lines(runs, "measured-survey", "method", ("hyperbolic", "sar"), SURVEY),
        *study_lines(runs, "measured-proximity", "meter", ("auto", "phase_l1", "pinit_dtw"), PROXIMITY),
        *bench_lines(runs),
    ]
    text = README.read_text(encoding="utf-8")
    before, after = text.split(BEGIN)[0], text.split(END)[1]
    README.write_text(before + BEGIN + "\n\n" + "\n".join(lines) + "\n\n" + END + after, encoding="utf-8")


if __name__ == "__main__":
    main(Path(sys.argv[1]))
