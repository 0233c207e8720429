"""What was heard, as tables: each anchor once, each tag once, and nothing twice."""

from dataclasses import replace

import numpy as np
import pytest
from calibrated_scenes import biased_stops

from rfcompass.localization.noise_model import NoiseModel
from rfcompass.localization.part_evidence import comparison_evidence, distance_evidence
from rfcompass.localization.placed_stop import OdometrySpread, PlacedComparisons, place_stops
from rfcompass.types import Comparisons

NOISE = NoiseModel(scale=2.0, alpha_m=0.02, beta=0.1, bias_m=0.015, comparison_m=0.03, lapse=0.04, pairs=36)
KINDS = {"sar_nearfield": NOISE}


def evidence(seed=0, **scene):
    return distance_evidence(place_stops(biased_stops(np.random.default_rng(seed), **scene)[0]), KINDS)


def test_every_part_tag_has_one_row_for_each_place_of_an_anchor():
    """Five anchors on the base do not move, four on the hand do."""
    assert [len(table) for table in evidence(M=1).tables] == [9] * 4
    assert [len(table) for table in evidence(M=3).tables] == [5 + 3 * 4] * 4
    assert [len(table) for table in evidence(M=3, base_moves=True).tables] == [27] * 4


def test_rows_hold_the_distance_that_m_stands_for():
    (stop,), _ = biased_stops(np.random.default_rng(1), M=1)
    (placed,) = place_stops([stop])
    found = distance_evidence([placed], KINDS)
    for k in range(4):
        row = {tuple(np.round(r[:2], 6)): r for r in found.tables[k]}
        tag = int(np.argmin(np.abs(placed.part_points_m[:, 0] - found.points_m[k, 0])))
        for i, anchor_m in enumerate(placed.anchors_m):
            own = row[tuple(np.round(anchor_m[:2], 6))]
            assert own[2] == pytest.approx(anchor_m[2] - 0.05)
            assert own[3] == pytest.approx(placed.m[tag, i] / 2.0)


def test_an_anchor_that_did_not_move_counts_with_its_mean():
    one, two = place_stops(biased_stops(np.random.default_rng(2), M=1)[0])[0], None
    two = replace(one, m=one.m * 1.2)
    once, both = distance_evidence([one], KINDS), distance_evidence([one, two], KINDS)
    for a, b in zip(once.tables, both.tables, strict=True):
        assert b[:, 3] == pytest.approx(1.1 * a[:, 3])
        assert b[:, 4:6] == pytest.approx(a[:, 4:6])


@pytest.mark.parametrize(("K", "share", "bias"), [(1, 1.0, 1.0), (2, 1.0, 1.25), (4, 2.0, 1.75)])
def test_what_tags_share_is_counted_for_all_of_them(K, share, bias):
    found = evidence(K=K, M=1)
    assert found.bias_m == pytest.approx(NOISE.bias_m * np.sqrt(bias))
    for table in found.tables:
        assert table[:, 4] == pytest.approx(share * NOISE.alpha_m**2)
        assert table[:, 5] == pytest.approx(share * NOISE.beta**2)


def test_what_was_not_heard_is_left_out():
    (placed,) = place_stops(biased_stops(np.random.default_rng(3), M=1)[0])
    m = placed.m.copy()
    m[2], m[0, :4] = np.nan, np.nan
    found = distance_evidence([replace(placed, m=m)], KINDS)
    assert sorted(len(table) for table in found.tables) == [5, 9, 9]
    assert len(found.points_m) == 3
    nothing = distance_evidence([replace(placed, m=np.full_like(m, np.nan))], KINDS)
    assert nothing.rows == 0
    assert len(nothing.stops_used) == 0


def test_odometry_of_an_older_stop_cannot_be_averaged_away():
    """Along any direction the information of all rows of a stop is at most that of its displacement."""
    observations, _ = biased_stops(np.random.default_rng(4), M=2, base_moves=True)
    placed = place_stops(observations)
    found = distance_evidence(placed, KINDS)
    information = np.zeros((2, 2))
    for point_m, table, stops in zip(found.points_m, found.tables, found.stops, strict=True):
        for row in table[stops == 0]:
            u = (point_m[:2] - row[:2]) / np.linalg.norm(point_m[:2] - row[:2])
            information += np.outer(u, u) / row[6]
    assert np.linalg.eigvalsh(information)[-1] <= 1.0 / placed[0].odometry.shift_m2


def test_a_stop_can_be_taken_out():
    found = evidence(M=3, base_moves=True)
    left = found.without_stop(1)
    assert found.stops_used.tolist() == [0, 1, 2]
    assert left.stops_used.tolist() == [0, 2]
    assert left.rows == found.rows - 36


def test_lifting_the_part_is_the_same_as_stating_it_higher():
    stops, _ = biased_stops(np.random.default_rng(5), M=2)
    higher = [replace(stop, part_tag_heights_m=stop.part_tag_heights_m + 0.1) for stop in stops]
    lifted = distance_evidence(place_stops(stops), KINDS).lifted(0.1)
    stated = distance_evidence(place_stops(higher), KINDS)
    assert lifted.points_m == pytest.approx(stated.points_m)
    for a, b in zip(lifted.tables, stated.tables, strict=True):
        assert a == pytest.approx(b)


def test_noise_can_be_raised():
    found = evidence(M=1)
    for a, b in zip(found.tables, found.noisier(3.0).tables, strict=True):
        assert b[:, 4:6] == pytest.approx(9.0 * a[:, 4:6])
        assert np.array_equal(np.delete(b, [4, 5], axis=1), np.delete(a, [4, 5], axis=1))


def compared(target, nearer, farther, shift_m2=0.0):
    anchors_m = np.array([[0.0, 0.0, 0.1], [1.0, 0.0, 0.2], [0.0, 1.0, 0.3]])
    points_m = np.array([[-0.2, 0.0, 0.05], [0.2, 0.0, 0.05]])
    nan = np.full(len(target), np.nan)
    comparisons = Comparisons(np.array(target), np.array(nearer), np.array(farther), nan)
    return PlacedComparisons(anchors_m, points_m, comparisons, OdometrySpread(shift_m2))


def test_a_comparison_of_anchors_that_did_not_move_counts_once_as_heard_last():
    old, new = compared([0, 0], [0, 1], [1, 2]), compared([0], [1], [0])
    found = comparison_evidence([old, new], NOISE, 0.5)
    assert found.rows == 2
    (table,) = found.tables
    of_pair = table[np.isclose(table[:, 6], np.hypot(1.0, 0.1))]
    assert of_pair[:, :3] == pytest.approx(np.array([[1.0, 0.0, 0.15]]))
    assert found.stops[0].tolist().count(1) == 1


def test_comparisons_carry_noise_lapse_and_tempering():
    (table, _) = comparison_evidence([compared([0, 1], [0, 1], [1, 2])], NOISE, 0.7).tables
    assert table[0, 7:10] == pytest.approx([0.03**2, 0.04, 0.7])
    (table, _) = comparison_evidence([compared([0, 1], [0, 1], [1, 2])], NOISE, 0.7).with_lapse(0.9).tables
    assert table[0, 7:10] == pytest.approx([0.03**2, 0.9, 0.7])
