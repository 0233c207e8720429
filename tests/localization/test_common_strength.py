"""Tags of one scan are located better together than alone, and one odd tag does not lead the others astray."""

import logging
from dataclasses import replace

import numpy as np
import pytest
from survey_scenes import FREQUENCIES_HZ, RAIL_M, reads_of

from rfcompass.errors import TooFewReads
from rfcompass.localization import HyperbolicSurveyor, survey
from rfcompass.localization.common_strength import SharedStrength
from rfcompass.rf import wavenumber
from rfcompass.types import ReadTrace, Scan, SearchVolume

ALONE = HyperbolicSurveyor(shared=None)
PLANE = SearchVolume([-0.3, 0.2, 0.0], [1.3, 1.5, 0.0])
PLACES_M = {
    "a": np.array([0.2, 0.55, 0.0]),
    "b": np.array([0.4, 0.9, 0.0]),
    "c": np.array([0.6, 0.7, 0.0]),
    "d": np.array([0.8, 0.8, 0.0]),
}


def echoing(epc, tag_m, echo, gain_db=0.0):
    """A tag before a wall at y = 2 m and above a floor 0.8 m below."""
    wall_m, floor_m = tag_m * [1, -1, 1] + [0.0, 4.0, 0.0], tag_m * [1, 1, -1] + [0.0, 0.0, -1.6]
    field = sum(c * one_way(place_m) for c, place_m in ((1.0, tag_m), (echo, wall_m), (-echo, floor_m)))
    h = 10 ** (gain_db / 20) * field**2
    counts = np.ones(h.shape, dtype=np.int64)
    return ReadTrace(epc, RAIL_M, FREQUENCIES_HZ, h, counts, np.ones(len(RAIL_M), dtype=np.int64))


def one_way(point_m):
    r = np.linalg.norm(point_m - RAIL_M, axis=1)[:, None]
    return np.exp(-1j * wavenumber(FREQUENCIES_HZ) * r) / r


def scan_of(places_m, echo=0.0, gains_db=None):
    gains_db = gains_db or {}
    return Scan({e: echoing(e, p, echo, gains_db.get(e, 0.0)) for e, p in places_m.items()}, "rail", 2)


def errors_m(places_m, fixes):
    return np.array([np.linalg.norm(fix.point_m - places_m[fix.epc]) for fix in fixes])


def test_in_free_space_equal_tags_are_where_they_are():
    assert errors_m(PLACES_M, survey(scan_of(PLACES_M))).max() < 2e-3


@pytest.mark.slow
def test_with_echoes_tags_at_unlike_distances_are_located_better_together():
    """Seeds 0 to 19, not used for anything else. Both the median and the tail must be better."""
    alone, together = [], []
    for seed in range(20):
        rng = np.random.default_rng(seed)
        places = {str(i): np.array([*rng.uniform([0.1, 0.45], [0.9, 1.1]), 0.0]) for i in range(5)}
        scan = scan_of(places, echo=-0.4)
        alone += list(errors_m(places, survey(scan, ALONE)))
        together += list(errors_m(places, survey(scan)))
    assert np.median(together) < np.median(alone)
    assert np.percentile(together, 90) < np.percentile(alone, 90)


def test_a_reader_with_more_power_changes_nothing():
    scan = scan_of(PLACES_M, echo=-0.3)
    louder = Scan({e: replace(t, channel=100.0 * t.channel) for e, t in scan.traces.items()}, "rail", 2)
    gaps = [np.linalg.norm(a.point_m - b.point_m) for a, b in zip(survey(scan), survey(louder), strict=True)]
    assert max(gaps) < 2e-3


def test_what_a_tag_is_called_and_which_tags_are_asked_for_changes_nothing():
    scan = scan_of(PLACES_M, echo=-0.3)
    all_fixes = {fix.epc: fix for fix in survey(scan)}
    assert np.array_equal(survey(scan, epcs=["c"])[0].point_m, all_fixes["c"].point_m)
    names = dict(zip("abcd", "wqzr", strict=True))
    renamed = Scan({names[e]: replace(t, epc=names[e]) for e, t in scan.traces.items()}, "rail", 2)
    for fix in survey(renamed):
        old = next(e for e, new in names.items() if new == fix.epc)
        assert np.linalg.norm(fix.point_m - all_fixes[old].point_m) < 2e-3


def test_a_tag_of_another_kind_does_not_move_the_others():
    """Its pull is bounded: 12 dB are 8 spreads, but count as a residual that grows linearly."""
    fixes = survey(scan_of(PLACES_M, gains_db={"b": -12.0}))
    assert errors_m(PLACES_M, [fix for fix in fixes if fix.epc != "b"]).max() < 0.01


def test_two_tags_are_fitted_each_on_its_own():
    scan = scan_of({e: PLACES_M[e] for e in "ab"}, echo=-0.3, gains_db={"a": 5.0})
    for fix, alone in zip(survey(scan), survey(scan, ALONE), strict=True):
        assert np.array_equal(fix.point_m, alone.point_m)


def test_with_two_allowed_unlike_tags_do_pull_each_other():
    scan = scan_of({e: PLACES_M[e] for e in "ab"}, echo=-0.3, gains_db={"a": 5.0})
    pair = survey(scan, HyperbolicSurveyor(shared=SharedStrength(least_tags=2)))
    assert any(not np.array_equal(f.point_m, g.point_m) for f, g in zip(pair, survey(scan, ALONE), strict=True))


def test_a_surveyor_asked_for_one_tag_knows_of_no_other():
    scan = scan_of(PLACES_M, echo=-0.3)
    volume = PLANE
    one = HyperbolicSurveyor().locate(scan.trace("a"), volume)
    assert np.array_equal(one.point_m, survey(scan, ALONE, volume, epcs=["a"])[0].point_m)


def test_a_tag_with_too_few_reads_is_left_out_of_the_scan_and_of_the_strength(caplog):
    scan = scan_of(PLACES_M, echo=-0.3)
    short = replace(reads_of(PLACES_M["b"], RAIL_M[:2]), epc="e")
    with_short = Scan({**scan.traces, "e": short}, "rail", 2)
    with caplog.at_level(logging.WARNING):
        fixes = survey(with_short, search=PLANE)
    assert "left out" in caplog.text
    for fix, other in zip(fixes, survey(scan, search=PLANE), strict=True):
        assert np.array_equal(fix.point_m, other.point_m)
    assert survey(with_short, search=PLANE, epcs=["a"])[0].epc == "a"
    with pytest.raises(TooFewReads):
        survey(with_short, search=PLANE, epcs=["a", "e"])
