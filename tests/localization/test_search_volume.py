import numpy as np
import pytest
from survey_scenes import RAIL_M, reads_of, square_m

from rfcompass.errors import ShapeError, UnsuitablePath
from rfcompass.localization import default_volume
from rfcompass.types import Scan, SearchVolume


def scan(positions_m, dimensions):
    return Scan({"tag": reads_of([0.5, 0.7, 0.0], positions_m)}, "rail", dimensions)


def test_beside_a_rail_along_x_is_the_side_of_plus_y():
    volume = default_volume(scan(RAIL_M, 2))
    assert np.allclose(volume.lower_m, [-0.3, 0.2, 0.0])
    assert np.allclose(volume.upper_m, [1.3, 1.5, 0.0])


def test_beside_a_rail_along_y_is_the_side_of_plus_x():
    volume = default_volume(scan(RAIL_M[:, [1, 0, 2]], 2))
    assert np.allclose(volume.lower_m, [0.2, -0.3, 0.0])
    assert np.allclose(volume.upper_m, [1.5, 1.3, 0.0])


def test_a_wrist_looks_down():
    volume = default_volume(scan(square_m(height_m=0.6), 3))
    assert volume.upper_m[2] == 0.6
    assert volume.lower_m[2] == pytest.approx(-0.9)


def test_without_a_path_there_is_no_volume():
    with pytest.raises(UnsuitablePath):
        default_volume(Scan())


def test_a_volume_has_its_corners_in_order():
    with pytest.raises(ShapeError):
        SearchVolume([0, 0, 1], [1, 1, 0])
