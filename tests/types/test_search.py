"""Records of the pile search refuse what cannot be."""

import numpy as np
import pytest

from rfcompass.errors import InputError, ShapeError
from rfcompass.types import GRASP_OUTCOMES, GraspAttempt, GraspMaps, PileLook

FLAT = np.zeros((2, 3))


def test_grasp_maps_are_images_of_one_shape() -> None:
    with pytest.raises(ShapeError, match="width_m"):
        GraspMaps(FLAT, FLAT, np.zeros((3, 2)), FLAT)


@pytest.mark.parametrize("quality", [-0.1, 1.1])
def test_a_grasp_quality_is_a_share(quality: float) -> None:
    with pytest.raises(ShapeError, match="quality"):
        GraspMaps(np.full((2, 3), quality), FLAT, FLAT, FLAT)


@pytest.mark.parametrize("name", ["width_m", "depth_m"])
def test_widths_and_depths_are_not_negative(name: str) -> None:
    with pytest.raises(ShapeError, match=name):
        GraspMaps(**{"quality": FLAT, "angle_rad": FLAT, "width_m": FLAT, "depth_m": FLAT, name: FLAT - 1})


def test_only_what_is_held_is_a_success() -> None:
    assert [outcome for outcome in GRASP_OUTCOMES if GraspAttempt(outcome, 0.0, 1.0).success] == ["held"]


def test_an_unknown_outcome_is_refused() -> None:
    with pytest.raises(InputError, match="none of held"):
        GraspAttempt("lost", 0.0, 1.0)


def test_a_look_without_a_view_is_refused() -> None:
    with pytest.raises(InputError, match="without a view"):
        PileLook(())


def test_nothing_comes_into_the_drop_zone_that_was_not_held() -> None:
    with pytest.raises(InputError, match="drop zone"):
        GraspAttempt("slipped", 0.0, 1.0, shows_target=True)
