"""Rewrite the results in README.md and docs/results.md from study runs and a benchmark: `make results`.

Usage: python docs/write_results.py RUNS. Reads a run folder of each study that it shows, and RUNS/bench.json. The full
tables, with every interval and what differs, are the reports in the run folders.
"""

import json
import sys
from pathlib import Path

import numpy as np

from rfcompass.evaluation.box_against_error import box_against_error
from rfcompass.studies.error_pictures import picked
from rfcompass.studies.folder import read_rows
from rfcompass.studies.fusebot import boxes_against_errors
from rfcompass.studies.registry import study
from rfcompass.studies.summary import summarise

DOCS = Path(__file__).resolve().parent
README, PAGE = DOCS.parent / "README.md", DOCS / "results.md"
BEGIN, END = "<!-- results -->", "<!-- /results -->"
PAPERS_RIG = "the paper's, X4"
HEAD = """# Results

Written by `make results`. Each table says what was simulated and what was measured, and whose the figures beside ours are.

K is the number of tags on the part. `near L`, `far L`: two antenna legs about the part, or along two walls ([Fetching](fetch.md)); the paper's rig: one straight leg, with the
robot's nine tags as we lay them out (`X4`) or as its text suggests (`L0`). Six robot tags: `skew`, `from the text`, `designed` ([Tag layouts](layout.md)); stops in a sweep, at
random, or where they tell most (`active`). In sight, hidden: whether something stands before the part. D1 to D4: rows of tags of AdaRF, UAB: one tag and two antennas.
Piles: `covered_3p25` is 25 things in three piles with covers let go over the target, `poured` aims at nothing ([Piles](piles.md)).
"""


class Results:
    """Summaries of one study's run, as text: ours (95 % interval); the other figure, if there is one."""

    def __init__(self, runs, name):
        self.study = study(name)
        self.rows = read_rows(runs / name, self.study)
        self.found = {(*row.cell.values(), row.metric, row.summary): row for row in summarise(self.study, self.rows)}

    def samples(self, *key):
        """Number of values behind a summary."""
        return self.found[key].n

    def text(self, *key, interval=True):
        """One summary, by the values of all factors, the metric and what is reported of it."""
        row = self.found.get(key)
        if row is None or row.value is None:
            return "–"
        metric = self.study.metric(row.metric)
        text = metric.shown(row.value)
        if interval and row.interval is not None:
            text += f" ({metric.shown(row.interval.low)} … {metric.shown(row.interval.high)})"
        return text + (f"; {metric.shown(row.paper.value)}" if row.paper is not None else "")

    def own(self, *key):
        """Our figure alone."""
        row = self.found[key]
        return self.study.metric(row.metric).shown(row.value)

    def pair(self, *cell_and_metric):
        """Median / 90 % quantile, without intervals."""
        return " / ".join(self.text(*cell_and_metric, s, interval=False) for s in ("median", "p90"))


def table(head, *lines):
    """Markdown of a table; `head` may mark a column as a number with a trailing colon."""
    rule = ["---:" if cell.endswith(":") else "---" for cell in head]
    return "\n".join("| " + " | ".join(line) + " |" for line in ([c.rstrip(":") for c in head], rule, *lines))


def survey_table(runs):
    """One line for each set and method."""
    got = Results(runs, "measured-survey")
    columns = (("x_error_m", "median"), ("plane_error_m", "median"), ("x_order", "share"))
    lines = [
        [
            f"{family}, {got.samples(family, method, 'x_error_m', 'median')} tags",
            method,
            *(got.text(family, method, *what) for what in columns),
        ]
        for family, method in dict.fromkeys(key[:2] for key in got.found)
    ]
    units = (
        "along the path, median cm: ours; pilot",
        "in the plane, median cm: ours; pilot",
        "pairs in order, %: ours; pilot",
    )
    return table(("measured sweeps", "method", *units), *lines)


def proximity_table(runs):
    """One line for each set."""
    got, meters = Results(runs, "measured-proximity"), ("auto", "phase_l1", "phase_dtw", "pinit_dtw")
    lines = [
        [f"{family}, {got.samples(family, 'auto', 'correct', 'share')} questions",
         *(got.text(family, meter, "correct", "share") for meter in meters),
         got.text(family, "auto", "correct_far", "share")]
        for family in dict.fromkeys(key[0] for key in got.found)
    ]  # fmt: skip
    heads = [f"`{meter}`, %: ours; pilot" for meter in meters]
    return table(("measured sweeps", *heads, "`auto`, gaps of 20 cm and more, %"), *lines)


