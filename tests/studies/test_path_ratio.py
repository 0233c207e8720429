"""The study of ways: no way is shorter than the straight line, and cameras that see find it."""

import numpy as np
import pyarrow as pa
import pytest

from rfcompass.errors import InputError, OutOfReach
from rfcompass.evaluation.shortest_way import outlines_m
from rfcompass.geometry import Pose2
from rfcompass.localization import ConsistencyLocalizer
from rfcompass.robots import YouBot
from rfcompass.studies.comparisons import robot_and_part
from rfcompass.studies.fetching import FetchTask, SimulatedFetch
from rfcompass.studies.path_pictures import draw_path_ratio
from rfcompass.studies.path_ratio import CAMERAS, PATH_RATIO, length_m, path_task, path_trial, touches
from rfcompass.studies.radio_setup import LYING_HEIGHT_M

CLEAR_SEED = 1  # nothing stands between robot and part


def cell(sight="in sight", way=CAMERAS):
    return {"sight": sight, "way": way}


def test_with_cameras_and_nothing_in_the_way_the_way_is_straight():
    row = path_trial(cell(), CLEAR_SEED, None)
    assert row["reached"]
    assert row["clear"]
    assert 1.0 <= row["ratio"] < 1.01
    assert row["end_m"] <= 0.61
    assert row["total_s"] == row["drive_s"]
    assert set(row) == {metric.name for metric in PATH_RATIO.metrics}


@pytest.mark.slow
@pytest.mark.parametrize("sight", ["in sight", "hidden"])
@pytest.mark.parametrize("way", ["best", CAMERAS])
def test_no_way_is_shorter_than_the_straight_line_nor_a_clear_one_than_the_shortest(sight, way):
    for seed in (1, 3) if way == CAMERAS else (1,):
        row = path_trial(cell(sight, way), seed, None)
        assert row["ratio"] is None or row["ratio"] >= 1.0
        if row["clear"] and row["ratio_around"] is not None:
            assert 1.0 - 1e-6 <= row["ratio_around"] <= row["ratio"] + 1e-6
        assert row["way_x_m"][0] == path_trial(cell(sight, CAMERAS), seed, None)["way_x_m"][0]


def test_an_end_without_the_part_has_no_ratio(monkeypatch):
    def ends(self):
        raise OutOfReach("too far")
        yield

    monkeypatch.setattr(SimulatedFetch, "navigate", ends)
    row = path_trial(cell(), CLEAR_SEED, None)
    assert (row["ended"], row["reached"], row["ratio"], row["ratio_around"]) == ("OutOfReach", False, None, None)
    assert len(row["way_x_m"]) == 1


def test_ways_of_finding_the_part_start_from_the_same_poses():
    starts = [SimulatedFetch(path_task(cell("hidden", way), 5)) for way in ("best", "paper", CAMERAS)]
    assert len({job.true_way[0] for job in starts}) == 1
    assert len({tuple(job.true_part_m) for job in starts}) == 1


def test_a_way_through_furniture_touches_it():
    job, (robot, _) = SimulatedFetch(path_task(cell("hidden"), 2)), robot_and_part()
    start, board = job.true_way[0], next(one for one in job.scene.obstacles if one.name.startswith("board"))
    through = Pose2(*board.T_scene_obstacle[:2, 3].tolist(), 0.0)
    assert touches(robot, job.scene, [start, through])
    assert not touches(robot, job.scene, [start])


def test_the_length_of_a_way_is_that_of_its_legs():
    assert length_m(np.array([[0.0, 0.0], [3.0, 4.0], [3.0, 5.0]])) == pytest.approx(6.0)
    assert length_m(np.zeros((1, 2))) == 0.0


def test_furniture_is_seen_as_it_stands():
    job = SimulatedFetch(path_task(cell(), CLEAR_SEED))
    low = [one for one in job.scene.obstacles if one.bounds_m[0, 2] < LYING_HEIGHT_M]
    assert len(outlines_m(job.scene.obstacles, LYING_HEIGHT_M, 0.1)) == len(low) > 0


@pytest.mark.parametrize("options", [{"cameras": True}, {"map_pose": "radio"}])
def test_a_map_or_cameras_need_a_room(options):
    with pytest.raises(InputError):
        FetchTask(robot=YouBot(), part=robot_and_part()[1], tags=2, localizer=ConsistencyLocalizer(), seed=1, **options)


def test_a_pose_from_cameras_needs_cameras():
    task = path_task(cell(way="best"), 1)
    with pytest.raises(InputError, match="cameras"):
        FetchTask(
            robot=task.robot, part=task.part, tags=2, localizer=task.localizer, seed=1, radio=task.radio,
            map_pose="cameras",
        )  # fmt: skip


def test_the_figures_show_ratios_and_the_ways_of_one_run():
    rows = [
        {"seed": 1, **cell(sight), "ratio": 1.05, "ended": "in reach", "way_x_m": [5.0, 4.0], "way_y_m": [2.4, 2.3]}
        for sight in ("in sight", "hidden")
    ]
    figures = draw_path_ratio(pa.Table.from_pylist(rows))
    assert len(figures) == 2
    shares, ways = figures.values()
    assert [axes.get_title(loc="left") for axes in shares.axes] == ["in sight", "hidden"]
    assert all(axes.patches for axes in ways.axes)
