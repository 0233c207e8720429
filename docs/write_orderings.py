"""Rewrite the table of the paper's orderings in docs/search_studies.md: each of them shown, not shown, or reversed.

Usage: python docs/write_orderings.py RUNS, the folder that holds searches, search-levels, search-tags and
search-kernels; part of `make results`.
"""

import sys
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pyarrow.compute as pc
from write_results import Results, table
from write_search import mean_and_interval

PAGE = Path(__file__).resolve().parent / "search_studies.md"
BEGIN, END = "<!-- orderings -->", "<!-- /orderings -->"
# What is compared: actions, a lost search counting 16; the arm's time where both found it [s]; found [%]; actions
# without those that failed.
ACTIONS, TIME, FOUND, HELD = "all_{}", "time_s_{}", "found_{}", "all_held_{}"
UNITS = {ACTIONS: "", TIME: " s", FOUND: " %", HELD: ""}
SEARCHES, LEVELS, TAGS, KERNELS = "searches", "search-levels", "search-tags", "search-kernels"
STUDIES = (SEARCHES, LEVELS, TAGS, KERNELS)


class Pair(NamedTuple):
    """The first arm less the second on the piles of a study, or of one family of it."""

    one: str
    other: str
    measure: str = ACTIONS
    study: str = SEARCHES
    family: str | None = None


class Ordering(NamedTuple):
    """What the paper prints, the pair that asks for it, and pairs that take it apart.

    Attributes:
        beside: Pairs that change one part of the method at a time, and so say where a difference comes from.
        higher: Whether the first should have more rather than less.
    """

    words: str
    where: str
    asked: Pair
    beside: tuple[Pair, ...] = ()
    higher: bool = False


# Equal views, updates and memory, so that policy and map alone differ; and what those are worth to Eq. 4.
EQUAL, VIEWS = Pair("fusebot_equal", "xray_equal"), Pair("fusebot_equal", "fusebot_0")
# What tags say at most: how all other things lie.
FEW, SOME, MANY = "covered_2p20", "covered_3p25", "covered_3p42"
ALL_TAGS = Pair("others_known", "ours_0", ACTIONS, SEARCHES, SOME)
ORDERINGS = (
    Ordering("actions: FuseBot, 8 tags, below X-Ray", "Table 1", Pair("fusebot_8", "xray"), (EQUAL, VIEWS)),
    Ordering("a quarter tagged, below X-Ray", "section 1", Pair("fusebot_quarter", "xray"), (EQUAL, VIEWS)),
    Ordering("tagged target below X-Ray", "Table 1", Pair("fusebot_own", "xray"), (Pair("fusebot_own", "fusebot_0"),)),
    Ordering("tagged target below untagged", "Table 1", Pair("fusebot_own", "fusebot_0"), (Pair("known", "ours_0"),)),
    Ordering("found: FuseBot, 8 tags, above X-Ray", "Table 1", Pair("fusebot_8", "xray", FOUND),
             (Pair("fusebot_equal", "xray_equal", FOUND),), higher=True),
    Ordering("found: tagged target above X-Ray", "Table 1", Pair("fusebot_own", "xray", FOUND),
             (Pair("fusebot_own", "fusebot_0", FOUND),), higher=True),
    Ordering("time: FuseBot, 8 tags, below X-Ray", "Table 2", Pair("fusebot_8", "xray", TIME),
             (Pair("fusebot_8", "fusebot_0", TIME), Pair("fusebot_0", "xray", TIME))),
    Ordering("its policy, above its cluster, below the naive one, above its voxel", "Table 3", Pair("fusebot_0", "naive"),
             (Pair("naive_gate", "naive"), Pair("fusebot_0", "naive_gate"))),
    Ordering("deformable kernel below the ball, failed grasps left out", "Table 4",
             Pair("deformable", "spherical", HELD, KERNELS), (Pair("deformable", "spherical", ACTIONS, KERNELS),)),
    *(
        Ordering(f"FuseBot, 8 tags, below X-Ray, {words}", "Fig. 9a", Pair("fusebot_8", "xray", ACTIONS, LEVELS, family),
                 (Pair("xray_views", "xray", ACTIONS, LEVELS, family),))
        for words, family in (("2 piles, 20 things", FEW), ("3 piles, 25", SOME), ("3 piles, 42", MANY))
    ),
    Ordering("without tags below X-Ray, 3 piles", "Fig. 9b", Pair("fusebot_0", "xray", ACTIONS, TAGS),
             (Pair("fusebot_equal", "xray_equal", ACTIONS, SEARCHES, SOME),)),
    Ordering("nine tags below X-Ray, 3 piles", "Fig. 9b", Pair("fusebot_9", "xray", ACTIONS, TAGS),
             (Pair("fusebot_equal", "xray_equal", ACTIONS, SEARCHES, SOME),)),
    *(
        Ordering(f"{count} tags below none, 3 piles", "Fig. 9b", Pair(f"fusebot_{count}", "fusebot_0", ACTIONS, TAGS),
                 (Pair(f"ours_{count}", "ours_0", ACTIONS, TAGS), ALL_TAGS))
        for count in (3, 6, 9)
    ),
    *(
        Ordering(f"three tags, {words}, below X-Ray", "Fig. 9c", Pair(f"fusebot_{place}", "xray", ACTIONS, TAGS),
                 (Pair(f"fusebot_{place}", "fusebot_0", ACTIONS, TAGS),))
        for words, place in (("in another pile", "other_pile"), ("opposite", "opposite"), ("touching", "touching"))
    ),
    *(
        Ordering(f"in another pile below {words}", "Fig. 9c", Pair("fusebot_other_pile", f"fusebot_{place}", ACTIONS, TAGS))
        for words, place in (("opposite", "opposite"), ("touching", "touching"))
    ),
)  # fmt: skip