def target_table(runs):
    """One line for each set, with sixteen references."""
    got, methods = Results(runs, "measured-target"), ("posterior", "comparisons", "consistency", "nearest three")
    lines = [
        [f"{family}, {got.samples(family, 16, 'posterior', 'error_m', 'median')} tags",
         *(got.pair(family, 16, method, "error_m") for method in methods),
         got.text(family, 16, "posterior", "held", "share")]
        for family in dict.fromkeys(key[0] for key in got.found)
    ]  # fmt: skip
    return table(("measured sweeps", *(f"{method}:" for method in methods), "90 % region holds, %"), *lines)


def comparisons_table(runs):
    """One line for each meter; a column for each sight and number of tracks."""
    got = Results(runs, "wrong-comparisons")
    places = dict.fromkeys(key[:2] for key in got.found)
    lines = [
        [f"`{meter}`", *(got.text(*place, meter, "wrong_00", "share", interval=False) for place in places),
         got.text("in sight", "two at right angles", meter, "wrong_10", "share", interval=False)]
        for meter in dict.fromkeys(key[2] for key in got.found)
    ]  # fmt: skip
    return table(("simulated", *(", ".join(place) + ":" for place in places), "in sight, two tracks, ε = 0.1:"), *lines)


def polarisation_table(runs):
    """One line for each kind of tag; wrong comparisons, and error of the images."""
    got = Results(runs, "tag-polarisation")
    tags, readers = (list(dict.fromkeys(key[i] for key in got.found)) for i in (0, 1))
    lines = [
        [tag, *(f"{got.text(tag, reader, 'wrong', 'share', interval=False)} · "
                f"{got.text(tag, reader, 'tag_error_m', 'median', interval=False)}" for reader in readers)]
        for tag in tags
    ]  # fmt: skip
    return table(("simulated; wrong % · error cm", *(f"{reader}:" for reader in readers)), *lines)


def fetches_table(runs):
    """One line for each sight, way and number of tags."""
    got = Results(runs, "fetches")
    columns = (("answered", "share"), ("found", "share"), ("centre_error_m", "median"), ("centre_error_m", "p90"),
               ("theta_error_rad", "median"), ("held", "share"), ("held_at_once", "share"), ("tries", "mean"),
               ("drive_s", "mean"), ("total_s", "median"))  # fmt: skip
    lines = [
        [sight, way, str(tags), *(got.text(sight, way, tags, *what) for what in columns)]
        for sight, way, tags in dict.fromkeys(key[:3] for key in got.found)
    ]
    heads = ("answers, %", "within 10 cm, %", "centre, median cm", "p90 cm", "orientation, median °", "in the hand, %",
             "at the first try, %", "tries, mean", "driving, mean s", "start to hand, median s")  # fmt: skip
    rooms = len(np.unique(got.rows.column("seed")))
    return table((f"simulated, {rooms} rooms", "way", "K", *heads), *lines)


def path_table(runs):
    """One line for each sight and way of finding the part."""
    got = Results(runs, "path-ratio")
    columns = (("reached", "share"), ("ratio", "mean"), ("ratio", "max10"), ("ratio_around", "mean"), ("drive_s", "mean"),
               ("total_s", "mean"))  # fmt: skip
    lines = [
        [sight, way, *(got.text(sight, way, *what) for what in columns)]
        for sight, way in dict.fromkeys(key[:2] for key in got.found)
    ]
    heads = ("in reach, %", "way over straight line, mean: ours; paper", "median of the largest of ten: ours; paper",
             "over the shortest way, mean", "driving, s", "with scans, s")  # fmt: skip
    rooms = len(np.unique(got.rows.column("seed")))
    return table((f"simulated, {rooms} rooms", "found by", *heads), *lines)


def fusebot_table(runs):
    """One line for each sight, band and number of heights."""
    got = Results(runs, "fusebot-localisation")
    lines = []
    for sight, band, heights in dict.fromkeys(key[:3] for key in got.found):
        cell = {"sight": sight, "band_mhz": band, "heights": heights}
        box = boxes_against_errors(got.rows, cell, np.random.default_rng(0))
        lines.append(
            [sight, f"{band:.0f} MHz", heights, got.text(sight, band, heights, "nearest_m", "median"),
             got.text(sight, band, heights, "nearest_m", "p90"),
             f"{box.rank_correlation:.2f} ({box.interval.low:.2f} … {box.interval.high:.2f})"]
        )  # fmt: skip
    heads = ("nearest point, median cm: ours; paper", "p90 cm: ours; paper", "rank correlation of box and error")
    return table(("simulated", "band", "heights", *heads), *lines)


