"""Rewrite the tables in docs/grasp_trials.md from runs of `accuracy` and `grasp-trials`; part of `make results`.

Usage: python docs/write_grasp_trials.py RUNS. Writes docs/images/attempts.png as well.
"""

import os
import sys
from pathlib import Path

import numpy as np
import pyarrow.compute as pc
from write_results import BEGIN, END, Results, table

from rfcompass.evaluation.error_pairs import ErrorPairs
from rfcompass.evaluation.grasp_trials import CAP, Attempts, chance_of, implied_factor
from rfcompass.robots.hand import VERDICTS
from rfcompass.studies.grasp_trials import (
    MEDIAN_M,
    OPENINGS_M,
    PRINTED,
    RULES,
    SOURCES,
    TAGS,
    WIDTH_M,
    error_source,
    geometric_rule,
    printed_factor_bounds,
    rules,
)
from rfcompass.studies.stored_errors import RUN_VARIABLE

PAGE = Path(__file__).resolve().parent / "grasp_trials.md"
PICTURE = PAGE.parent / "images" / "attempts.png"
TITLES = {"geometry": "hand's geometry", "half": "(G - w)/2", "whole": "G - w"}
SHOWN = 40
PLACES_M = (0.0, 0.05, 0.10, 0.15)


def cm(opening_m):
    return f"{100 * opening_m:g} cm"


def figure_table(runs):
    """What the paper prints, a line for each figure and rule; a column for each source."""
    got = Results(runs, "grasp-trials")
    sources = [name for name in SOURCES if "surest" not in name and any(key[0] == name for key in got.found)]
    lines = []
    for one in PRINTED:
        summary, what = ("mean", "mean attempts") if one.metric == "tries" else ("share", "first attempt holds, %")
        for rule in RULES:
            cells = [
                (at_least(got, (name, one.tags, one.opening_m), rule) if one.metric == "tries" else "")
                + got.text(name, one.tags, one.opening_m, f"{one.metric}_{rule}", summary).split(";")[0]
                for name in sources
            ]
            lines.append([f"{one.figure}, K = {one.tags}, {cm(one.opening_m)}", what, TITLES[rule], *cells, printed(one)])
    return table(("simulated", "", "rule", *(f"{name}:" for name in sources), "paper:"), *lines)


def printed(one):
    if one.metric == "tries":
        return f"{one.value:g}"
    return f"{'over' if one.tags == 2 else 'almost'} {100 * one.value:.0f}"


def runs_table(runs):
    """All cells: mean attempts and share of first attempts by each rule."""
    got = Results(runs, "grasp-trials")
    lines = []
    for name, tags, opening_m in dict.fromkeys(key[:3] for key in got.found):
        cell = (name, tags, opening_m)
        texts = [
            f"{at_least(got, cell, rule)}{got.own(*cell, f'tries_{rule}', 'mean')} · {got.own(*cell, f'first_{rule}', 'share')}"
            for rule in RULES
        ]
        lines.append([name, str(tags), cm(opening_m), *texts, got.own(*cell, "tries_combined", "mean")])
    heads = [f"{TITLES[rule]}:" for rule in RULES]
    return table(("errors of", "K", "hand", *heads, "geometry, mean of all so far:"), *lines)


def at_least(got, cell, rule):
    return "≥ " if float(got.own(*cell, f"given_up_{rule}", "share")) > 0 else ""


def chance_table():
    """Chance of one attempt by the hand's geometry, with the interval of the pairs that it was computed from."""
    lines = []
    for name in SOURCES:
        for tags in TAGS:
            source = error_source(name, tags)
            if not isinstance(source, ErrorPairs):
                continue
            medians = (100 * np.median(source.distance_m), np.rad2deg(np.median(np.abs(source.theta_rad))))
            chances = []
            for opening_m in OPENINGS_M:
                chance = chance_of(source, geometric_rule(opening_m))
                interval = chance.interval(np.random.default_rng(0))
                chances.append(f"{100 * chance.value:.0f} ({100 * interval.low:.0f} … {100 * interval.high:.0f})")
            complete = f"{len(source)}, {100 * source.complete_share:.0f} %" if "surest" not in name else f"{len(source)}"
            lines.append([name, str(tags), complete, f"{medians[0]:.1f} cm · {medians[1]:.1f}°", *chances])
    heads = [f"{cm(opening_m)}:" for opening_m in OPENINGS_M]
    return table(("errors of", "K", "pairs, of all trials", "medians", *heads), *lines)


def place_table():
    """Chance of one attempt by where on the leg it is planned, K = 2."""
    lines = []
    for name in SOURCES:
        source = error_source(name, 2)
        pairs = source if isinstance(source, ErrorPairs) else as_pairs(source)
        for opening_m in OPENINGS_M[:2]:
            chances = [chance_of(pairs, geometric_rule(opening_m, along_m)).value for along_m in PLACES_M]
            lines.append([name, cm(opening_m), *(f"{100 * chance:.0f}" for chance in chances)])
    return table(("errors of", "hand", *(f"{cm(along_m)}:" for along_m in PLACES_M)), *lines)


