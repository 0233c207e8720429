import grasp_map_reference as reference
import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from standing_boxes import Upright, look, pixel_of

from planners.grasp_at_pixel import grasp_at_pixel
from planners.grasp_number_kernels import CLOSING
from planners.grasp_quality import AntipodalQuality, JawSizes, grasp_quality
from planners.height_map import HeightMap, height_map
from rfcompass.errors import InputError, ShapeError
from rfcompass.interfaces import GraspQuality
from rfcompass.mapping.camera import points_image
from rfcompass.types import DepthView

QUALITY = AntipodalQuality()
SOME = st.builds(
    Upright,
    x_m=st.floats(-0.08, 0.08),
    y_m=st.floats(-0.05, 0.05),
    yaw_rad=st.floats(0, np.pi),
    length_m=st.floats(0.02, 0.12),
    width_m=st.floats(0.02, 0.08),
    height_m=st.floats(0.03, 0.09),
    from_m=st.floats(0.0, 0.025),
)
# With room to spare: narrower than the jaws open, and whole in the image with the ground about it.
FITTING = st.builds(
    Upright,
    x_m=st.floats(-0.01, 0.01),
    y_m=st.floats(-0.01, 0.01),
    yaw_rad=st.floats(0, np.pi),
    length_m=st.floats(0.02, 0.09),
    width_m=st.floats(0.02, 0.07),
    height_m=st.floats(0.03, 0.06),
    from_m=st.floats(0.0, 0.025),
)


def standing(view):
    return points_image(view)[..., 2] > QUALITY.standing_m


def best_pixel(maps):
    return np.unravel_index(np.argmax(maps.quality), maps.quality.shape)


def test_it_is_a_grasp_quality():
    assert isinstance(QUALITY, GraspQuality)


def test_a_bare_image_is_rated_as_a_view_is():
    view = look(Upright(0.02, 0.01, 0.3, 0.07, 0.04, 0.05))
    bare, maps = grasp_quality(view.depth_m, view.intrinsics, view.T_world_camera), QUALITY.quality(view)
    assert bare.quality.max() > 0
    for name in ("quality", "angle_rad", "width_m", "depth_m"):
        np.testing.assert_array_equal(getattr(bare, name), getattr(maps, name))
    with pytest.raises(ShapeError, match="positive"):
        grasp_quality(-view.depth_m, view.intrinsics, view.T_world_camera)


def test_an_empty_table_has_no_grasp():
    maps = QUALITY.quality(look())
    assert not maps.quality.any()
    assert not maps.width_m.any()


def test_an_image_without_any_depth_has_no_grasp():
    view = look(Upright())
    blind = DepthView(np.full_like(view.depth_m, np.nan), view.intrinsics, view.T_world_camera)
    assert not QUALITY.quality(blind).quality.any()


def test_a_box_is_gripped_in_its_middle_across_its_width():
    view = look(Upright(0.03, -0.02, 0.5, 0.10, 0.04, 0.05))
    maps = QUALITY.quality(view)
    row, column = best_pixel(maps)
    T, aperture_m = grasp_at_pixel(view, maps, row, column)
    assert maps.quality[row, column] > 0.7
    assert np.linalg.norm(T[:2, 3] - [0.03, -0.02]) < 0.035
    turned = (maps.angle_rad[row, column] - (0.5 + np.pi / 2)) % np.pi
    assert min(turned, np.pi - turned) < np.deg2rad(12)
    assert 0.05 < aperture_m < 0.075


def test_a_box_wider_than_the_hand_has_no_closing_grasp():
    view = look(Upright(length_m=0.10, width_m=0.095, height_m=0.05))
    assert not (QUALITY.evidence(view).kind == 1).any()


def test_walls_beside_a_box_leave_no_room_for_fingers():
    box = Upright(length_m=0.05, width_m=0.04, height_m=0.05)
    walls = [Upright(y_m=sign * 0.040, length_m=0.17, width_m=0.032, height_m=0.05) for sign in (1, -1)]
    ends = [Upright(x_m=sign * 0.045, length_m=0.032, width_m=0.17, height_m=0.05) for sign in (1, -1)]
    alone, walled = look(box), look(box, *walls, *ends)
    middle = pixel_of(alone, (0, 0, 0.05))
    assert QUALITY.quality(alone).quality[middle] > 0.7
    evidence = QUALITY.evidence(walled)
    assert evidence.kind[middle] != 1 or evidence.numbers[middle][0] < 0


