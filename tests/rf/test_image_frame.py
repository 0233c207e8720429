"""The image covers what the path can tell, on axes that turn with the path."""

import numpy as np
import pytest

from rfcompass.rf.image_frame import frame_of_path, given_frame
from rfcompass.types.volumes import SearchVolume

LINE_M = np.column_stack([np.linspace(0, 1, 26), np.zeros(26), np.full(26, 0.3)])
CORNER_M = np.concatenate([LINE_M, LINE_M[:, [1, 0, 2]]])
BOX_M = np.concatenate([CORNER_M, CORNER_M + np.array([0, 0, 0.4])])


def extent_m(frame):
    return frame.volume.upper_m - frame.volume.lower_m


def test_there_and_back_is_the_same_place():
    points_m = np.random.default_rng(0).normal(size=(5, 3))
    for path_m in (LINE_M, LINE_M[:, [0, 2, 1]], LINE_M[:, [2, 1, 0]], CORNER_M, CORNER_M[:, [2, 0, 1]], BOX_M):
        frame = frame_of_path(path_m, None)
        np.testing.assert_allclose(frame.axes @ frame.axes.T, np.eye(3), atol=1e-12)
        np.testing.assert_allclose([frame.back(p) for p in frame.into(points_m)], points_m, atol=1e-12)


@pytest.mark.parametrize(
    ("path_m", "height_m", "free", "extent"),
    [
        (LINE_M, None, [True, True, False], [3.0, 1.0, 0.0]),
        (LINE_M, 0.1, [True, True, False], [3.0, 1.0, 0.0]),
        (CORNER_M, 0.1, [True, True, False], [3.0, 3.0, 0.0]),
        (CORNER_M, None, [True, True, True], [3.0, 3.0, 1.0]),
        (BOX_M, None, [True, True, True], [3.0, 3.0, 2.4]),
        (BOX_M, 0.1, [True, True, False], [3.0, 3.0, 0.0]),
    ],
)
def test_the_extent_is_the_reach_about_the_path(path_m, height_m, free, extent):
    frame = frame_of_path(path_m, height_m, 1.0)
    assert frame.volume.free_axes.tolist() == free
    np.testing.assert_allclose(extent_m(frame), extent, atol=1e-9)


def test_a_known_height_is_the_height_of_every_point():
    for path_m in (LINE_M, CORNER_M, BOX_M):
        frame = frame_of_path(path_m, 0.17)
        corners = [frame.back(frame.volume.lower_m), frame.back(frame.volume.upper_m)]
        np.testing.assert_allclose([corner[2] for corner in corners], 0.17)


def test_a_level_path_without_heights_looks_down():
    frame = frame_of_path(CORNER_M, None)
    assert frame.back(frame.volume.lower_m)[2] < frame.back(frame.volume.upper_m)[2]
    assert frame.back(frame.volume.upper_m)[2] == pytest.approx(0.3)


def test_a_given_volume_is_cut_at_a_known_height():
    volume = SearchVolume([0.0, 0.0, 0.0], [1.0, 2.0, 0.5])
    assert given_frame(volume, None).volume is volume
    cut = given_frame(volume, 0.2).volume
    assert cut.lower_m.tolist() == [0.0, 0.0, 0.2]
    assert cut.upper_m.tolist() == [1.0, 2.0, 0.2]
