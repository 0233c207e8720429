"""A room can always be furnished, and other parts lie beside what stands in it."""

import numpy as np
import pytest

from rfcompass.recordings import PartDatabase
from rfcompass.robots import YouBot
from rfcompass.simulation import PlaneRoom
from rfcompass.studies.radio_setup import AREA_M, LYING_HEIGHT_M, TRACK_CLEAR_M, RadioSetup
from rfcompass.studies.study import trial_rng

ROBOT = YouBot()
LEG = PartDatabase(":memory:").part("table_leg_3")


def sensor(seed, scene):
    rng = trial_rng("fetch", seed)
    room = PlaneRoom.draw(rng, area_m=AREA_M)
    return RadioSetup(scene=scene, others=(LEG, LEG, LEG)).sensor(room, ROBOT.layout, LEG.layout(4), rng)


@pytest.mark.parametrize("scene", ["room_los", "room_nlos", "heavy_clutter"])
def test_every_start_has_room_for_furniture_and_other_parts(scene):
    for seed in range(60):
        heard = sensor(seed, scene)
        assert len(heard.other_tags) == 3
        assert heard.scene.scene.obstacles


def test_other_parts_lie_neither_in_furniture_nor_on_the_track():
    for seed in range(60):
        heard = sensor(seed, "room_nlos")
        track_m = heard.carrier.track().positions_m[:, :2]
        low = [ob.bounds_m for ob in heard.scene.scene.obstacles if ob.bounds_m[0, 2] < LYING_HEIGHT_M]
        for tags in heard.other_tags:
            tags_m = tags.points_m[:, :2]
            assert not any(((tags_m > b[0, :2]) & (tags_m < b[1, :2])).all(axis=1).any() for b in low)
            centre_m = tags_m.mean(axis=0)
            assert np.linalg.norm(track_m - centre_m, axis=1).min() > TRACK_CLEAR_M
