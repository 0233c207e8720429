"""Ways to locate one tag among sixteen at known places on measured sweeps, beside the posterior of `measured-target`.

Each target is located with references from other sweeps of its set, drawn five times. What a way has to learn, it
learns from the sixteen references of the very question; which ways to try and their constants were settled on D1train,
D1test, D2 and D3, and D4 was looked at afterwards. Prints, for each set: median (95 % interval over tags) and 90 % of
the error, range of the median over the draws, share of targets whose 90 % region holds the tape's place; for pairs of
tags of different sweeps how their errors in range correlate; and how levels spread within a sweep.

Run `RFCOMPASS_MEASURED_DATA=... python -m benchmarks.measured_tries`; about five minutes.
"""

import argparse
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from functools import cache, partial
from typing import NamedTuple

import numpy as np
from scipy.optimize import isotonic_regression, nnls

from benchmarks.common_phase import corrected_fixes
from benchmarks.reference_field import Guess, field_log_density, judged, near_references, squares, stacked
from rfcompass.arrays import FloatArray
from rfcompass.errors import NoAnswer
from rfcompass.evaluation.statistics import bootstrap_interval
from rfcompass.localization import PosteriorLocalizer, survey
from rfcompass.localization.tag_strength import tag_strength
from rfcompass.recordings import open_trace
from rfcompass.rf import meter
from rfcompass.studies.measured import data_folder, sweeps, tape_positions
from rfcompass.studies.measured_target import APART_M, FAMILIES, Surveyed, _answer, _observation
from rfcompass.types.reads import ReadTrace, Scan

DEVELOPMENT, REPORT = ("D1train", "D1test", "D2", "D3"), ("D4",)
DRAWS, REFERENCES = 5, 16
METERS = ("phase_l1", "phase_dtw", "rssi")
NOISE_M, NOISE_DB = 0.05, 1.0  # units in which fixes and levels are handed to the field
POWER = 0.5  # of the likelihood of a learnt distance, as for comparisons
BANDS_M = ((0.03, 0.06), (0.06, 0.10), (0.10, 0.15), (0.15, 0.20))


class Tag(NamedTuple):
    """One tag of one sweep."""

    sweep: str
    number: int
    tape_m: FloatArray
    found_m: FloatArray
    trace: ReadTrace

    @property
    def level_db(self) -> float:
        """Mean level over the path, not corrected for distance [dB]."""
        return float(20.0 * np.log10(np.abs(self.trace.channel).sum() / self.trace.mask.sum()))


Way = Callable[[str, Tag, Sequence[Tag]], Guess | None]


@cache
def tags_of(family: str) -> tuple[Tag, ...]:
    """All tags of a set that have a taped place, each located in its own sweep."""
    found: list[Tag] = []
    for name in sweeps(family):
        scan, taped = open_trace(data_folder() / "traces" / name).scan(), tape_positions(name)
        for fix in survey(scan):
            if fix.epc in taped:
                trace = scan.trace(fix.epc)
                found.append(Tag(name, len(found), taped[fix.epc][:2], fix.point_m[:2], trace))
    return tuple(found)


def questions(family: str) -> Iterator[tuple[Tag, list[Tag]]]:
    """Each target with its references, all draws of one target after each other."""
    for target in tags_of(family):
        far = [
            tag
            for tag in tags_of(family)
            if tag.sweep != target.sweep and np.linalg.norm(tag.tape_m - target.tape_m) >= APART_M
        ]
        for draw in range(DRAWS):
            order = np.random.default_rng([target.number, draw]).permutation(len(far))
            yield target, [far[i] for i in order[:REFERENCES]]


@cache
def proximities(family: str, kind: str) -> FloatArray:
    """What a meter says of all pairs of tags of a set, with every sweep laid onto the positions of the first."""
    first = tags_of(family)[0].trace
    moved = {}
    for tag in tags_of(family):
        gaps_m = np.abs(first.antenna_positions_m[:, None, 0] - tag.trace.antenna_positions_m[None, :, 0])
        rows, epc = gaps_m.argmin(axis=1), f"{tag.number:04d}"
        columns = np.abs(tag.trace.frequencies_hz[None] - first.frequencies_hz[:, None]).argmin(axis=1)
        cells = np.ix_(rows, columns)
        moved[epc] = replace(first, epc=epc, channel=tag.trace.channel[cells], read_counts=tag.trace.read_counts[cells])
    return np.array(meter(kind).measure(Scan(traces=moved, dimensions=2), anchors=sorted(moved)).anchor_m)


def posterior(family: str, target: Tag, references: Sequence[Tag]) -> Guess | None:
    """The library's, as in `measured-target`."""
    del family
    found = _answer("posterior", Surveyed(*target[2:4]), [Surveyed(*tag[2:4]) for tag in references])
    return None if found is None else Guess(found.place_m, found.held)


