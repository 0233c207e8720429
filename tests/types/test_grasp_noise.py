"""How tries of one grasp differ."""

import numpy as np
import pinocchio as pin
import pytest

from rfcompass.errors import InputError
from rfcompass.types.grasp_noise import GraspNoise


def test_draws_spread_as_stated_and_friction_stays_in_its_range():
    draws = GraspNoise(position_m=0.002, turn_rad=0.01, friction_sd=0.3).draw(20_000, np.random.default_rng(0))
    np.testing.assert_allclose(draws.shifts_m.std(axis=0), 0.002, rtol=0.05)
    turns = np.array([pin.log3(T[:3, :3]) for T in draws.T_hand_turned[:2000]])
    np.testing.assert_allclose(turns.std(axis=0), 0.01, rtol=0.1)
    assert draws.friction.min() >= 0.2
    assert draws.friction.max() <= 0.8
    assert draws.friction.mean() == pytest.approx(0.5, abs=0.01)


def test_turns_are_rotations_even_large_ones():
    draws = GraspNoise(turn_rad=1.0).draw(100, np.random.default_rng(1))
    R = draws.T_hand_turned[:, :3, :3]
    np.testing.assert_allclose(R @ R.transpose(0, 2, 1), np.tile(np.eye(3), (100, 1, 1)), atol=1e-12)
    np.testing.assert_allclose(np.linalg.det(R), 1.0)


def test_without_noise_the_hand_is_where_it_was_sent():
    draws = GraspNoise(position_m=0.0, turn_rad=0.0, friction_sd=0.0).draw(3, np.random.default_rng(2))
    sent = pin.SE3.Random().homogeneous
    np.testing.assert_array_equal(draws.executed(sent), [sent] * 3)
    np.testing.assert_array_equal(draws.friction, 0.5)


@pytest.mark.parametrize(
    "bad",
    [
        {"position_m": -1.0},
        {"turn_rad": np.nan},
        {"friction_sd": np.inf},
        {"friction": 0.9},
        {"friction_range": (0, 1)},
    ],
)
def test_noise_that_cannot_be_is_refused(bad):
    with pytest.raises(InputError, match="GraspNoise"):
        GraspNoise(**bad)
