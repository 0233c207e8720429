"""The film and the report of a search show every action, and are one file each."""

import numpy as np
import pytest

from rfcompass.errors import InputError, ShapeError
from rfcompass.robots import load_robot
from rfcompass.types import (
    DepthView,
    ExtractionAction,
    GraspAttempt,
    InstanceMasks,
    SearchResult,
    SearchStep,
    VoxelGrid,
)
from rfcompass.types.placed_shape import PlacedShape
from rfcompass.viz.search_film import FilmedCarry, FilmedGrasp, FilmedPile, SearchFilm, draw_search
from rfcompass.viz.search_report import draw_decision, pixels_of, write_search_report

K = np.array([[100.0, 0, 40], [0, 100.0, 30], [0, 0, 1]])
DOWN = np.diag([1.0, -1.0, -1.0, 1.0])
DOWN[2, 3] = 0.6
GRID = VoxelGrid(np.array([-0.2, -0.2, 0.0]), 0.04, np.random.default_rng(0).random((10, 10, 5)))
HAND = np.array([[0.0, 1, 0, 0.02], [1, 0, 0, -0.03], [0, 0, -1, 0.05], [0, 0, 0, 1.0]])


def step(*, colour=True, grid=GRID, outcome="held"):
    labels = np.zeros((60, 80), dtype=np.int64)
    labels[20:30, 20:40], labels[30:45, 50:60] = 1, 7
    rgb = np.full((60, 80, 3), 90) if colour else None
    view = DepthView(np.full((60, 80), 0.55), K, DOWN, rgb)
    action = ExtractionAction(7, HAND, 0.06, 2.0, {1: 0.5, 7: 2.0})
    return SearchStep(
        view, InstanceMasks(labels), grid, action, grid is None, GraspAttempt(outcome, 0.04, 3.0), 2e-3, 9.0
    )


def result(*steps):
    return SearchResult("too_many_actions", "not found", steps, 30.0, 1e-3, 0)


def film(**more):
    robot = load_robot("ur5e_2f85")
    shapes = (PlacedShape("box_1", "box", np.full(3, 0.05), np.eye(4), np.ones(4)),)
    settings = {
        "T_world_base": np.eye(4),
        "times_s": (0.0, 2.0),
        "configurations": (robot.posture("scan"), robot.posture("ready")),
        "piles": (FilmedPile(0.0, shapes), FilmedPile(1.0, ())),
        "grasps": (FilmedGrasp(0.5, 1.0, HAND, GRID, "held", True), FilmedGrasp(1.0, 2.0, HAND, None, "missed", False)),
    }
    return SearchFilm(**{**settings, **more})


def test_pixels_are_where_a_pinhole_camera_shows_points():
    assert pixels_of(step().view, np.array([[0.0, 0.0, 0.1], [0.05, 0.0, 0.1]])) == pytest.approx(
        np.array([[40.0, 30.0], [50.0, 30.0]])
    )


@pytest.mark.parametrize("colour", [True, False])
@pytest.mark.parametrize("grid", [GRID, None])
def test_a_decision_shows_scores_as_shares_of_the_best(colour, grid):
    image, _ = draw_decision(step(colour=colour, grid=grid)).axes
    assert sorted(text.get_text() for text in image.texts) == ["0.25", "1.00"]


def test_the_report_has_a_row_and_a_picture_for_each_action(tmp_path):
    write_search_report(tmp_path / "report.html", result(step(), step(outcome="blocked", grid=None)), (("seed", "3"),))
    text = (tmp_path / "report.html").read_text(encoding="utf-8")
    assert text.count("<img") == 2
    assert "blocked" in text
    assert "the target" in text


def test_the_report_of_a_search_without_an_action_is_a_page_too(tmp_path):
    write_search_report(tmp_path / "report.html", result())
    assert "not found" in (tmp_path / "report.html").read_text(encoding="utf-8")


def test_the_film_has_a_mark_for_each_grasp_and_counts_the_maps():
    view = draw_search(load_robot("ur5e_2f85"), film())
    assert [mark.name for mark in view.overlay.stages] == ["1: held", "2: missed"]
    assert {layer.name: layer.count for layer in view.overlay.layers}["where the target may be"] == 1
    assert "meshcat" in view.html()


@pytest.mark.parametrize("more", [{"times_s": (), "configurations": ()}, {"piles": ()}])
def test_a_film_without_a_picture_is_refused(more):
    with pytest.raises(InputError, match="without a picture"):
        draw_search(load_robot("ur5e_2f85"), film(**more))


def test_a_film_has_the_objects_of_each_decision_as_a_layer():
    shown = FilmedGrasp(0.5, 1.0, HAND, GRID, "held", True, np.zeros((3, 3)), np.array([1.0, 0.2, -1.0]))
    hidden = FilmedGrasp(1.0, 2.0, HAND, None, "missed", False)
    view = draw_search(load_robot("ur5e_2f85"), film(grasps=(shown, hidden)))
    (layer,) = (layer for layer in view.overlay.layers if layer.node == "objects")
    assert layer.count == 1


def test_what_is_held_goes_with_the_hand_and_is_seen_only_while_it_is_held():
    box = PlacedShape("box_1", "box", np.full(3, 0.05), HAND.copy(), np.ones(4))
    high = HAND.copy()
    high[2, 3] += 0.3
    carry = FilmedCarry((0.8, 1.4), (HAND, high), (box,))
    view = draw_search(load_robot("ur5e_2f85"), film(carried=(carry,)))
    sent = [row for row in view.window.commands if "/pile/carried_0" in row.get("path", "")]
    assert [row["type"] for row in sent].count("set_object") == 1
    (own,) = (row["matrix"] for row in sent if row["type"] == "set_transform" and row["path"].endswith("box_1"))
    np.testing.assert_allclose(np.reshape(own, (4, 4)), np.eye(4), atol=1e-9)  # where the hand is, as it lay in it
    (last,) = (row["matrix"] for row in sent if row["type"] == "set_transform" and row["path"].endswith("carried_0"))
    np.testing.assert_allclose(np.reshape(last, (4, 4)).T, high, atol=1e-9)
    (moved,) = (
        clip["clip"]["tracks"]
        for row in view.window.commands[-1:]
        for clip in row["animations"]
        if clip["path"].endswith("carried_0")
    )
    assert any(track["name"] == ".position" and len(track["keys"]) == 2 for track in moved)
    (shown,) = (row["value"] for row in sent if row["type"] == "set_property" and row["property"] == "visible")
    assert not shown  # at the end


def test_a_score_for_each_point_or_none():
    with pytest.raises(ShapeError, match="scores"):
        FilmedGrasp(0.5, 1.0, HAND, GRID, "held", True, np.zeros((3, 3)), np.zeros(2))
