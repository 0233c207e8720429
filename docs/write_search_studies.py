"""Rewrite the tables in docs/search_studies.md of the studies beside `searches`, each from its run if there is one.

Usage: python docs/write_search_studies.py RUNS, the folder that holds search-levels, search-tags and so on.
"""

import sys
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.compute as pc
from write_results import Results, table
from write_search import difference_table, family_table, interval, main_table, pooled_quantiles, pooled_values, share

from rfcompass.studies.search_classes import BY_CLASS, CLASS_PAIRS
from rfcompass.studies.search_confirm import CONFIRM_ARMS, CONFIRM_PAIRS
from rfcompass.studies.search_figures import BY_LEVEL, BY_TAGS, LEVEL_PAIRS, TAG_PAIRS
from rfcompass.studies.search_kernels import KERNELS

PAGE = Path(__file__).resolve().parent / "search_studies.md"


@dataclass
class Part:
    """Some rows of a run, for the functions that pool all of them."""

    rows: pa.Table


def parts(got, factor):
    """Rows of each value of a factor."""
    values = dict.fromkeys(got.rows.column(factor).to_pylist())
    return {value: Part(got.rows.filter(pc.equal(got.rows.column(factor), value))) for value in values}


def by_part(of, arms, pairs):
    """Found, actions and paired differences, a column for each part."""
    lines = [[f"`{arm}`: found, %", *(share(part, f"found_{arm}") for part in of.values())] for arm in arms]
    lines += [[f"`{arm}`: mean actions, 16 where not found", *(interval(pooled_values(part, f"all_{arm}")) for part in of.values())]
              for arm in arms]  # fmt: skip
    lines += [[f"actions where found, p10 / 50 / 90, `{arm}`", *(pooled_quantiles(part, f"actions_{arm}") for part in of.values())]
              for arm in arms]  # fmt: skip
    lines += [[f"`{one}` less `{other}`", *(interval(pooled_values(part, f"less_{one}_{other}")) for part in of.values())]
              for one, other in pairs]  # fmt: skip
    return table(("simulated", *(f"{name}, {len(part.rows)} piles:" for name, part in of.items())), *lines)


def differences(got, pairs):
    """Paired differences over all rows."""
    lines = [[f"`{one}` less `{other}`", interval(pooled_values(got, f"less_{one}_{other}"))] for one, other in pairs]
    return table(("actions, paired", "all:"), *lines)


def confirm(got):
    """What `searches` suggests, on other piles."""
    return "\n\n".join((main_table(got, CONFIRM_ARMS), difference_table(got, CONFIRM_PAIRS), family_table(got, CONFIRM_ARMS)))


def levels(got):
    """Fig. 9a."""
    return f"{by_part(parts(got, 'family'), BY_LEVEL, LEVEL_PAIRS)}\n\n{differences(got, LEVEL_PAIRS)}"


def classes(got):
    """By how much of the target is in sight."""
    return by_part(parts(got, "target_class"), BY_CLASS, CLASS_PAIRS)


# Fig. 9b counts tags that were located: from and to.
LOCATED = ((0, 0), (1, 3), (4, 6), (7, 9))


def by_located(got):
    """Mean actions by how many tags were located confidently before the first action, searches with any number dealt."""
    lines = []
    for way in ("fusebot", "ours"):
        cells, rows = [], got.rows.to_pylist()
        for low, high in LOCATED:
            arms = [f"{way}_{count}" for count in (0, 3, 6, 9)]
            of_piles = [[row[f"all_{arm}"] for arm in arms
                         if row[f"all_{arm}"] is not None and low <= row[f"located_{arm}"] <= high] for row in rows]  # fmt: skip
            cells.append(clustered([values for values in of_piles if values]))
        lines.append([f"`{way}`", *cells])
    heads = (f"{low} to {high} located:" if high else "none located:" for low, high in LOCATED)
    return table(("mean actions, 16 where not found", *heads), *lines)


def clustered(of_piles):
    """Mean of all values, its 95 % interval, piles drawn with all their searches; and how many searches there are."""
    if len(of_piles) < 2:
        return "–"
    sums, counts = np.array([(sum(values), len(values)) for values in of_piles]).T
    drawn = np.random.default_rng(0).integers(0, len(of_piles), (4000, len(of_piles)))
    low, high = np.percentile(sums[drawn].sum(axis=1) / counts[drawn].sum(axis=1), [2.5, 97.5])
    return f"{sums.sum() / counts.sum():.2f} ({low:.2f} … {high:.2f}), {int(counts.sum())}"


def tags(got):
    """Fig. 9b and 9c."""
    return f"{main_table(got, BY_TAGS)}\n\n{by_located(got)}\n\n{differences(got, TAG_PAIRS)}"


def kernels(got):
    """Table 4."""
    lines = [
        [f"`{kernel}`", share(got, f"found_{kernel}"), pooled_quantiles(got, f"held_{kernel}"),
         interval(pooled_values(got, f"all_held_{kernel}")), interval(pooled_values(got, f"all_{kernel}")),
         interval(pooled_values(got, f"located_{kernel}"), 1)]
        for kernel in KERNELS
    ]  # fmt: skip
    lines.append(["first less second", "–", "–", *(interval(pooled_values(got, f"less_{what}")) for what in ("all_held", "all")), "–"])
    heads = ("found, %:", "grasps that held, where found, p10 / 50 / 90:", "their mean, 16 where not:", "with failed ones:",
             "tags located:")  # fmt: skip
    return table((f"simulated, {len(got.rows)} piles", *heads), *lines)


STUDIES = {"search-confirm": confirm, "search-levels": levels, "search-tags": tags, "search-kernels": kernels, "search-classes": classes}


def write(runs):
    """Rewrite what stands between the markers of each study that was run."""
    text = PAGE.read_text(encoding="utf-8")
    for name, make in STUDIES.items():
        if (runs / name).is_dir():
            begin, end = f"<!-- {name} -->", f"<!-- /{name} -->"
            if text.count(begin) != 1 or text.count(end) != 1:
                raise SystemExit(f"{PAGE}: {begin} and {end} should stand there once")
            text = f"{text.split(begin)[0]}{begin}\n\n{make(Results(runs, name))}\n\n{end}{text.split(end)[1]}"
    PAGE.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    write(Path(sys.argv[1]))
