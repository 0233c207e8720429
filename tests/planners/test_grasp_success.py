import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from planners.grasp_number_kernels import CLOSING, PINCHING
from planners.grasp_success import CLOSING_WEIGHTS, PINCHING_WEIGHTS, success_of


@given(st.lists(st.floats(-30, 30), min_size=2, max_size=20))
def test_a_larger_score_never_means_a_smaller_chance(log_odds):
    chance = success_of(np.sort(log_odds), np.ones(len(log_odds), dtype=int))
    assert (np.diff(chance) >= 0).all()
    assert ((chance >= 0) & (chance <= 1)).all()


def test_no_grasp_has_no_chance():
    assert success_of(np.array([-np.inf, 0.0]), np.array([0, 2])) == pytest.approx([0.0, 0.5])


def test_every_number_has_a_weight():
    assert len(CLOSING_WEIGHTS) == len(CLOSING) + 1
    assert len(PINCHING_WEIGHTS) == len(PINCHING) + 1


def test_what_speaks_against_a_grasp_has_a_negative_weight():
    weights = dict(zip(CLOSING, CLOSING_WEIGHTS, strict=False))
    assert all(weights[name] < 0 for name in ("skew", "off_centre", "unseen", "pinned"))
    assert all(weights[name] > 0 for name in ("clearance", "contact", "engaged", "steepness", "palm"))
