"""One scan with the hand over the part, and how its comparisons are judged."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rfcompass.geometry import Pose2
from rfcompass.recordings import PartDatabase
from rfcompass.rf import meter
from rfcompass.robots import YouBot
from rfcompass.simulation import FAR_LINE_M
from rfcompass.studies.comparisons import BANDED, COMPARISONS, comparison_trial, named_meter, wrong_comparisons
from rfcompass.studies.radio_scan import DISC_M, HAND_M, PART_AREA_M, scan_over_part
from rfcompass.studies.radio_setup import RadioSetup
from rfcompass.studies.study import trial_rng

ROBOT = YouBot()
LEG = PartDatabase(":memory:").part("table_leg_3")


@pytest.mark.parametrize("seed", range(3))
def test_the_part_lies_near_the_hand_and_where_the_study_says(seed):
    radio = RadioSetup(scene="free_space", legs_m=FAR_LINE_M)
    stop = scan_over_part(ROBOT, LEG, LEG.layout(2), radio, np.random.default_rng(seed))
    centre_m = stop.truth.targets.points_m[:, :2].mean(axis=0)
    assert (centre_m >= PART_AREA_M[0]).all()
    assert (centre_m <= PART_AREA_M[1]).all()
    in_base_m = stop.truth.T_room_base.inverse().apply(centre_m)
    assert np.linalg.norm(in_base_m - HAND_M) <= DISC_M + 1e-9
    assert set(stop.observation.scan.epcs) == {*ROBOT.layout.epcs, *LEG.layout(2).epcs}


def test_the_robot_believes_where_its_tags_truly_are_when_nothing_has_moved():
    stop = scan_over_part(ROBOT, LEG, LEG.layout(2), RadioSetup(scene="free_space"), np.random.default_rng(1))
    told, truth = stop.observation.anchors, stop.truth
    back = truth.T_room_base.inverse() @ Pose2()
    assert np.allclose(back.apply(truth.anchors.points_m), told.points_m)


@given(st.integers(0, 500), st.floats(0.0, 0.5))
def test_true_distances_make_no_wrong_comparison_and_reversed_ones_only_wrong_ones(seed, epsilon):
    d = np.random.default_rng(seed).uniform(0.1, 3.0, (3, 6))
    assert not wrong_comparisons(d, d, epsilon).any()
    assert wrong_comparisons(1.0 / d, d, epsilon).all()


def test_a_larger_threshold_never_keeps_more():
    rng = np.random.default_rng(0)
    m, d = rng.uniform(0.1, 3.0, (4, 9)), rng.uniform(0.1, 3.0, (4, 9))
    kept = [len(wrong_comparisons(m, d, epsilon)) for epsilon in (0.0, 0.05, 0.1, 0.3)]
    assert kept == sorted(kept, reverse=True)


def test_the_banded_meter_is_pinit_with_a_band_and_every_other_name_is_a_kind():
    assert named_meter(BANDED).band_rad == pytest.approx(np.radians(5))
    assert named_meter("aoa") == meter("aoa")


def test_a_trial_depends_on_its_seed_only():
    cell = COMPARISONS.cells[0]
    one, other = (comparison_trial(cell, 3, trial_rng("wrong-comparisons", 3)) for _ in range(2))
    assert one == other
    assert 0 < len(one["wrong_00"]) <= 4 * 36