def test_tips_stay_above_the_table():
    view = look(Upright(height_m=0.02), Upright(x_m=0.12, height_m=0.05))
    maps = QUALITY.quality(view)
    tip_m = points_image(view)[..., 2] - maps.depth_m
    assert tip_m[maps.quality > 0].min() >= QUALITY.jaws.above_table_m - 1e-9


@settings(max_examples=4, deadline=None)
@given(st.lists(SOME, min_size=1, max_size=4), st.integers(0, 2**31))
@example([Upright(0, 0, 0, 0.0625, 0.0234375, 0.078125, 0)], 0)  # equally good at two depths
def test_the_kernel_agrees_with_the_definitions(things, seed):
    view = look(*things)
    evidence, heights = QUALITY.evidence(view), height_map(view, standing(view), QUALITY.cell_m)
    for row, column in np.random.default_rng(seed).permutation(np.argwhere(standing(view)))[:4]:
        expected = reference.best(heights, points_image(view)[row, column], QUALITY)
        if not expected:
            assert evidence.kind[row, column] == 0
            continue
        maps = (evidence.log_odds, evidence.angle_rad, evidence.width_m, evidence.depth_m, evidence.kind)
        got = np.array([values[row, column] for values in maps])
        assert np.abs(got - np.array(expected)).max(axis=1).min() < 1e-9


@settings(max_examples=8, deadline=None)
@given(st.lists(SOME, min_size=0, max_size=5))
def test_qualities_are_shares_and_only_on_what_stands(things):
    view = look(*things)
    maps = QUALITY.quality(view)
    assert ((maps.quality >= 0) & (maps.quality <= 1)).all()
    assert not maps.quality[~standing(view)].any()
    assert (maps.width_m <= QUALITY.jaws.opening_m).all()


@settings(max_examples=8, deadline=None)
@given(FITTING, st.integers(0, 15), st.floats(-0.02, 0.02), st.floats(-0.02, 0.02))
def test_turning_the_camera_hardly_changes_the_best_grasp(thing, turns, x_m, y_m):
    """By 0.005 in the median of 380 drawn things, 0.046 at most; where an image cuts them off, by more."""
    first = QUALITY.quality(look(thing)).quality.max()
    other = QUALITY.quality(look(thing, turn_rad=turns * np.pi / 8, at_m=(x_m, y_m))).quality.max()
    assert first > 0.7
    assert other == pytest.approx(first, abs=0.08)


@settings(max_examples=8, deadline=None)
@given(st.integers(0, 7), st.floats(0.025, 0.05), st.floats(-0.04, 0.04))
def test_turning_a_box_turns_its_grasp(turns, width_m, x_m):
    view = look(Upright(x_m, 0.0, turns * np.pi / 8, 0.09, width_m, 0.05))
    maps = QUALITY.quality(view)
    turned = (maps.angle_rad[best_pixel(maps)] - (turns + 4) * np.pi / 8) % np.pi
    assert min(turned, np.pi - turned) < np.deg2rad(23)


def test_a_map_fills_a_lost_pixel_from_beside_it_and_a_shadow_from_the_ground():
    view = look(Upright())
    depth_m = view.depth_m.copy()
    row, column = pixel_of(view, (0, 0, 0.05))
    depth_m[row, column] = np.nan
    lost = DepthView(depth_m, view.intrinsics, view.T_world_camera)
    heights = height_map(lost, standing(lost), 0.0025)
    assert reference.over(heights, np.zeros(1), np.zeros(1)) == pytest.approx(0.05, abs=1e-3)
    guessed_m = heights.heights_m[~heights.seen & np.isfinite(heights.heights_m)]
    assert guessed_m.min() < 1e-9
    assert np.median(guessed_m) < 0.01


def test_what_nobody_saw_is_unknown():
    view = look(Upright(x_m=0.20))
    heights = height_map(view, standing(view), 0.0025)
    assert np.isinf(heights.heights_m).any()