def resolution_table(runs):
    """One line for each share of flips, arm and method."""
    got, after = Results(runs, "resolution"), (1, 3, 7, 10)
    lines = []
    for flips, arm in dict.fromkeys(key[:2] for key in got.found):
        for method in ("paper", "consistency", "posterior"):
            cells = [got.pair(flips, arm, f"{method}_centre_{count}_m") for count in after]
            angle = got.text(flips, arm, f"{method}_theta_7_rad", "median", interval=False)
            lines.append([f"{100 * flips:.0f} %", arm, method, *cells, angle])
    heads = [f"{count} stop{'s' if count > 1 else ''}:" for count in after]
    return table(("flipped", "layout, moves", "method", *heads, "θ, 7 stops, °:"), *lines)


def accuracy_table(runs):
    """One line for each sight, rig, method and number of stops; a column for each number of part tags."""
    got = Results(runs, "accuracy")
    lines = []
    for sight, rig in dict.fromkeys(key[:2] for key in got.found):
        methods = ("paper",) if rig.startswith("the paper's") else ("posterior", "comparisons", "consistency")
        for method in methods:
            for count in (1, 3) if method != "consistency" else (3,):
                cells = [
                    f"{got.pair(sight, rig, tags, f'{method}_centre_{count}_m')} · "
                    f"{got.text(sight, rig, tags, f'{method}_theta_{count}_rad', 'median', interval=False)}"
                    for tags in (1, 2, 3, 4)
                ]
                held = [got.text(sight, rig, tags, f"held_{count}", "share", interval=False) for tags in (1, 2, 3, 4)]
                lines.append(
                    [sight, rig, method, str(count), *cells, ", ".join(held) if method == "posterior" else "–"]
                )
    heads = (
        "simulated",
        "tracks",
        "method",
        "stops",
        "K = 1:",
        "K = 2:",
        "K = 3:",
        "K = 4:",
        "region holds, %, K = 1…4",
    )
    return table(heads, *lines)


def spread_table(runs):
    """Mean ± standard deviation after three stops, and whether a wide posterior means a large error."""
    got, lines = Results(runs, "accuracy"), []

    def both(key, column):
        return f"{got.text(*key, column, 'mean', interval=False)} ± {got.text(*key, column, 'sd', interval=False)}"

    for sight, rig, tags in dict.fromkeys(key[:3] for key in got.found):
        for method in ("posterior", "comparisons", "consistency", "paper"):
            key = (sight, rig, tags)
            if got.found[*key, f"{method}_centre_3_m", "mean"].value is None:
                continue
            cells = [both(key, f"{method}_{column}") for column in ("centre_3_m", "theta_3_rad")]
            lines.append(
                [sight, rig, str(tags), method, *cells, sharpness(got.rows, key) if method == "posterior" else "–"]
            )
    heads = ("centre, cm:", "θ, °:", "rank correlation of spread and error")
    return table(("simulated", "tracks", "K", "method", *heads), *lines)


def sharpness(rows, key):
    """Spearman's ρ between √ trace of the posterior's covariance and its error, after three stops."""
    cell = dict(zip(("sight", "rig", "tags"), key, strict=True))
    spread, error_m = picked(rows, "spread_3_m", **cell), picked(rows, "posterior_centre_3_m", **cell)
    found = box_against_error(spread, error_m, np.random.default_rng(0))
    return f"{found.rank_correlation:.2f} ({found.interval.low:.2f} … {found.interval.high:.2f})"


def write_pictures(runs):
    """Draw the figures that the page shows, and return them as Markdown by study."""
    shown = {}
    for name in ("accuracy", "resolution"):
        got, lines = Results(runs, name), []
        for number, (caption, figure) in enumerate(got.study.draws(got.rows).items(), start=1):
            file = DOCS / "images" / f"{name}_{number}.png"
            figure.savefig(file, dpi=72, metadata={"Software": None})
            lines.append(f"![{caption}](images/{file.name})")
        shown[name] = "\n\n".join(lines)
    return shown


def duration(seconds):
    """Three digits, with the unit that suits."""
    for unit, size in (("s", 1.0), ("ms", 1e-3), ("µs", 1e-6)):
        if seconds >= size or unit == "µs":
            value = seconds / size
            return f"{value:.{max(0, 2 - int(np.floor(np.log10(value))))}f} {unit}"


