"""Rewrite the tables in docs/pile_scan.md and docs/posterior_map.md from runs of `pile-tags` and `map-quality`.

Usage: python docs/write_piles.py RUNS; part of `make results`.
"""

import sys
from pathlib import Path

import numpy as np
from write_results import BEGIN, END, Results, table

from rfcompass.studies.map_quality import FIXES, GAINS, READINGS
from rfcompass.studies.pile_tags import LAYERS, MATERIALS

DOCS = Path(__file__).resolve().parent
ROUNDS = ("one", "two")


def families(got):
    return list(dict.fromkeys(key[0] for key in got.found))


def scenes(got):
    return len(np.unique(got.rows.column("seed")))


def error_table(runs):
    """Table 5: one line for each family and number of rounds."""
    got, lines = Results(runs, "pile-tags"), []
    for family in families(got):
        for rounds in ROUNDS:
            at = (family, rounds)
            cells = [got.text(*at, "nearest_m", what) for what in ("median", "p90")]
            cells += [got.pair(*at, f"nearest_{sight}_m") for sight in ("los", "nlos", "confident", "unsure")]
            counts = " + ".join(str(got.samples(*at, f"nearest_{sight}_m", "median")) for sight in ("los", "nlos"))
            lines.append([family, rounds, counts, *cells, got.text(*at, "confident", "share", interval=False)])
    heads = ("rounds", "tags, LOS + NLOS", "median: ours; paper", "p90: ours; paper", "LOS:", "NLOS:", "confident:",
             "the others:", "confident, %:")  # fmt: skip
    return table((f"simulated, {scenes(got)} piles each", *heads), *lines)


def cover_table(runs):
    """What lies over a tag, and what that does; two rounds."""
    got, lines = Results(runs, "pile-tags"), []
    groups = [(f"layers_{name}", f"{name}{' or more' if name == LAYERS[-1] else ''} things") for name in LAYERS]
    for name, title in [*groups, *((name, f"mostly {name}") for name in MATERIALS)]:
        cells = []
        for family in families(got):
            at, n = (family, "two"), got.samples(family, "two", f"nearest_{name}_m", "median")
            what = (("read", "mean"), ("confident", "share"))
            shown = [got.text(*at, f"{column}_{name}", summary, interval=False) for column, summary in what]
            shown.append(got.text(*at, f"nearest_{name}_m", "median", interval=False))
            cells.append(f"{' · '.join(shown)} ({n})" if n else "–")
        lines.append([title, *cells])
    return table(("between antenna and tag", *(f"{family}:" for family in families(got))), *lines)


def maps_table(runs):
    """Bits and ranks of every kind of map; a column for each family."""
    got, lines = Results(runs, "map-quality"), []
    names = ["uniform", "c", "map_0", "box_0", "posterior_0"]
    for fix in FIXES:
        names += [f"{kind}_8_{fix}" for kind in ("cr_consistent", "map_consistent", "posterior")]
    names += ["map_consistent_8_radio", "posterior_8_radio"]
    for name in names:
        cells = []
        for family in families(got):
            rank = got.text(family, f"rank_{name}", "mean", interval=False)
            cells.append(f"{got.text(family, f'bits_{name}', 'mean', interval=False)} · {rank}")
        lines.append([f"`{name}`", *cells])
    heads = [f"{family}, {got.samples(family, 'bits_c', 'mean')}:" for family in families(got)]
    return table(("simulated", *heads), *lines)


def gains_table(runs):
    """What tags save, in bits; a column for each family."""
    got, lines = Results(runs, "map-quality"), []
    for name in ordered_gains():
        cells = [got.text(family, f"gain_{name}", "mean") for family in families(got)]
        lines.append([f"`{name}`", *cells, pooled(got, f"gain_{name}")])
    return table(("simulated", *(f"{family}:" for family in families(got)), "all:"), *lines)


def verdict(runs):
    """What the tables say, in sentences."""
    got = Results(runs, "map-quality")
    means = {name: got.rows.column(f"bits_{name}").to_numpy().mean() for name in ("c", "map_0", "posterior_0")}
    saved = {
        kind: ", ".join(
            f"{pooled(got, f'gain_{kind}_8_{fix}')} {how}"
            for fix, how in (("exact", "if exact"), ("noisy", "if 3.6 cm off"), ("radio", "if located by radio"))
        )
        for kind in ("map_consistent", "posterior")
    }
    return (
        f"Over all {len(got.rows)} piles the visual map takes {means['c']:.2f} bits to say where the target is, convolved "
        f"{means['map_0']:.2f}, the\nposterior from the same images {means['posterior_0']:.2f}. Bits that eight tags save (95 % "
        f"interval):\n\n- the paper's map: {saved['map_consistent']};\n- the posterior: {saved['posterior']}."
    )


def ordered_gains():
    """The paper's reading first, then the literal ones, then what differs by the items, then ours."""
    first = [f"map_{reading}_{count}_{fix}" for reading in READINGS for fix in FIXES for count in (4, 8)]
    last = [f"posterior_{count}_{fix}" for fix in FIXES for count in (4, 8)]
    rest = [name for name in GAINS if name not in first + last and not name.startswith("cr_")]
    return [*first, *(n for n in rest if n.startswith("map")), *last, *(n for n in rest if n.startswith("posterior"))]


def pooled(got, column):
    """Mean over all scenes with its 95 % interval, 2000 resamples of scenes."""
    values = got.rows.column(column).drop_null().to_numpy()
    draws = np.random.default_rng(0).choice(values, (2000, len(values))).mean(axis=1)
    low, high = np.percentile(draws, [2.5, 97.5])
    return f"{values.mean():.2f} ({low:.2f} … {high:.2f})"


def replace(page, text):
    """Replace what stands between the two markers of a page."""
    old = page.read_text(encoding="utf-8")
    page.write_text(f"{old.split(BEGIN)[0]}{BEGIN}\n\n{text}\n\n{END}{old.split(END)[1]}", encoding="utf-8")


def write(runs):
    """Rewrite both pages."""
    replace(DOCS / "pile_scan.md", "\n\n".join([
        "### How far off",
        "Error to the nearest point of the tag, median / 90 % quantile in cm (95 % interval, tags of one pile together); the\n"
        "paper's Table 5, both sights together, on a real robot. It prints 3.6 / 6 cm, and NLOS less than 0.5 cm (median) and\n"
        "about 1 cm (90 %) above LOS.",
        error_table(runs),
        "### What lies over a tag",
        "Two rounds: antenna positions at which it was read in % · confident in % · median error in cm (tags).",
        cover_table(runs),
    ]))  # fmt: skip
    replace(DOCS / "posterior_map.md", "\n\n".join([
        "### In short",
        verdict(runs),
        "### Which map knows most",
        "Log-loss in bits · mean rank of the true voxel among the unobserved ones in %; smaller is better.",
        maps_table(runs),
        "### What tags save",
        "Bits (95 % interval) against the same map without tags; negative: tags mislead it.",
        gains_table(runs),
    ]))  # fmt: skip


if __name__ == "__main__":
    write(Path(sys.argv[1]))
