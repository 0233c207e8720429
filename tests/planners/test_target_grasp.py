"""A target in sight is grasped where that promises most, or what stands in the way first."""

import numpy as np
import pytest

from planners.extraction.candidates import ELSEWHERE
from planners.target_grasp import grasp_again, grasp_target, surest_grasp
from rfcompass.errors import NothingToGrasp
from rfcompass.mapping import back_project
from rfcompass.types import DepthView, ExtractionAction, GraspMaps, InstanceMasks

H, W = 40, 60
K = np.array([[80.0, 0, 29.5], [0, 80.0, 19.5], [0, 0, 1]])
DOWN = np.diag([1.0, -1.0, -1.0, 1.0])
DOWN[2, 3] = 0.6
TARGET = np.zeros((H, W), dtype=bool)
TARGET[15:25, 20:30] = True
LABELS = np.where(TARGET, 1, 0)
LABELS[15:25, 32:42] = 2  # two pixels beside it
LABELS[0:5, 50:60] = 3  # far away


def view(depth_m: float = 0.5) -> DepthView:
    return DepthView(np.full((H, W), depth_m), K, DOWN)


def grasps(**at: float) -> GraspMaps:
    """Qualities at pixels named `r20c25`."""
    quality = np.zeros((H, W))
    for where, value in at.items():
        row, column = where[1:].split("c")
        quality[int(row), int(column)] = value
    flat = np.zeros((H, W))
    return GraspMaps(quality, flat, flat + 0.04, flat + 0.02)


def go(maps: GraspMaps, **more):
    return grasp_target(more.pop("view", view()), TARGET, InstanceMasks(LABELS), maps, **more)


def place_m(row: int, column: int) -> np.ndarray:
    only = np.zeros((H, W), dtype=bool)
    only[row, column] = True
    return back_project(view(), only)[0]


def test_the_best_pixel_of_the_target_is_taken() -> None:
    chosen = go(grasps(r20c25=0.6, r18c22=0.8, r20c36=0.99))
    assert chosen.on_target
    assert chosen.action.mask_label == 1
    assert chosen.action.T_world_hand[:2, 3] == pytest.approx(place_m(18, 22)[:2])
    assert chosen.action.score == chosen.chance == 0.8


def test_what_stands_beside_a_target_that_cannot_be_grasped_goes_first() -> None:
    chosen = go(grasps(r20c25=0.05, r20c36=0.6, r2c55=0.9))
    assert not chosen.on_target
    assert chosen.action.mask_label == 2


def test_a_poor_grasp_of_the_target_is_tried_where_nothing_better_is_near() -> None:
    chosen = go(grasps(r20c25=0.05, r20c36=0.1, r2c55=0.9))
    assert chosen.on_target
    assert chosen.action.T_world_hand[:2, 3] == pytest.approx(place_m(20, 25)[:2])


def test_where_a_grasp_failed_another_place_is_tried() -> None:
    maps = grasps(r20c25=0.9, r16c21=0.6)
    first = go(maps).action
    second = go(maps, failed_m=[first.T_world_hand[:3, 3]])
    assert second.chance == 0.6 * ELSEWHERE
    assert second.action.T_world_hand[:2, 3] == pytest.approx(place_m(16, 21)[:2])


def test_without_any_grasp_its_middle_is_taken() -> None:
    chosen = go(grasps())
    assert chosen.on_target
    assert chosen.chance == 0
    assert np.abs(chosen.action.T_world_hand[:2, 3] - place_m(19, 24)[:2]).max() < 0.01


def test_a_target_without_a_depth_is_nothing_to_grasp() -> None:
    depth_m = np.full((H, W), 0.5)
    depth_m[TARGET] = np.nan
    with pytest.raises(NothingToGrasp, match="100 pixels"):
        go(grasps(), view=DepthView(depth_m, K, DOWN))


def again(maps: GraspMaps, at_m: np.ndarray, **more):
    first = ExtractionAction(9, np.vstack([np.column_stack([DOWN[:3, :3], [*at_m, 0.05]]), [0, 0, 0, 1]]), 0.03, 2.0)
    return first, grasp_again(first, view(), InstanceMasks(LABELS), maps, **more)


def test_from_near_the_same_object_is_grasped_where_it_shows_best() -> None:
    first, second = again(grasps(r18c36=0.7, r20c22=0.9), place_m(20, 34)[:2])
    assert second.chance == 0.7
    assert second.action.T_world_hand[:2, 3] == pytest.approx(place_m(18, 36)[:2])
    assert (second.action.mask_label, second.action.score) == (first.mask_label, first.score)
    assert second.action.aperture_m == pytest.approx(0.06)


@pytest.mark.parametrize("maps", [grasps(), grasps(r20c22=0.9)])
def test_without_a_grasp_on_it_from_near_there_is_none(maps: GraspMaps) -> None:
    assert again(maps, place_m(20, 36)[:2])[1] is None


def test_where_the_near_image_shows_no_object_there_is_none() -> None:
    assert again(grasps(r18c36=0.7), np.array([0.15, 0.10]))[1] is None


def test_from_near_failures_count_too() -> None:
    maps = grasps(r18c36=0.7, r22c40=0.6)
    _, second = again(maps, place_m(20, 34)[:2], failed_m=[place_m(18, 36)])
    assert second.action.T_world_hand[:2, 3] == pytest.approx(place_m(22, 40)[:2])


def test_the_surest_grasp_is_the_best_on_any_object_where_nothing_failed() -> None:
    maps = grasps(r20c25=0.6, r20c36=0.7, r2c55=0.65, r35c5=0.99)  # the last of them is on no object
    surest = surest_grasp(view(), InstanceMasks(LABELS), maps)
    assert (surest.action.mask_label, surest.chance, surest.on_target) == (2, 0.7, False)
    then = surest_grasp(view(), InstanceMasks(LABELS), maps, failed_m=[place_m(20, 36)])
    assert (then.action.mask_label, then.chance) == (3, 0.65)
    assert surest_grasp(view(), InstanceMasks(LABELS), grasps(r35c5=0.99)) is None