def grasp_trials_table(runs):
    """One line for each figure that the paper prints and each rule."""
    from write_grasp_trials import figure_table  # which imports this module

    return figure_table(runs)


VARIES = "Times of one machine vary by a factor of two from day to day: read the ratio."


def bench_table(runs):
    """One line for each timing."""
    timings = json.loads((runs / "bench.json").read_text(encoding="utf-8"))["timings"]
    lines = [
        [
            t["name"],
            duration(t["ours_s"]),
            f"{t['peer']}: {duration(t['peer_s'])}",
            f"{t['ratio']:,.{t['ratio'] < 10:d}f}",
        ]
        for t in timings
    ]
    return table(("computed on one thread", "ours:", "peer", "ratio:"), *lines)


def write_piles(runs):
    """Write the tables of the pages on piles."""
    from write_piles import write

    write(runs)


def pile_tables(which):
    """A table of the pages on piles, shown here as well."""

    def made(runs):
        import write_piles

        return getattr(write_piles, which)(runs)

    return made


def searched(got, arms=("fusebot_8", "xray", "ours_8")):
    """Shares found and mean actions of some arms."""
    found, actions = ([got.rows.column(f"{what}_{arm}").drop_null().to_numpy().mean() for arm in arms] for what in ("found", "all"))
    return f"{' / '.join(f'{100 * v:.0f}' for v in found)} %; {' / '.join(f'{v:.2f}' for v in actions)}"


def search_table(runs):
    """Tables 1 and 2 in one, all families together."""
    from write_search import main_table

    return main_table(Results(runs, "searches"))


SECTIONS = (
    ("**Where are the tags?** `measured-survey`: ours (95 % interval); our own unpublished pilot study on all public\n"
     "sweeps of the set, with one channel for `hyperbolic`.", survey_table),
    ("**Which of two tags is nearer?** `measured-proximity`: share of right answers (95 % interval); the pilot study.\n"
     "`pinit_dtw` is the papers' reading, literally; 50 % is a coin.", proximity_table),
    ("**One tag among sixteen at known places.** `measured-target`: median / 90 % quantile in cm of a tag's error, references\n"
     "from other sweeps; `nearest three` is the mean of the three that seem nearest. Our pilot study got 12 to 19 cm by\n"
     "counting comparisons and 6 to 7 cm with the nearest three. Our own target of 8 cm is missed on D4, whose references are 14 cm\n"
     "and more away; what was tried: [posterior](posterior.md).", target_table),
    ("**The same question by simulated radio.** `wrong-comparisons`: share of wrong answers in %, 40 rooms; our own pilot\n"
     "study on a kinder channel, where it has a figure (the papers print none). \"No walls\" is free space but for the robot\n"
     "itself.",
     comparisons_table),
    ("**Which tag for a lying leg, and which antenna?** `tag-polarisation`: near-field images over two tracks.",
     polarisation_table),
    ("**How fine do comparisons cut the plane?** `resolution`, simulated without a radio, six robot tags, K = 2: centre,\n"
     "median / 90 % quantile in cm. RF-Compass prints about 4 cm after one stop (Fig. 7), and 0.96 / 2.5 cm and 3.1° with\n"
     "10 % of the comparisons flipped (Fig. 8), without the number of moves.", resolution_table),
    ("**The part, hand over it, by simulated radio.** `accuracy`: centre median / 90 % in cm · θ median in °; the paper's\n"
     "figures (Fig. 12, 13, measured): K = 1 4.03, K = 2 2.76 · 5.77, K = 4 1.28 · 3.3. All methods know that the part is near\n"
     "the hand. The last column says how often the posterior's 90 % region held the pose.", accuracy_table),
    ("**The same after three stops, as means ± standard deviations.** The paper prints 1.8 cm as the standard deviation at\n"
     "K = 1. The rank correlation would be 1 if a wider posterior always had the larger error.", spread_table),
    ("**How many attempts does a hand need?** `grasp-trials`: mean attempts, or share of first attempts that hold in %, by three\n"
     "rules, with errors drawn from `accuracy` and from families with the paper's medians; the paper's figures (Fig. 14, 15,\n"
     "trace-driven, rule not printed). All hands, and how sure it is: [Grasp trials](grasp_trials.md).", grasp_trials_table),
    ("**A whole fetch by radio.** `fetches`: ours (95 % interval); the paper's measured medians (in sight). The paper's rig and\n"
     "estimator, end to end, rarely answer on this channel; `best` is ours. Tries and times are of runs that end with the part in the\n"
     "hand; most of the time is the antenna's way, at 0.2 m/s.", fetches_table),
    ("**How long is the way?** `path-ratio`: until the part is in reach, K = 2, furniture mapped, not solid; the paper's figures\n"
     "(Fig. 10, 11) are of ten measured runs. Motion capture looks under our chair; in the paper it found no hidden part.",
     path_table),
    ("**Tags from the wrist.** `fusebot-localisation`: ours (95 % interval); FuseBot's Table 5, both sights together, on a\n"
     "real robot. A rank correlation of 1 would mean that a larger box always has the larger error.", fusebot_table),
    ("**Tags in piles, from the arm.** `pile-tags`: error to the nearest point of the tag, median / 90 % quantile in cm (95 %\n"
     "interval); FuseBot's Table 5. What lies over a tag, and what that does: [Scanning a pile](pile_scan.md).",
     pile_tables("error_table")),
    ("**Where is the hidden target?** `map-quality`: log-loss in bits · mean rank of the true voxel in %. What tags save:\n"
     "[Posterior map](posterior_map.md).", pile_tables("maps_table")),
    ("**Who finds the hidden thing?** `searches`: every method on the same piles, executed grasps; FuseBot's Tables 1 to 3 are of\n"
     "real piles. What differs, and what the paper orders: [Searches beside the paper](search_studies.md).", search_table),
    ("**How fast?** `rfcompass bench`, ours and the peer's in one run.", bench_table),
)  # fmt: skip


