"""Rooms as recipes: what is fixed stays, what is random follows from the seed, and nothing stands in the way."""

import json

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rfcompass.errors import SceneError, ShapeError
from rfcompass.simulation import SCENES, AntennaTrack, Scatterers, load_recipe, recipe_from_json

PART_M, READER_M = (3.5, 3.0), (3.0, 0.7)


def drawn(name, seed=0, **more):
    return load_recipe(name).draw(np.random.default_rng(seed), part_m=PART_M, reader_m=READER_M, **more)


@pytest.mark.parametrize("name", SCENES)
def test_every_shipped_recipe_makes_a_room(name):
    scene = drawn(name)
    assert scene.scene.name == name
    if scene.scene.room is not None:
        size_m = scene.scene.room.size_m
        for obstacle in scene.scene.obstacles:
            assert (obstacle.bounds_m[0] >= -1e-9).all(), obstacle.name
            assert (obstacle.bounds_m[1] <= size_m + 1e-9).all(), obstacle.name
        assert (scene.scatterers.points_m >= 0).all()
        assert (scene.scatterers.points_m <= size_m).all()


@settings(max_examples=20)
@given(st.integers(0, 1000))
def test_furniture_keeps_out_of_the_places_to_keep_clear(seed):
    clear = (1.5, 1.5, 0.5)
    scene = drawn("room_los", seed, keep_clear=[clear])
    for obstacle in scene.scene.obstacles:
        low, high = obstacle.bounds_m[:, :2]
        for x, y, radius_m in ((*PART_M, 0.3), clear):
            nearest = np.clip([x, y], low, high)
            assert np.hypot(*(nearest - [x, y])) >= radius_m - 1e-9


def test_a_run_places_its_furniture_anew_and_a_seed_places_it_again():
    one, again, other = drawn("room_los", 1), drawn("room_los", 1), drawn("room_los", 2)
    places = [[o.T_scene_obstacle.tolist() for o in scene.scene.obstacles] for scene in (one, again, other)]
    assert places[0] == places[1]
    assert places[0] != places[2]


def test_the_board_stands_between_reader_and_part_and_the_chair_over_the_part():
    names = {obstacle.name for obstacle in drawn("room_nlos").scene.obstacles}
    board = next(o for o in drawn("room_nlos").scene.obstacles if o.name.startswith("board"))
    assert np.allclose(board.T_scene_obstacle[:2, 3], (np.array(PART_M) + READER_M) / 2)
    assert board.shape.size_m[2] == pytest.approx(2.2) or sorted(board.shape.size_m)[1:] == pytest.approx([1.5, 2.2])
    assert sum(name.startswith("chair") for name in names) > sum(
        o.name.startswith("chair") for o in drawn("room_los").scene.obstacles
    )


@pytest.mark.parametrize("missing", [{"part_m": None}, {"reader_m": None}])
def test_nothing_can_be_hidden_without_knowing_where_it_is(missing):
    places = {"part_m": PART_M, "reader_m": READER_M, **missing}
    with pytest.raises(SceneError):
        load_recipe("room_nlos").draw(np.random.default_rng(0), **places)


def test_a_room_too_full_is_refused_and_not_searched_for_ever():
    with pytest.raises(SceneError) as caught:
        drawn("room_los", keep_clear=[(3.0, 2.5, 5.0)])
    assert "no room" in caught.value.message


@pytest.mark.parametrize(
    "text",
    ["", "{", "[]", '{"schema": "rfcompass-recipe/2", "name": "x"}', '{"schema": "rfcompass-recipe/1"}',
     '{"schema": "rfcompass-recipe/1", "name": "x", "furniture": [{"name": "f", "count": 1.5, "parts": []}]}'],
)  # fmt: skip
def test_a_broken_recipe_is_refused_with_its_file(text, tmp_path):
    path = tmp_path / "scene.json"
    path.write_text(text)
    with pytest.raises(SceneError) as caught:
        load_recipe(path)
    assert caught.value.numbers["file"] == str(path)


def test_an_unknown_recipe_lists_those_that_are_shipped():
    with pytest.raises(SceneError) as caught:
        load_recipe("moon")
    assert caught.value.numbers["known"] == list(SCENES)


def test_a_users_recipe_is_used_as_it_is(tmp_path):
    path = tmp_path / "mine.json"
    path.write_text(json.dumps({"schema": "rfcompass-recipe/1", "name": "mine", "scatterers": {
        "count": 3, "cross_section_m2": [0.1, 0.2], "low_m": [0, 0, 0], "high_m": [1, 1, 1]}}))  # fmt: skip
    scene = load_recipe(path).draw(np.random.default_rng(0))
    assert len(scene.scatterers) == 3
    assert recipe_from_json(json.loads(path.read_text())).name == "mine"


def test_scatterers_that_do_not_belong_together_are_refused():
    with pytest.raises(ShapeError):
        Scatterers(np.zeros((2, 3)), np.ones(1), np.zeros(2))
    with pytest.raises(ShapeError):
        Scatterers(np.zeros((1, 3)), -np.ones(1), np.zeros(1))


@given(st.floats(0.05, 2.0), st.floats(0.2, 2.0))
def test_a_square_track_is_level_closed_and_evenly_spaced(spacing_m, side_m):
    track = AntennaTrack.square((1.0, 2.0), side_m, 0.45, spacing_m)
    gaps_m = np.linalg.norm(np.diff(track.positions_m, axis=0, append=track.positions_m[:1]), axis=1)
    assert np.allclose(track.positions_m[:, 2], 0.45)
    assert gaps_m.max() <= spacing_m + 1e-9
    assert np.allclose(gaps_m, gaps_m[0])
    assert np.allclose(track.rotations[:, :, 0], [0.0, 0.0, -1.0])
