"""Rewrite the tables in docs/search_studies.md from a run of `searches`.

Usage: python docs/write_search.py RUNS; part of `make results`.
"""

import sys
from pathlib import Path

import numpy as np
import pyarrow.compute as pc
from write_results import Results, table

from rfcompass.evaluation.statistics import wilson_interval
from rfcompass.studies.searches import ARMS, EVERY_ARM, GATE_PAIRS, PAIRS

DOCS = Path(__file__).resolve().parent
BEGIN, END = "<!-- search-results -->", "<!-- /search-results -->"


def families(got):
    return list(dict.fromkeys(key[0] for key in got.found))


def pooled_values(got, column):
    return got.rows.column(column).drop_null().to_numpy()


def mean_and_interval(values):
    """Mean over all scenes and both ends of its 95 % interval, 4000 resamples of scenes; NaN for fewer than two."""
    if len(values) < 2:
        return np.nan, np.nan, np.nan
    draws = np.random.default_rng(0).choice(values, (4000, len(values))).mean(axis=1)
    return values.mean(), *np.percentile(draws, [2.5, 97.5])


def interval(values, digits=2):
    """Mean over all scenes with its 95 % interval, as text."""
    mean, low, high = mean_and_interval(values)
    return "–" if np.isnan(mean) else f"{mean:.{digits}f} ({low:.{digits}f} … {high:.{digits}f})"


def pooled_quantiles(got, column, scale=1.0):
    values = np.concatenate([np.array(row) for row in got.rows.column(column).to_pylist() if row is not None] or [[]])
    if not len(values):
        return "–"
    return " / ".join(f"{q * scale:.1f}" for q in np.percentile(values, [10, 50, 90]))


def share(got, column):
    values = pooled_values(got, column)
    low, high = wilson_interval(int(values.sum()), len(values)).low, wilson_interval(int(values.sum()), len(values)).high
    return f"{100 * values.mean():.0f} ({100 * low:.0f} … {100 * high:.0f})"


def main_table(got, arms=ARMS):
    """Tables 1 and 2, all families together."""
    lines = []
    for arm in arms:
        grasps = np.concatenate([np.array(row) for row in got.rows.column(f"grasps_{arm}").to_pylist() if row] or [[]])
        held = f"{100 * grasps.mean():.0f}" if len(grasps) else "–"
        if said_of(got, arm) is not None:
            held = f"{100 * said_of(got, arm):.0f} / {held}"
        lines.append([
            f"`{arm}`", share(got, f"found_{arm}"), pooled_quantiles(got, f"actions_{arm}"),
            interval(pooled_values(got, f"all_{arm}")), pooled_quantiles(got, f"time_s_{arm}"), held,
        ])  # fmt: skip
    heads = ("found, %:", "actions where found, p10 / 50 / 90:", "mean, 16 where not:", "arm, s, p10 / 50 / 90:",
             "grasps: promised / held, %:" if any(said_of(got, arm) is not None for arm in arms) else "grasps that held, %:")  # fmt: skip
    return table((f"simulated, {len(got.rows)} piles", *heads), *lines)


def said_of(got, arm):
    """Mean promise of all grasps of an arm; None where rows do not tell."""
    if f"said_{arm}" not in got.rows.column_names:
        return None
    said = [chance for row in got.rows.column(f"said_{arm}").to_pylist() if row for chance in row]
    return float(np.mean(said)) if said else None


def family_table(got, arms=ARMS):
    """Mean actions, a column for each family."""
    lines = [[f"`{arm}`", *(got.text(family, f"all_{arm}", "mean") for family in families(got)),
              " / ".join(got.text(family, f"found_{arm}", "share", interval=False).split(";")[0] for family in families(got))]
             for arm in arms]  # fmt: skip
    return table(("mean actions, 16 where not found", *(f"{name}:" for name in families(got)), "found, %:"), *lines)


def difference_table(got, pairs=PAIRS):
    """Paired differences."""
    lines = []
    for one, other in pairs:
        column = f"less_{one}_{other}"
        by_family = [got.text(family, column, "mean") for family in families(got)]
        lines.append([f"`{one}` less `{other}`", interval(pooled_values(got, column)), *by_family])
    return table(("actions, paired", "all:", *(f"{name}:" for name in families(got))), *lines)


def together(got, *columns, family=None):
    """Values of columns on the scenes that have all of them, shape (columns, scenes), of one family if it is named."""
    of = got.rows if family is None else got.rows.filter(pc.equal(got.rows.column("family"), family))
    rows = zip(*(of.column(column).to_pylist() for column in columns), strict=True)
    return np.array([row for row in rows if None not in row], dtype=np.float64).T


def spread(values, measure, digits=0):
    """A measure of columns of scenes, with its 95 % interval, 4000 resamples of scenes."""
    drawn = np.random.default_rng(0).integers(0, values.shape[1], (4000, values.shape[1]))
    low, high = np.nanpercentile([measure(values[:, rows]) for rows in drawn], [2.5, 97.5])
    return f"{measure(values):.{digits}f} ({low:.{digits}f} … {high:.{digits}f})"


def saved(means):
    """Share in % of what the bound saves against random; means of random, bound, way."""
    random, bound, way = means.mean(axis=1)
    return 100 * (random - way) / (random - bound)