def as_pairs(family):
    """Two hundred draws of a family, in place of stored errors."""
    draws = family.draw(200, np.random.default_rng(0))
    return ErrorPairs(distance_m=draws.distance_m, theta_rad=np.abs(draws.theta_rad))


def factor_table():
    """The c of |e| <= c (G - w) that would give the paper's figures."""
    lines = [
        [name, *(f"{implied_factor(error_source(name, one.tags), one.opening_m, WIDTH_M, one.chance):.2f}" for one in PRINTED)]
        for name in SOURCES
        if "surest" not in name
    ]
    heads = [f"{one.figure}, K = {one.tags}, {cm(one.opening_m)}, {100 * one.chance:.0f} %:" for one in PRINTED]
    return table(("errors of", *heads), *lines)


def verdict_table(runs):
    """What becomes of the first attempt, K = 2, the paper's hand."""
    rows = Results(runs, "grasp-trials").rows
    rows = rows.filter(pc.and_(pc.equal(rows["tags"], 2), pc.equal(rows["opening_m"], OPENINGS_M[0])))
    lines = []
    for name in dict.fromkeys(rows["source"].to_pylist()):
        found = rows.filter(pc.equal(rows["source"], name))["first_verdict"].to_pylist()
        lines.append([name, *(f"{100 * found.count(verdict) / len(found):.0f}" for verdict in VERDICTS[:-1])])
    return table(("errors of", *(f"`{verdict}`, %:" for verdict in VERDICTS[:-1])), *lines)


def picture(runs):
    """CDFs of the attempts, K = 2, for the paper's medians; dashed what the paper's means imply."""
    from rfcompass.viz.attempt_figures import draw_attempts

    rows = Results(runs, "grasp-trials").rows
    rows = rows.filter(pc.and_(pc.equal(rows["tags"], 2), pc.equal(rows["source"], "the paper's medians")))
    curves = {}
    for rule in RULES:
        for opening_m in OPENINGS_M:
            cell = rows.filter(pc.equal(rows["opening_m"], opening_m))
            tries = cell[f"tries_{rule}"].to_numpy().astype(np.int64)
            held = ~cell[f"given_up_{rule}"].to_numpy(zero_copy_only=False)
            curves.setdefault(TITLES[rule], {})[cm(opening_m)] = Attempts(tries, held, CAP).cdf(SHOWN)
    t = np.arange(1, SHOWN + 1)
    paper = {
        cm(one.opening_m): 1 - (1 - one.chance) ** t if one.metric == "tries" else np.array([one.chance])
        for one in PRINTED
        if one.tags == 2
    }
    PICTURE.parent.mkdir(exist_ok=True)
    draw_attempts(curves, paper).savefig(PICTURE, dpi=110)


def squeeze():
    """How much of the errors can lie between the thresholds of 8.5 and 10 cm, and how much the paper needs there."""
    family = error_source("the paper's medians", 2)
    d = np.linspace(0.0, 0.15, 15001)
    below = 1 - 0.5 ** ((d / family.median_m) ** family.shape)
    margins = [opening_m - WIDTH_M for opening_m in OPENINGS_M]
    c = np.linspace(0.3, 1.2, 901)
    most = max(np.interp(c * margins[2], d, below) - np.interp(c * margins[1], d, below))
    return f"{100 * most:.0f} %"


def write(runs):
    """Replace what stands between the two markers of the page."""
    os.environ[RUN_VARIABLE] = str(runs / "accuracy")
    bounds = printed_factor_bounds()
    text = "\n\n".join([
        "### What the paper prints",
        "Mean attempts, or share of first attempts that hold in %, of 1000 runs (95 % interval of the runs).",
        figure_table(runs),
        "### Every hand",
        "Mean attempts · share of first attempts that hold in %; ≥: some runs were given up after " + f"{CAP} attempts.",
        runs_table(runs),
        "### How sure the chances are",
        "Chance of one attempt by the hand's geometry in %, with the 95 % interval over the pairs drawn from. More runs\n"
        "do not make it narrower.",
        chance_table(),
        "### What becomes of the first attempt",
        f"K = 2, hand of {cm(OPENINGS_M[0])}.",
        verdict_table(runs),
        "### What the choice of the grasp is worth",
        "Chance of one attempt in %, K = 2, by how far from the middle of the leg the grasp is planned.",
        place_table(),
        "### The threshold that the paper's figures imply",
        f"c of |e| ≤ c (G - w). The paper's medians alone say {bounds.low:.2f} < c < {bounds.high:.2f} (K = 2: 8.5 cm must lie "
        f"below the\nmedian, 10 cm above), and c > {MEDIAN_M[4] / 0.025:.2f} for K = 4.",
        factor_table(),
        f"One c would have to fit a whole line. It cannot: between the thresholds of 8.5 and 10 cm the paper needs at least 60 %\n"
        f"of all errors (80 % less 20 %), and of errors with its median and its spread at most {squeeze()} lie there, for any c.",
    ])  # fmt: skip
    page = PAGE.read_text(encoding="utf-8")
    PAGE.write_text(f"{page.split(BEGIN)[0]}{BEGIN}\n\n{text}\n\n{END}{page.split(END)[1]}", encoding="utf-8")
    picture(runs)


if __name__ == "__main__":
    write(Path(sys.argv[1]))