def posterior_within(family: str, target: Tag, references: Sequence[Tag]) -> Guess | None:
    """The library's, with a prior that the target is among its references."""
    del family
    tape_m, m = _places(references), np.linalg.norm(_fixes(references) - target.found_m, axis=1)
    bounds_m = np.column_stack([tape_m.min(axis=0) - 0.5, tape_m.max(axis=0) + 0.5])
    stop = _observation([Surveyed(*tag[2:4]) for tag in references], tape_m, m)
    try:
        samples_m = PosteriorLocalizer(bounds_m=bounds_m).infer([stop]).posterior.samples(3000)[:, :2]
    except NoAnswer:
        return None
    kept = samples_m[near_references(tape_m, samples_m)]
    return Guess(kept.mean(axis=0), None) if len(kept) else None


def learnt(family: str, target: Tag, references: Sequence[Tag], kinds: Sequence[str]) -> Guess:
    """A relation from m to distance with its spread, from the references' own pairs; then a Student likelihood."""
    tape_m, own = _places(references), [tag.number for tag in references]
    a, b = np.triu_indices(len(own), 1)
    d = np.linalg.norm(tape_m[a] - tape_m[b], axis=1)
    every = [_pairs(family, kind) for kind in kinds]
    known = [m[np.ix_(own, own)][a, b] for m in every]
    asked = [m[target.number, own] for m in every]
    fitted, told = _monotone(known[0], d, asked[0]) if len(kinds) == 1 else _summed(known, d, asked)
    off = np.abs(d - fitted)
    spread2 = (0.74 * np.median(off)) ** 2 + (np.median(off / np.maximum(d, 0.05)) * told) ** 2
    grid_m = squares(tape_m)
    away = np.linalg.norm(grid_m[:, None] - tape_m[None], axis=2)
    density = POWER * (-2.5 * np.log1p((told - away) ** 2 / (4.0 * spread2)) - 0.5 * np.log(spread2)).sum(axis=1)
    return _within(tape_m, grid_m, density, target)


def _monotone(known: FloatArray, d: FloatArray, asked: FloatArray) -> tuple[FloatArray, FloatArray]:
    order = np.argsort(known, kind="stable")
    rising = isotonic_regression(d[order]).x
    return np.interp(known, known[order], rising), np.interp(asked, known[order], rising)


def _summed(known: Sequence[FloatArray], d: FloatArray, asked: Sequence[FloatArray]) -> tuple[FloatArray, FloatArray]:
    """Sum of the meters, none with a negative weight."""
    X, asked_x = (np.column_stack([*columns, np.ones(len(columns[0]))]) for columns in (known, asked))
    weight, _ = nnls(X, d)
    return X @ weight, asked_x @ weight


def _pairs(family: str, kind: str) -> FloatArray:
    found_m = _fixes(tags_of(family))
    if kind == "fixes":
        return np.asarray(np.linalg.norm(found_m[:, None] - found_m[None], axis=2))
    return np.sqrt(proximities(family, kind))


def field(family: str, target: Tag, references: Sequence[Tag], levels: bool, within: bool) -> Guess:
    """The field of `reference_field` over fixes, or over fixes and levels."""
    del family
    tape_m = _places(references)
    grid_m = squares(tape_m)
    strength = tag_strength(target.trace)

    def physics(points_m: FloatArray) -> FloatArray:
        ways2 = np.sum((points_m[:, None] - strength.rx_m[None, :, :2]) ** 2, axis=2)
        levels_db = [-20.0 * np.log10(ways2.mean(axis=1)) / NOISE_DB] if levels else []
        return stacked([points_m / NOISE_M, *levels_db])

    def seen(tag: Tag) -> list[float]:
        return [*(tag.found_m / NOISE_M), *([tag.level_db / NOISE_DB] if levels else [])]

    density = field_log_density(
        np.array(seen(target)), np.array([seen(tag) for tag in references]), tape_m, grid_m, physics
    )
    return _within(tape_m, grid_m, density, target) if within else judged(grid_m, density, target.tape_m)


def _within(tape_m: FloatArray, grid_m: FloatArray, density: FloatArray, target: Tag) -> Guess:
    return judged(grid_m, np.where(near_references(tape_m, grid_m), density, -np.inf), target.tape_m)


def alone(family: str, target: Tag, references: Sequence[Tag]) -> Guess:
    """The fix of the target's own sweep; references are not asked."""
    del family, references
    return Guess(target.found_m, None)


def _places(tags: Sequence[Tag]) -> FloatArray:
    return np.array([tag.tape_m for tag in tags])


def _fixes(tags: Sequence[Tag]) -> FloatArray:
    return np.array([tag.found_m for tag in tags])


WAYS: dict[str, Way] = {
    "posterior": posterior,
    "the target's own fix": alone,
    "monotone relation, fixes": partial(learnt, kinds=("fixes",)),
    "monotone relation, phase_l1": partial(learnt, kinds=("phase_l1",)),
    "sum of meters": partial(learnt, kinds=METERS),
    "sum of meters and fixes": partial(learnt, kinds=(*METERS, "fixes")),
    "field of errors": partial(field, levels=False, within=False),
    "field of errors, among references": partial(field, levels=False, within=True),
    "field of errors and levels, among references": partial(field, levels=True, within=True),
    "posterior, among references": posterior_within,
}


