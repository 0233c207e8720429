"""Every tag that is asked for gets a place or a reason."""

import pickle
from dataclasses import replace

import numpy as np
import pytest
from survey_scenes import wrist_reads

from rfcompass.errors import TagNeverHeard, TooFewReads
from rfcompass.localization import WRIST_SAR, LocatedTags, locate_all
from rfcompass.types import Scan, SearchVolume

TABLE = SearchVolume([-0.3, -0.3, 0.0], [0.3, 0.3, 0.2])
PLACES_M = {"a": [0.1, 0.1, 0.03], "b": [-0.15, 0.05, 0.1], "c": [0.0, -0.2, 0.05]}


def scan_of(places_m):
    return Scan({epc: replace(wrist_reads(place), epc=epc) for epc, place in places_m.items()})


def faint(trace):
    """Heard at three positions of one channel only."""
    counts = np.zeros_like(trace.read_counts)
    counts[:3, 0] = 1
    return replace(trace, channel=trace.channel * counts, read_counts=counts)


def test_each_tag_is_located_from_its_own_reads():
    found = locate_all(scan_of(PLACES_M), TABLE)
    assert not found.refusals
    for epc, place in PLACES_M.items():
        assert found.fixes[epc].epc == epc
        assert np.linalg.norm(found.fixes[epc].point_m - place) < 0.003
        alone = locate_all(scan_of({epc: place}), TABLE).fixes[epc]
        np.testing.assert_array_equal(alone.point_m, found.fixes[epc].point_m)


def test_a_tag_that_cannot_be_located_says_why_and_leaves_the_others_alone():
    scan = scan_of(PLACES_M)
    traces = {**scan.traces, "b": faint(scan.trace("b"))}
    found = locate_all(Scan(traces), TABLE, epcs=["c", "b", "gone"])
    assert list(found.fixes) == ["c"]
    assert isinstance(found.refusals["b"], TooFewReads)
    assert found.refusals["b"].numbers["epc"] == "b"
    assert isinstance(found.refusals["gone"], TagNeverHeard)
    assert set(found.fixes) | set(found.refusals) == {"c", "b", "gone"}


def test_fixes_that_are_not_confident_come_with_advice():
    found = locate_all(scan_of(PLACES_M), TABLE, surveyor=replace(WRIST_SAR, max_box_m=(0.2, 0.2, 0.01)))
    assert found.confident == ()
    assert set(found.advice) == set(PLACES_M)
    loose = locate_all(scan_of(PLACES_M), TABLE, surveyor=replace(WRIST_SAR, max_box_m=(1.0, 1.0, 1.0)))
    assert len(loose.confident) == 3
    assert not loose.advice


def test_without_a_volume_it_looks_below_the_path():
    found = locate_all(scan_of(PLACES_M))
    assert np.linalg.norm(found.fixes["a"].point_m - PLACES_M["a"]) < 0.003


def test_silence_is_no_answer_or_a_reason_for_each():
    with pytest.raises(TagNeverHeard):
        locate_all(Scan())
    found = locate_all(Scan(), epcs=["a"])
    assert isinstance(found.refusals["a"], TagNeverHeard)


def test_the_answer_survives_a_trip_between_processes():
    found = locate_all(scan_of(PLACES_M), TABLE, epcs=["a", "gone"])
    again = pickle.loads(pickle.dumps(found))
    assert isinstance(again, LocatedTags)
    assert again.refusals["gone"].numbers == found.refusals["gone"].numbers
    np.testing.assert_array_equal(again.fixes["a"].point_m, found.fixes["a"].point_m)
