"""The tag on the table: one draw for all cells, and what lies over it does what dielectrics do."""

import numpy as np
import pytest

from rfcompass.localization import WRIST_SAR
from rfcompass.studies.wrist_scan import (
    BANDS_HZ,
    EPC,
    HEIGHTS_M,
    SEARCH,
    TAG_LENGTH_M,
    draw_tag_on_table,
    scan_from_wrist,
    wrist_rig,
    wrist_track,
)


def drawn(seed=0, turn_rad=np.pi / 2):
    return draw_tag_on_table(np.random.default_rng(seed), turn_rad)


def test_one_seed_gives_one_scene():
    one, other = drawn(), drawn()
    np.testing.assert_array_equal(one.point_m, other.point_m)
    np.testing.assert_array_equal(one.in_sight.scatterers.points_m, other.in_sight.scatterers.points_m)
    assert [thing.name for thing in one.buried.scene.obstacles] == ["thing_0", "thing_1", "thing_2", "cloth"]


@pytest.mark.parametrize("seed", range(20))
def test_a_buried_tag_has_everything_above_it_and_the_wrist_above_everything(seed):
    tag = drawn(seed)
    assert SEARCH.contains(tag.point_m[None]).all()
    bounds_m = np.array([thing.bounds_m for thing in tag.buried.scene.obstacles])
    assert bounds_m[:, 0, 2].min() > tag.point_m[2]
    assert bounds_m[:, 1, 2].max() < min(min(heights) for heights in HEIGHTS_M.values())
    over = (bounds_m[-1, 0, :2] < tag.point_m[:2]) & (tag.point_m[:2] < bounds_m[-1, 1, :2])
    assert over.all()


def test_the_nearest_point_of_a_tag_lies_on_it():
    tag = drawn(3)
    dipole, half_m = tag.tags.dipoles[0], TAG_LENGTH_M / 2
    across = np.cross(dipole, [0.0, 0.0, 1.0]) / np.linalg.norm(np.cross(dipole, [0.0, 0.0, 1.0]))
    assert tag.miss_m(tag.point_m + 0.04 * dipole) == pytest.approx(0.0, abs=1e-12)
    assert tag.miss_m(tag.point_m + 0.03 * across) == pytest.approx(0.03)
    assert tag.miss_m(tag.point_m + (half_m + 0.02) * dipole) == pytest.approx(0.02)
    off_m = np.array([0.03, -0.05, 0.02])
    assert tag.miss_m(tag.point_m + off_m) <= np.linalg.norm(off_m)


def test_the_wrist_goes_round_once_at_each_height_and_looks_down():
    for name, heights_m in HEIGHTS_M.items():
        track = wrist_track(name)
        assert np.unique(track.positions_m[:, 2]).tolist() == sorted(heights_m)
        np.testing.assert_allclose(track.rotations[:, :, 0], np.tile([0.0, 0.0, -1.0], (len(track), 1)), atol=1e-12)
    for band_mhz, carriers_hz in BANDS_HZ.items():
        assert np.ptp(wrist_rig(band_mhz).frequencies_hz) == pytest.approx(band_mhz * 1e6)
        assert np.diff(carriers_hz).max() < 299_792_458.0 / (2 * 3.0)  # nothing within 3 m repeats


def test_a_pile_delays_the_wave_so_that_the_tag_seems_deeper():
    """10 cm of things with √ε - 1 about 0.2 are 2 cm of way: a law of the mean over scenes, not of each."""
    deeper_m = []
    for seed in range(12):
        heights_m = []
        for sight in ("in_sight", "buried"):
            tag = drawn(seed, turn_rad=0.0)
            scan = scan_from_wrist(
                getattr(tag, sight), tag.tags, wrist_rig(200.0), wrist_track("two"), np.random.default_rng(seed)
            )
            heights_m.append(WRIST_SAR.locate(scan.trace(EPC), SEARCH).point_m[2])
        deeper_m.append(heights_m[0] - heights_m[1])
    assert 0.005 < np.mean(deeper_m) < 0.04
