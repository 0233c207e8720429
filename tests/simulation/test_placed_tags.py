"""Tags keep their own constants wherever they go, and their axes are axes."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rfcompass.errors import DuplicateEpc, InputError, ShapeError
from rfcompass.simulation import DUAL_DIPOLE, SQUIGGLE, PlacedTags, TagModel

directions = st.tuples(*[st.floats(-1.0, 1.0)] * 3).map(np.array).filter(lambda v: np.linalg.norm(v) > 1e-3)


def drawn(count=3, model=SQUIGGLE, seed=0, dipoles=None):
    epcs = [f"e{k:02x}" for k in range(count)]
    dipoles = np.tile([0.0, 0.0, 1.0], (count, 1)) if dipoles is None else dipoles
    return PlacedTags.draw(epcs, np.zeros((count, 3)), dipoles, model, np.random.default_rng(seed))


@given(axis=directions)
def test_the_second_dipole_is_level_and_across_the_first(axis):
    tags = drawn(1, DUAL_DIPOLE, dipoles=axis[None])
    one, other = tags.axes()[0]
    assert np.linalg.norm(one) == pytest.approx(1.0)
    assert np.linalg.norm(other) == pytest.approx(1.0)
    assert one @ other == pytest.approx(0.0, abs=1e-9)
    if abs(one[2]) < 1.0 - 1e-9:
        assert other[2] == pytest.approx(0.0, abs=1e-6)


def test_a_plain_dipole_has_one_axis():
    assert drawn().axes().shape == (3, 1, 3)
    assert drawn(model=DUAL_DIPOLE).axes().shape == (3, 2, 3)


@given(seed=st.integers(0, 1000))
def test_moving_tags_keeps_their_constants_and_names(seed):
    tags = drawn(seed=seed)
    moved = tags.moved(np.ones((3, 3)), np.tile([1.0, 0.0, 0.0], (3, 1)))
    assert moved.epcs == tags.epcs
    assert np.array_equal(moved.phase_rad, tags.phase_rad)
    assert np.array_equal(moved.gain_db, tags.gain_db)
    assert (moved.points_m == 1.0).all()


def test_phases_are_anything_and_gains_spread_as_the_type_says():
    tags = drawn(4000)
    assert np.abs(np.exp(1j * tags.phase_rad).mean()) < 4 / np.sqrt(4000)
    assert tags.gain_db.std() == pytest.approx(SQUIGGLE.gain_spread_db, rel=0.06)
    alike = drawn(10, TagModel(gain_spread_db=0.0))
    assert (alike.gain_db == 0.0).all()


def test_what_is_no_tag_is_refused():
    with pytest.raises(DuplicateEpc):
        PlacedTags.draw(["a", "a"], np.zeros((2, 3)), np.ones((2, 3)), SQUIGGLE, np.random.default_rng(0))
    with pytest.raises(ShapeError, match="length zero"):
        drawn(1, dipoles=np.zeros((1, 3)))
    with pytest.raises(ShapeError, match="across"):
        PlacedTags(("a",), np.zeros((1, 3)), np.eye(3)[:1], DUAL_DIPOLE, np.zeros(1), np.zeros(1), np.eye(3)[:1])


@pytest.mark.parametrize(
    "wrong", [{"ports": "triple"}, {"gain_dbi": np.nan}, {"sensitivity_dbm": np.inf}, {"gain_spread_db": -1.0}]
)
def test_a_type_that_cannot_be_is_refused(wrong):
    with pytest.raises(InputError):
        TagModel(**wrong)
