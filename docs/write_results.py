"""Rewrite the results of the README from study runs and a benchmark: `make results`.

Usage: python docs/write_results.py RUNS. Reads RUNS/measured-survey, RUNS/measured-proximity and RUNS/bench.json. The
full tables, with every interval and what differs, are the reports in the run folders.
"""

import json
import sys
from pathlib import Path

from rfcompass.studies.folder import read_rows
from rfcompass.studies.registry import study
from rfcompass.studies.summary import summarise

README = Path(__file__).resolve().parent.parent / "README.md"
BEGIN, END = "<!-- results -->", "<!-- /results -->"


def cells(runs, name, factor):
    """Text of each summary by (family, value of the factor, metric, summary): ours (interval), other's."""
    chosen, found = study(name), {}
    for row in summarise(chosen, read_rows(runs / name, chosen)):
        metric = chosen.metric(row.metric)
        if row.value is None:
            continue
        text = f"{metric.shown(row.value)}"
        if row.interval is not None:
            text += f" ({metric.shown(row.interval.low)} … {metric.shown(row.interval.high)})"
        if row.paper is not None:
            text += f"; {metric.shown(row.paper.value)}"
        found[row.cell["family"], row.cell[factor], row.metric, row.summary] = (text, row.n)
    return found


def survey_table(runs):
    """One line for each set and method."""
    found = cells(runs, "measured-survey", "method")
    yield "| measured sweeps | method | along the path, median cm: ours; pilot | in the plane, median cm: ours; pilot | pairs in order, %: ours; pilot |"
    yield "|---|---|---|---|---|"
    for family, method in dict.fromkeys((key[0], key[1]) for key in found):
        row = [found.get((family, method, *what)) for what in
               (("x_error_m", "median"), ("plane_error_m", "median"), ("x_order", "share"))]
        yield f"| {family}, {row[0][1]} tags | {method} | " + " | ".join("–" if c is None else c[0] for c in row) + " |"


def proximity_table(runs):
    """One line for each set."""
    found = cells(runs, "measured-proximity", "meter")
    meters = ("auto", "phase_l1", "phase_dtw", "pinit_dtw")
    yield "| measured sweeps | " + " | ".join(f"`{meter}`, %: ours; pilot" for meter in meters) + " | `auto`, gaps of 20 cm and more, % |"
    yield "|---|" + "---|" * (len(meters) + 1)
    for family in dict.fromkeys(key[0] for key in found):
        row = [found[family, meter, "correct", "share"][0] for meter in meters]
        far, n = found[family, "auto", "correct_far", "share"][0], found[family, "auto", "correct", "share"][1]
        yield f"| {family}, {n} questions | " + " | ".join([*row, far]) + " |"


def bench_table(runs):
    """One line for each timing."""
    yield "| computed on one thread | ours | peer | ratio |"
    yield "|---|---:|---|---:|"
    for t in json.loads((runs / "bench.json").read_text(encoding="utf-8"))["timings"]:
        yield f"| {t['name']} | {1e3 * t['ours_s']:,.2f} ms | {t['peer']}: {1e3 * t['peer_s']:,.1f} ms | {t['ratio']:.0f} |"


def main(runs):
    """Replace what stands between the two markers."""
    parts = [
        "**Where are the tags?** `rfcompass study run measured-survey`: ours (95 % interval); our own unpublished pilot\n"
        "study on all public sweeps of the set, with one channel for `hyperbolic`.",
        "\n".join(survey_table(runs)),
        "**Which of two tags is nearer?** `rfcompass study run measured-proximity`: share of right answers (95 % interval);\n"
        "the pilot study. `pinit_dtw` is the papers' reading, literally; 50 % is a coin.",
        "\n".join(proximity_table(runs)),
        "**How fast?** `rfcompass bench`, ours and the peer's in one run.",
        "\n".join(bench_table(runs)),
    ]
    text = README.read_text(encoding="utf-8")
    before, after = text.split(BEGIN)[0], text.split(END)[1]
    README.write_text(before + BEGIN + "\n\n" + "\n\n".join(parts) + "\n\n" + END + after, encoding="utf-8")


if __name__ == "__main__":
    main(Path(sys.argv[1]))