def bound(got):
    """Which share of what knowing the place would save against random is saved by each way, by family as well."""
    lines = []
    for arm in ARMS:
        if arm not in ("random_gate", "known"):
            columns = ("all_random_gate", "all_known", f"all_{arm}")
            of = [together(got, *columns), *(together(got, *columns, family=family) for family in families(got))]
            lines.append([f"`{arm}`", *(spread(values, saved) for values in of)])
    heads = ("all:", *(f"{family}:" for family in families(got)))
    return table(("of what knowing the place saves against `random_gate`, %", *heads), *lines)


HEADLINES = (
    ("fewer actions, 8 tags", "1.7", "all", "xray", "fusebot_8"),
    ("fewer actions, a quarter tagged", "up to 2.5", "all", "xray", "fusebot_quarter"),
    ("fewer actions, tagged target", "up to 4", "all", "xray", "fusebot_own"),
    ("less time, 8 tags", "2.3", "time_s", "xray", "fusebot_8"),
    ("fewer actions, ours, 8 tags", "–", "all", "xray", "ours_8"),
    ("less time, ours without tags", "–", "time_s", "xray", "ours_0"),
)


def headlines(got):
    """How many times fewer actions, or less time, than X-Ray."""
    lines = []
    for words, printed, what, one, other in HEADLINES:
        if what == "time_s":
            pairs = zip(*(got.rows.column(f"time_s_{arm}").to_pylist() for arm in (one, other)), strict=True)
            values = np.array([(a[0], b[0]) for a, b in pairs if a and b]).T
        else:
            values = together(got, f"{what}_{one}", f"{what}_{other}")
        ratio = spread(values, lambda two: two[0].mean() / two[1].mean(), 2)
        lines.append([words, printed, ratio, str(values.shape[1])])
    return table(("against X-Ray", "paper, times:", "on our piles, ratio of means:", "piles:"), *lines)


# Ways whose grasps are pooled; the literal ones grasp in the image in which they choose, ours looks again from near.
PROMISES = {"literal FuseBot": ("fusebot_0", "fusebot_8"), "literal X-Ray": ("xray",), "ours": ("ours_0", "ours_8")}
PROMISED = (0.0, 0.3, 0.5, 0.7, 0.85, 0.95, 1.0)


def promises(got):
    """What images promised of the grasps of searches, and how many of them held."""
    columns = []
    for arms in PROMISES.values():
        said, held = grasps_of(got, arms)
        if not len(said):
            return "–"
        chosen = [(said >= low) & ((said < high) | (high == 1.0)) for low, high in zip(PROMISED, PROMISED[1:], strict=False)]
        cells = [f"{said[of].mean():.2f} / {held[of].mean():.2f}, {of.sum()}" if of.any() else "–" for of in (said >= 0, *chosen)]
        columns.append([*cells, f"{ranked(said, held):.2f}"])
    ranges = [f"{low:g} to {high:g}" for low, high in zip(PROMISED, PROMISED[1:], strict=False)]
    heads = (f"{way}, {' and '.join(f'`{arm}`' for arm in arms)}:" for way, arms in PROMISES.items())
    lines = [[name, *cells] for name, *cells in zip(("all", *ranges, "AUC"), *columns, strict=True)]
    return table(("promised / held, grasps", *heads), *lines)


def grasps_of(got, arms):
    """Promise of each grasp of some arms, and whether it held."""
    said, held = ([value for arm in arms for row in got.rows.column(f"{what}_{arm}").to_pylist() if row for value in row]
                  for what in ("said", "grasps"))  # fmt: skip
    return np.array(said, dtype=np.float64), np.array(held, dtype=np.float64)


def ranked(said, held):
    """How often a grasp that held had been promised more than one that did not: the AUC."""
    above = said[held > 0][:, None] - said[held == 0]
    return float((above > 0).mean() + 0.5 * (above == 0).mean())


def write(runs):
    """Rewrite the page."""
    got = Results(runs, "searches")
    text = "\n\n".join([
        "`rfcompass study run searches`: targets that no view of the scan sees; every method on the same piles, executed grasps,\n"
        "masks from depth. `0` and `8` are tags on distractors, `quarter` on one of four of them, `own` is a tag on the target.\n"
        "Bounds: `known` is told where the target is, `others_known` where and how all other things lie. The paper prints p50 /\n"
        "p90 3 / 6 for FuseBot, 5 / 11 for X-Ray, 2 / 5 for a tagged target, found in 95, 84 and 95 %; 62 / 132 s and 142 / 237 s; naive 4 / 6.9.",
        main_table(got),
        "### Headline ratios",
        headlines(got),
        "### What differs, on the same piles",
        difference_table(got),
        "### What the gate does",
        "Each baseline with the gate of Eq. 5, less itself without.",
        main_table(got, {arm: EVERY_ARM[arm] for pair in GATE_PAIRS for arm in pair}),
        difference_table(got, GATE_PAIRS),
        "### By family",
        family_table(got),
        "### How much of the bound",
        bound(got),
        "### Do grasps hold what was promised?",
        promises(got),
    ])  # fmt: skip
    page = DOCS / "search_studies.md"
    old = page.read_text(encoding="utf-8")
    page.write_text(f"{old.split(BEGIN)[0]}{BEGIN}\n\n{text}\n\n{END}{old.split(END)[1]}", encoding="utf-8")


if __name__ == "__main__":
    write(Path(sys.argv[1]))
