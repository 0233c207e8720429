import numpy as np
import pytest

from rfcompass.errors import DuplicateEpc, ShapeError, TagNeverHeard
from rfcompass.rf.meters.pairing import compare_tags, mean_of_known, pairwise
from rfcompass.types.reads import Scan

POINTS_M = np.array([[0.1, 0.7, 0.0], [0.3, 0.7, 0.0], [0.6, 0.7, 0.0]])


def numbered(traces):
    """A distance that tells which pair it belongs to: 12 for e1 and e2."""
    numbers = [int(trace.epc[1:]) for trace in traces]
    return pairwise(len(traces), lambda i, j: float(10 * numbers[i] + numbers[j]))


def test_targets_stand_in_rows_and_anchors_in_columns(make_scan):
    found = compare_tags("toy", numbered, make_scan(POINTS_M), ["e2"], ["e1", "e0"])
    assert found.kind == "toy"
    assert found.m.tolist() == [[12.0, 2.0]]
    np.testing.assert_array_equal(found.anchor_m, [[np.nan, 1.0], [1.0, np.nan]])


def test_all_other_tags_are_anchors_unless_told_otherwise(make_scan):
    found = compare_tags("toy", numbered, make_scan(POINTS_M), ["e1"], None)
    assert found.anchor_epcs == ("e0", "e2")


def test_a_tag_that_was_not_heard_has_no_proximity(make_scan):
    found = compare_tags("toy", numbered, make_scan(POINTS_M), ["e1", "gone"], ["e0", "lost", "e2"])
    np.testing.assert_array_equal(found.m, [[1.0, np.nan, 12.0], [np.nan, np.nan, np.nan]])
    assert np.isnan(found.anchor_m[1]).all()


def test_two_lost_tags_are_not_near_each_other(make_scan):
    found = compare_tags("toy", numbered, make_scan(POINTS_M), ["gone"], ["lost", "e0"])
    assert np.isnan(found.m).all()
    assert np.isnan(found.anchor_m).all()


def test_a_tag_has_no_proximity_to_itself(make_scan):
    found = compare_tags("toy", numbered, make_scan(POINTS_M), ["e1"], ["e0", "e1"])
    np.testing.assert_array_equal(found.m, [[1.0, np.nan]])


@pytest.mark.parametrize(("targets", "anchors"), [(["a", "b"], ["c"]), (["a"], []), ([], ["a"])])
def test_if_none_was_heard_there_is_no_answer(make_scan, targets, anchors):
    with pytest.raises(TagNeverHeard, match="heard: e0, e1, e2") as caught:
        compare_tags("toy", numbered, make_scan(POINTS_M), targets, anchors)
    assert caught.value.numbers["asked"] == [*targets, *anchors]


def test_an_empty_scan_is_no_answer():
    with pytest.raises(TagNeverHeard, match="none"):
        compare_tags("toy", numbered, Scan(), [], None)


@pytest.mark.parametrize(("targets", "anchors"), [(["e1", "e1"], ["e0"]), (["e1"], ["e0", "e0"])])
def test_asking_twice_for_a_tag_is_refused(make_scan, targets, anchors):
    with pytest.raises(DuplicateEpc):
        compare_tags("toy", numbered, make_scan(POINTS_M), targets, anchors)


def test_reads_of_different_antenna_paths_do_not_compare(make_trace, line):
    one = make_trace(POINTS_M[0], epc="e0")
    other = make_trace(POINTS_M[1], line() + np.array([0.1, 0.0, 0.0]), epc="e1")
    with pytest.raises(ShapeError, match="antenna_positions_m"):
        compare_tags("toy", numbered, Scan({"e0": one, "e1": other}), [], None)


def test_the_mean_leaves_out_what_is_missing():
    found = mean_of_known([np.array([[0.0, np.nan]]), np.array([[2.0, np.nan]]), np.array([[np.nan, np.nan]])])
    np.testing.assert_array_equal(found, [[1.0, np.nan]])