def headlines(runs):
    """What a newcomer asks first, a line each, from the same runs."""
    accuracy, resolution, wrist = (Results(runs, name) for name in ("accuracy", "resolution", "fusebot-localisation"))
    grasps = Results(runs, "grasp-trials")
    fetches, way = (Results(runs, name) for name in ("fetches", "path-ratio"))
    piles, maps = Results(runs, "pile-tags"), Results(runs, "map-quality")
    survey, nearer, target = (Results(runs, f"measured-{name}") for name in ("survey", "proximity", "target"))

    def part(rig, method, column, *tags):
        texts = [accuracy.own("in sight", rig, k, f"{method}_{column}", "median") for k in tags]
        return " / ".join(texts)

    def both(got, *key):
        return " / ".join(got.own(*key, summary) for summary in ("median", "p90"))

    def attempts(source):
        return " / ".join(grasps.own(source, 2, opening_m, "tries_geometry", "mean") for opening_m in (0.075, 0.085))

    flipped = (0.1, "skew, sweep", "consistency_centre_7_m")
    lines = [
        ["part's centre, hand over it, K = 1 / 2 / 4, near tracks, three stops",
         f"{part('near L', 'posterior', 'centre_3_m', 1, 2, 4)} cm", "4.03 / 2.76 / 1.28 cm, measured", "simulated", "`accuracy`"],
        ["its orientation, K = 2 / 4", f"{part('near L', 'posterior', 'theta_3_rad', 2, 4)}°", "5.77 / 3.3°, measured",
         "simulated", "`accuracy`"],
        ["the same from far tracks", f"{part('far L', 'posterior', 'centre_3_m', 1, 2, 4)} cm", "–", "simulated", "`accuracy`"],
        ["the same with the paper's rig and estimator", f"{part(PAPERS_RIG, 'paper', 'centre_3_m', 1, 2, 4)} cm",
         "4.03 / 2.76 / 1.28 cm, measured", "simulated", "`accuracy`"],
        ["grasp attempts, hand of 7.5 / 8.5 cm, K = 2, mean, near tracks", attempts("ours, near tracks"), "9 / 5, its measured errors",
         "simulated", "`grasp-trials`"],
        ["the same from errors with the paper's medians", attempts("the paper's medians"), "9 / 5, its measured errors", "simulated",
         "`grasp-trials`"],
        ["the part in the hand by radio, within three tries, K = 2 / 4, in sight; hidden",
         "; ".join(" / ".join(fetches.own(sight, "best", k, "held", "share") for k in (2, 4)) for sight in ("in sight", "hidden"))
         + " %", "–", "simulated", "`fetches`"],
        ["way to the part over the straight line, mean / median of the largest of ten, in sight; hidden",
         "; ".join(" / ".join(way.own(sight, "best", "ratio", s) for s in ("mean", "max10")) for sight in ("in sight", "hidden")),
         "1.06 / 1.16; 1.05 / 1.12, measured", "simulated", "`path-ratio`"],
        ["10 % of comparisons flipped, seven stops, median / 90 %", f"{both(resolution, *flipped)} cm", "0.96 / 2.5 cm, simulated",
         "simulated", "`resolution`"],
        ["tag from the wrist, 200 MHz, two heights, in sight, median / 90 %",
         f"{both(wrist, 'in sight', 200.0, 'two', 'nearest_m')} cm", "3.6 / 6 cm, measured, hidden ones too", "simulated",
         "`fusebot-localisation`"],
        ["tag in a pile, from the arm, 25 things in three piles, median / 90 %",
         f"{both(piles, 'covered_3p25', 'two', 'nearest_m')} cm", "3.6 / 6 cm, measured", "simulated", "`pile-tags`"],
        ["bits still needed to say where the hidden target is, mean, three piles: cameras alone; the paper's map, 8 exact tags; posterior; the same with 8 tags",
         " / ".join(maps.own("covered_3p25", f"bits_{name}", "mean")
                    for name in ("c", "map_consistent_8_exact", "posterior_0", "posterior_8_exact")), "–", "simulated",
         "`map-quality`"],
        ["searches that find the hidden thing; mean actions, 16 where not: FuseBot, 8 tags; literal X-Ray; ours, 8 tags",
         searched(Results(runs, "searches")), "95 / 84 %, measured; means not printed", "simulated", "`searches`"],
        ["the same, 402 other piles: FuseBot, 8 tags; the stronger X-Ray; ours, 8 tags",
         searched(Results(runs, "search-confirm"), ("fusebot_8", "xray_views", "ours_8")), "means not printed", "simulated",
         "`search-confirm`"],
        ["20 to 42 things in two or three piles: FuseBot, 8 tags; literal X-Ray; ours, 8 tags", searched(Results(runs, "search-levels")),
         "means not printed", "simulated", "`search-levels`"],
        ["25 things in three piles: FuseBot, 0 / 9 tags on other things; ours, 0 / 9",
         searched(Results(runs, "search-tags"), ("fusebot_0", "fusebot_9", "ours_0", "ours_9")),
         "medians 4 / 2 actions, measured", "simulated", "`search-tags`"],
        ["tag from a rail of 1 m, in the plane, D1test / D2 / D4",
         " / ".join(survey.own(f, "hyperbolic", "plane_error_m", "median") for f in ("D1test", "D2", "D4")) + " cm",
         "–", "measured", "`measured-survey`"],
        ["which of two tags is nearer, D2 / D4", " / ".join(nearer.own(f, "auto", "correct", "share") for f in ("D2", "D4")) + " %",
         "–", "measured", "`measured-proximity`"],
        ["one tag among sixteen, D1test / D2 / D4",
         " / ".join(target.own(f, 16, "posterior", "error_m", "median") for f in ("D1test", "D2", "D4")) + " cm",
         "–", "measured", "`measured-target`"],
    ]  # fmt: skip
    return table(("question; medians unless said", "here", "paper", "data", "study"), *lines)


