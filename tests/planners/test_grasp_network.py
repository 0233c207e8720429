import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from standing_boxes import Upright, look, pixel_of

from planners.grasp_at_pixel import grasp_at_pixel
from planners.grasp_network import NetworkGraspQuality, ggcnn_answer, ggcnn_network
from rfcompass.errors import InputError, ShapeError
from rfcompass.interfaces import GraspQuality

BOX = Upright(0.02, 0.01, 0.0, 0.07, 0.04, 0.05)


def answering(row=0, column=0, angle_rad=0.0, width_px=10.0):
    def network(depth_m):
        quality = np.zeros(depth_m.shape)
        quality[row, column] = 0.9
        return quality, np.full(depth_m.shape, angle_rad), np.full(depth_m.shape, width_px)

    return network


def test_it_is_a_grasp_quality():
    assert isinstance(NetworkGraspQuality(network=answering()), GraspQuality)


@pytest.mark.parametrize("turn_rad", [0.0, 0.6, 2.0])
def test_angle_and_width_of_the_image_become_those_of_the_world(turn_rad):
    view = look(BOX, turn_rad=turn_rad)
    pixel = pixel_of(view, (0.02, 0.01, 0.05))
    # Across the box is the world's y; the camera's columns stand turn_rad to the world's x, its rows look down.
    network = answering(*pixel, angle_rad=turn_rad - np.pi / 2, width_px=0.04 / 0.45 * view.intrinsics[0, 0])
    maps = NetworkGraspQuality(network=network).quality(view)
    assert maps.angle_rad[pixel] % np.pi == pytest.approx(np.pi / 2)
    assert maps.width_m[pixel] == pytest.approx(0.04, rel=1e-6)
    T, aperture_m = grasp_at_pixel(view, maps, *pixel)
    assert np.abs(T[:2, 3] - [0.02, 0.01]).max() < 0.003
    assert T[2, 3] == pytest.approx(0.05 - 0.03 + 0.013, abs=1e-3)
    assert aperture_m == pytest.approx(0.06, abs=1e-6)


def test_a_pixel_without_depth_has_no_grasp():
    view = look(BOX)
    depth_m = view.depth_m.copy()
    depth_m[3, 4] = np.nan
    blind = type(view)(depth_m, view.intrinsics, view.T_world_camera)
    maps = NetworkGraspQuality(network=answering(3, 4)).quality(blind)
    assert not maps.quality.any()


@pytest.mark.parametrize(
    ("spoil", "what"),
    [
        (lambda q, a, w: (q, a), "2 images"),
        (lambda q, a, w: (q[1:], a, w), "quality of shape"),
        (lambda q, a, w: (q + 1, a, w), "quality"),
        (lambda q, a, w: (q, a * np.nan, w), "angle"),
        (lambda q, a, w: (q, a, -w), "width"),
    ],
)
def test_an_answer_that_is_none_is_refused(spoil, what):
    quality = NetworkGraspQuality(network=lambda depth_m: spoil(*answering()(depth_m)))
    with pytest.raises(ShapeError, match=what):
        quality.quality(look(BOX))


def test_the_network_cannot_change_the_view():
    def network(depth_m):
        depth_m[:] = 1.0
        return answering()(depth_m)

    view = look(BOX)
    before = view.depth_m.copy()
    NetworkGraspQuality(network=network).quality(view)
    assert np.array_equal(view.depth_m, before)


@given(st.floats(-1.5, 1.5), st.floats(-2.0, 3.0), st.floats(-1.0, 2.0))
def test_a_ggcnn_counts_its_angle_anticlockwise_as_one_looks_at_the_image(angle_rad, said, width):
    """The ends of its rectangle are cos to the right and sin upwards, which is against the rows."""
    image = np.ones((2, 3))
    quality, angle, width_px = ggcnn_answer(
        said * image, np.cos(2 * angle_rad) * image, np.sin(2 * angle_rad) * image, width * image
    )
    across = np.cos(angle) * -np.sin(angle_rad) - np.sin(angle) * np.cos(angle_rad)
    assert across == pytest.approx(0.0, abs=1e-9)
    assert quality == pytest.approx(min(max(said, 0.0), 1.0))
    assert width_px == pytest.approx(150.0 * max(width, 0.0))


class OnlySquares:
    """As the published layers: takes images of one size alone. What stands out of the mean most is the best grasp."""

    def __init__(self, size_px):
        self.size_px = size_px

    def __call__(self, image):
        assert image.shape == (self.size_px, self.size_px)
        assert np.isfinite(image).all()
        assert abs(image).max() <= 1.0
        nearer = np.maximum(-image, 0.0)
        flat = np.ones(image.shape)
        return nearer / nearer.max(), np.cos(0.6) * flat, np.sin(0.6) * flat, 0.2 * flat


@pytest.mark.parametrize("shape", [(90, 160), (160, 90), (120, 120)])
@pytest.mark.parametrize("size_px", [60, 300])
def test_a_network_of_one_size_rates_images_of_any(shape, size_px):
    depth_m = np.full(shape, 0.6)
    depth_m[20:30, 60:72] = 0.5
    depth_m[24, 65] = depth_m[0, 0] = np.nan
    quality, angle, width_px = ggcnn_network(OnlySquares(size_px), size_px)(depth_m)
    assert quality.shape == angle.shape == width_px.shape == shape
    middle = np.argwhere(quality > 0.9 * quality.max()).mean(axis=0)
    assert np.abs(middle - [24.5, 65.5]).max() < 1.0
    assert np.allclose(angle, -0.3)
    assert np.allclose(width_px, 0.2 * 150 * max(shape) / size_px)


def test_a_view_without_any_depth_has_no_grasp_for_it_either():
    view = look(BOX)
    blind = type(view)(np.full(view.depth_m.shape, np.nan), view.intrinsics, view.T_world_camera)

    def nothing(image):
        return [np.zeros(image.shape)] * 4

    assert not NetworkGraspQuality(network=ggcnn_network(nothing)).quality(blind).quality.any()


def test_four_images_of_the_networks_size_are_asked_for():
    with pytest.raises(ShapeError, match="four of"):
        ggcnn_network(lambda image: [image[1:]] * 4)(np.full((90, 160), 0.6))


@pytest.mark.parametrize("size_px", [0, -3, 2.5, True, None])
def test_a_network_of_no_size_is_refused_where_it_is_made(size_px):
    with pytest.raises(InputError, match="size_px"):
        ggcnn_network(OnlySquares(300), size_px)