def values_of(rows, pair):
    """Differences of a pair on the piles where both have a value."""
    if pair.family is not None:
        rows = rows.filter(pc.equal(rows.column("family"), pair.family))
    both = zip(*(rows.column(pair.measure.format(arm)).to_pylist() for arm in (pair.one, pair.other)), strict=True)
    scale = 100.0 if pair.measure == FOUND else 1.0
    return scale * np.array([number(a) - number(b) for a, b in both if a not in (None, []) and b not in (None, [])])


def number(value):
    """A value of a row, or the only one of its list."""
    return float(value[0] if isinstance(value, list) else value)


def verdict(low, high, *, higher):
    """What an interval says of an ordering."""
    if np.isnan(low):
        return "–"
    if low <= 0 <= high:
        return "*not shown*"
    return "*shown*" if (low > 0) == higher else "*reversed*"


def shown(values, measure):
    """Mean (interval) with its unit, and on how many piles."""
    digits = 0 if measure == FOUND else 1 if measure == TIME else 2
    mean, low, high = mean_and_interval(values)
    numbers = (f"{number + 0.0:.{digits}f}" for number in np.round((mean, low, high), digits))
    return "{} ({} … {}){}, {}".format(*numbers, UNITS[measure], len(values))


def growth(levels):
    """How much larger FuseBot's lead over X-Ray is with 42 things than with 20: other piles, so not paired."""
    few, many = (values_of(levels, Pair("fusebot_8", "xray", ACTIONS, LEVELS, family)) for family in (FEW, MANY))
    rng = np.random.default_rng(0)
    draws = [rng.choice(of, (4000, len(of))).mean(axis=1) for of in (many, few)]
    low, high = np.percentile(draws[0] - draws[1], [2.5, 97.5])
    return many.mean() - few.mean(), low, high


def orderings(runs):
    """The table."""
    rows = {name: Results(runs, name).rows for name in STUDIES}
    lines = []
    for words, where, asked, beside, higher in ORDERINGS:
        values = values_of(rows[asked.study], asked)
        _, low, high = mean_and_interval(values)
        why = "; ".join(
            f"`{pair.one}` less `{pair.other}` {shown(values_of(rows[pair.study], pair), pair.measure)}"
            for pair in beside
        )
        lines.append([words, where, shown(values, asked.measure), verdict(low, high, higher=higher), why])
    mean, low, high = growth(rows[LEVELS])
    gap = f"{mean:.2f} ({low:.2f} … {high:.2f}), not paired"
    lines.append(
        ["its lead over X-Ray grows from 20 things to 42", "Fig. 9a", gap, verdict(low, high, higher=False), ""]
    )
    return table(("ordering", "paper", "first less second, piles", "on our piles", "taken apart, piles"), *lines)


def write(runs):
    """Rewrite the page."""
    old = PAGE.read_text(encoding="utf-8")
    if old.count(BEGIN) != 1 or old.count(END) != 1:
        raise SystemExit(f"{PAGE}: {BEGIN} and {END} should stand there once")
    PAGE.write_text(f"{old.split(BEGIN)[0]}{BEGIN}\n\n{orderings(runs)}\n\n{END}{old.split(END)[1]}", encoding="utf-8")


if __name__ == "__main__":
    write(Path(sys.argv[1]))