def write_grasp_trials(runs):
    """Write the tables of their own page."""
    from write_grasp_trials import write

    write(runs)


def write_search(runs):
    """Write the tables of the page on searches."""
    import write_orderings as orderings
    import write_search as main_study
    import write_search_studies as others

    main_study.write(runs)
    others.write(runs)
    orderings.write(runs)


def main(runs):
    """Replace what stands between the two markers of the README, and write the page of all tables."""
    parts = [f"{text}\n\n{make(runs)}" for text, make in SECTIONS]
    pictures = write_pictures(runs)
    shown = [f"## Pictures\n\n{pictures['accuracy']}\n\n{pictures['resolution']}"]
    PAGE.write_text("\n\n".join([HEAD.rstrip(), *parts, *shown]) + "\n", encoding="utf-8")
    text = README.read_text(encoding="utf-8")
    before, after = text.split(BEGIN)[0], text.split(END)[1]
    fast = f"<details><summary>How fast? <code>rfcompass bench</code>, ours and the peer's in one run</summary>\n\n{VARIES}\n\n{bench_table(runs)}"
    shown = f"{headlines(runs)}\n\n{fast}\n\n</details>"
    README.write_text(f"{before}{BEGIN}\n\n{shown}\n\n{END}{after}", encoding="utf-8")
    write_grasp_trials(runs)
    write_piles(runs)
    write_search(runs)


if __name__ == "__main__":
    main(Path(sys.argv[1]))
