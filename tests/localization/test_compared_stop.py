"""A stop knows its anchors and its comparisons, and refuses those that cannot be."""

import numpy as np
import pytest
from compared_scenes import leg_points, random_observations, random_stops

from rfcompass.errors import DegenerateAnchors, InputError, TagNeverHeard
from rfcompass.geometry import Pose2
from rfcompass.localization.compared_stop import ComparedStop, compared_stops
from rfcompass.types import Comparisons, Observation, ProximityMatrix

ANCHORS_M = np.array([[0.1, 0.0, 0.2], [0.0, 0.1, 0.0], [-0.1, 0.0, 0.1]])


def one(target=0, nearer=0, farther=1):
    return Comparisons([target], [nearer], [farther], [np.nan])


@pytest.mark.parametrize("wrong", [one(target=4), one(nearer=3), one(farther=3)])
def test_an_index_out_of_range_names_its_comparison(wrong):
    with pytest.raises(InputError, match="comparison 0"):
        ComparedStop(ANCHORS_M, leg_points(4), wrong)


@pytest.mark.parametrize("anchors_m", [ANCHORS_M[:1], np.tile(ANCHORS_M[0], (5, 1)), np.zeros((0, 3))])
def test_anchors_that_tell_no_places_apart_are_refused(anchors_m):
    with pytest.raises(DegenerateAnchors):
        ComparedStop(anchors_m, leg_points(4), one())


def test_the_true_pose_meets_every_exact_comparison():
    for seed in range(20):
        stops, truth = random_stops(np.random.default_rng(seed))
        assert all(stop.satisfied(truth, 0.0).all() for stop in stops)
        turned = Pose2(truth.x_m, truth.y_m, truth.theta_rad + np.pi)
        assert not all(stop.satisfied(turned, 0.0).all() for stop in stops)


def test_tolerance_is_a_difference_of_distances():
    stop = ComparedStop([[0.0, 0, 0], [0.2, 0, 0]], leg_points(1, 0.0), one())
    beyond = Pose2(0.1 + 0.004, 0.0, 0.0)
    assert not stop.satisfied(beyond, 0.0079).any()
    assert stop.satisfied(beyond, 0.0081).all()


def test_tags_are_found_by_their_epc():
    (stop,), _ = random_observations(np.random.default_rng(1), S=1)
    matrix = stop.proximity
    rows, columns = [2, 0, 3, 1], np.random.default_rng(2).permutation(9)
    shuffled = ProximityMatrix(
        tuple(matrix.target_epcs[k] for k in rows), tuple(matrix.anchor_epcs[i] for i in columns),
        matrix.m[np.ix_(rows, columns)], matrix.anchor_m[np.ix_(columns, columns)], matrix.kind,
    )  # fmt: skip
    again = Observation(0, stop.anchors, stop.part, stop.part_tag_heights_m, proximity=shuffled)
    (a,), (b,) = compared_stops([stop]), compared_stops([again])
    assert np.array_equal(a.comparisons.nearer, b.comparisons.nearer)
    assert np.array_equal(a.comparisons.margin, b.comparisons.margin)


def test_a_tag_that_the_matrix_lacks_abstains():
    (stop,), _ = random_observations(np.random.default_rng(1), S=1)
    matrix = stop.proximity
    fewer = ProximityMatrix(
        matrix.target_epcs[1:], matrix.anchor_epcs[:-1], matrix.m[1:, :-1], matrix.anchor_m[:-1, :-1], "x"
    )
    (heard,) = compared_stops([Observation(0, stop.anchors, stop.part, stop.part_tag_heights_m, proximity=fewer)])
    assert len(heard.comparisons) == 3 * 8 * 7 // 2
    assert heard.comparisons.abstained == 4 * 36 - len(heard.comparisons)
    assert heard.comparisons.target.min() == 1


def test_stops_are_placed_in_the_newest_base_frame():
    observations, _ = random_observations(np.random.default_rng(3))
    world = Pose2(3.0, -2.0, 1.0)
    moved = [
        Observation(
            stop.stop_id, stop.anchors, stop.part, stop.part_tag_heights_m,
            proximity=stop.proximity, base_pose=world @ stop.base_pose,
        )
        for stop in observations
    ]  # fmt: skip
    for a, b in zip(compared_stops(observations), compared_stops(moved), strict=True):
        assert np.allclose(a.anchors_newest_m, b.anchors_newest_m)


class _Meter:
    kind = "counting"

    def __init__(self, matrix):
        self.matrix = matrix

    def measure(self, scan, *, targets=(), anchors=None):
        assert targets == self.matrix.target_epcs
        assert anchors == self.matrix.anchor_epcs
        return self.matrix


def test_a_meter_is_asked_only_where_proximities_are_missing():
    (stop,), _ = random_observations(np.random.default_rng(1), S=1)
    silent = Observation(0, stop.anchors, stop.part, stop.part_tag_heights_m)
    with pytest.raises(TagNeverHeard):  # there is always `auto`, but nothing was heard
        compared_stops([silent])
    (measured,) = compared_stops([silent], _Meter(stop.proximity))
    (given,) = compared_stops([stop], None)
    assert np.array_equal(measured.comparisons.nearer, given.comparisons.nearer)


def test_stops_of_two_parts_are_refused():
    (stop,), _ = random_observations(np.random.default_rng(1), S=1)
    other = type(stop.part)("other", *[getattr(stop.part, name) for name in stop.part.__slots__[1:]])
    with pytest.raises(InputError, match="different parts"):
        compared_stops([stop, Observation(1, stop.anchors, other, stop.part_tag_heights_m, proximity=stop.proximity)])