def test_ground_in_the_shadow_of_a_box_counts_as_unseen():
    far, near = Upright(x_m=0.15, height_m=0.09, width_m=0.05), Upright(height_m=0.09, width_m=0.05)
    numbers = []
    for box in (near, far):
        view = look(box)
        pixel = pixel_of(view, (box.x_m, 0.0, 0.09))
        evidence = QUALITY.evidence(view, angles_rad=np.zeros(1))
        assert evidence.kind[pixel] == 1
        numbers.append(dict(zip(CLOSING, evidence.numbers[pixel], strict=True)))
    assert numbers[0]["unseen"] < 0.2 < 0.5 < numbers[1]["unseen"]


def test_a_map_of_nonsense_is_refused():
    with pytest.raises(ShapeError, match="NaN"):
        HeightMap(np.zeros(2), 0.01, np.full((2, 2), np.nan), np.ones((2, 2), dtype=bool))
    with pytest.raises(ShapeError, match="not positive"):
        HeightMap(np.zeros(2), 0.0, np.zeros((2, 2)), np.ones((2, 2), dtype=bool))


def test_a_hand_without_an_opening_is_refused():
    with pytest.raises(InputError, match="opening_m"):
        JawSizes(opening_m=0.0)


def test_equal_views_give_equal_bits():
    things = (Upright(), Upright(0.07, 0.03, 0.7))
    first, second = QUALITY.quality(look(*things)), QUALITY.quality(look(*things))
    assert all(np.array_equal(getattr(first, n), getattr(second, n)) for n in first.__slots__)


def test_hands_that_are_wider_than_what_is_looked_at_are_refused():
    JawSizes(opening_m=0.096, thickness_m=0.012)
    for wrong in ({"opening_m": 0.14}, {"thickness_m": 0.02}):
        with pytest.raises(InputError, match=r"0\.06 m"):
            JawSizes(**wrong)


def test_a_weight_for_each_number():
    with pytest.raises(ShapeError, match="closing"):
        AntipodalQuality(closing=(1.0,) * 10)


def test_tips_that_must_stay_high_leave_low_things_alone():
    """Where the tips would have to end above the surface, there is no grasp, of neither kind."""
    quality = AntipodalQuality(jaws=JawSizes(above_table_m=0.03))
    low = quality.quality(look(Upright(0.0, 0.0, 0.0, 0.2, 0.15, 0.02)))
    assert not low.quality.any()


WEIGHTS = (np.nan, *QUALITY.closing[1:])


@pytest.mark.parametrize(
    "wrong",
    [
        {"angles": 0}, {"angles": -3}, {"angles": 2.5}, {"depths_m": ()}, {"depths_m": (0.01, -0.02)},
        {"friction": -1.0}, {"friction": np.inf}, {"friction": np.nan}, {"table_m": np.nan}, {"standing_m": np.nan},
        {"cell_m": 0.0}, {"cell_m": np.inf}, {"closing": WEIGHTS}, {"pinching": (*QUALITY.pinching[1:], np.inf)},
    ],
)  # fmt: skip
def test_numbers_with_which_nothing_can_be_tried_are_refused(wrong):
    with pytest.raises(InputError):
        AntipodalQuality(**wrong)


VIEW = look(Upright())


@pytest.mark.parametrize("angles_rad", [[np.nan], [[0.0, 0.5]], 0.3, []])
def test_directions_that_are_none_are_refused(angles_rad):
    with pytest.raises(InputError, match="angles_rad"):
        QUALITY.evidence(VIEW, angles_rad=angles_rad)


@pytest.mark.parametrize("pixels", [np.ones((3, 160), bool), np.ones(160, bool), np.ones((90, 160))])
def test_pixels_of_another_image_are_refused(pixels):
    with pytest.raises(ShapeError, match="pixels"):
        QUALITY.evidence(VIEW, pixels)


def test_cells_that_no_memory_holds_are_refused():
    with pytest.raises(InputError, match=r"1e-06 m has") as refusal:
        AntipodalQuality(cell_m=1e-6).quality(VIEW)
    assert refusal.value.numbers["cells"] > refusal.value.numbers["most"]


def test_the_matrix_of_another_camera_is_refused():
    K = VIEW.intrinsics * [[4.0], [4.0], [1.0]]
    with pytest.raises(ShapeError, match="another image size"):
        grasp_quality(VIEW.depth_m, K, VIEW.T_world_camera)
    with pytest.raises(ShapeError, match="no pixel"):
        grasp_quality(np.ones((0, 160)), VIEW.intrinsics, VIEW.T_world_camera)