COMMON = "own fix, common phases taken out"


def errors_of(guesses: Sequence[tuple[Tag, Guess | None]]) -> FloatArray:
    """Error of each guess [m], NaN without one."""
    return np.array([np.nan if g is None else np.linalg.norm(g.place_m - tag.tape_m) for tag, g in guesses])


def line(guesses: Sequence[tuple[Tag, Guess | None]]) -> str:
    """Median / 90 % of the error, 95 % interval of the median over tags, its range over draws, and coverage."""
    errors_m, number = errors_of(guesses), np.array([tag.number for tag, _ in guesses])
    known = np.isfinite(errors_m)
    within = bootstrap_interval(errors_m[known], "median", np.random.default_rng(0), clusters=number[known])
    held = [g.held for _, g in guesses if g is not None and g.held is not None]
    each = 100.0 * np.nanmedian(errors_m.reshape(-1, DRAWS), axis=0)
    median, late = np.percentile(100.0 * errors_m[known], [50, 90])
    return (
        f"{median:.1f} ({100 * within.low:.1f} … {100 * within.high:.1f}) / {late:.1f} cm, draws {each.min():.1f} to "
        f"{each.max():.1f}, holds {np.mean(held) if held else np.nan:.2f}, {np.mean(~known):.0%} without answer"
    )


def corrected(family: str) -> str:
    """Median / 90 % of fixes once the phases that references have in common are taken out."""
    errors_m: list[float] = []
    for name in sweeps(family):
        own = [tag for tag in tags_of(family) if tag.sweep == name]
        others = [tag for tag in tags_of(family) if tag.sweep != name]
        for draw in range(DRAWS):
            order = np.random.default_rng([len(errors_m), draw]).permutation(len(others))[:REFERENCES]
            learnt_from = [(others[i].trace, others[i].tape_m) for i in order]
            places_m = corrected_fixes([(tag.trace, tag.found_m) for tag in own], learnt_from)
            errors_m += [float(np.linalg.norm(p - tag.tape_m)) for p, tag in zip(places_m, own, strict=True)]
    median, late = 100.0 * np.percentile(errors_m, [50, 90])
    return f"{median:.1f} / {late:.1f} cm"


def correlations(family: str) -> str:
    """Correlation of errors in range of tags of different sweeps, by their distance."""
    tags = tags_of(family)
    tape_m, y_m = _places(tags), np.clip(_fixes(tags) - _places(tags), -0.3, 0.3)[:, 1]
    away_m = np.linalg.norm(tape_m[:, None] - tape_m[None], axis=2)
    sweep = np.array([tag.sweep for tag in tags])
    product = np.outer(y_m - y_m.mean(), y_m - y_m.mean()) / y_m.var()
    out = []
    for low_m, high_m in BANDS_M:
        pairs = (sweep[:, None] != sweep[None]) & (away_m >= low_m) & (away_m < high_m)
        out.append(f"{100 * low_m:.0f} to {100 * high_m:.0f} cm {product[pairs].mean():.2f}" if pairs.any() else "")
    return ", ".join(text for text in out if text)


def levels(family: str) -> str:
    """How far levels spread within a row once corrected for distance, and how they fall with it."""
    tags = tags_of(family)
    found_db = np.array([tag_strength(tag.trace).at(np.array([*tag.tape_m, 0.0])) for tag in tags])
    decades = np.log10(_places(tags)[:, 1])
    rows = [np.std(found_db[[tag.sweep == name for tag in tags]]) for name in sweeps(family)]
    rise_db = float(np.polyfit(decades, found_db, 1)[0])  # above the fall of 40 dB that is corrected for
    return f"levels spread by {np.median(rows):.1f} dB within a sweep and fall by {40.0 - rise_db:.0f} dB for a decade"


def main(argv: Sequence[str] | None = None) -> int:
    """Print all sets, the one that was kept back last."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--ways", nargs="+", choices=(*WAYS, COMMON), default=(*WAYS, COMMON))
    chosen = parser.parse_args(argv)
    every: dict[str, list[FloatArray]] = {}
    for family in (*DEVELOPMENT, *REPORT):
        asked = list(questions(family))
        print(f"{family}: {len(tags_of(family))} tags; errors in range correlate {correlations(family)}")
        print(f"  {levels(family)}")
        for name in (name for name in WAYS if name in chosen.ways):
            guesses = [(target, WAYS[name](family, target, references)) for target, references in asked]
            print(f"  {name}: {line(guesses)}", flush=True)
            if family in FAMILIES:
                every.setdefault(name, []).append(errors_of(guesses))
        if COMMON in chosen.ways:
            print(f"  {COMMON}: {corrected(family)}", flush=True)
    for name, errors_m in every.items():
        print(f"all of {', '.join(FAMILIES)}, {name}: {100 * np.nanmedian(np.concatenate(errors_m)):.1f} cm")
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
