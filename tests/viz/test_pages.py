"""Pages stand alone, say what they were given, and are the same bytes for the same content."""

import re

import meshcat.geometry as shapes
import numpy as np
import pytest
from matplotlib.figure import Figure

from rfcompass.geometry import Pose2
from rfcompass.recordings import PartDatabase
from rfcompass.robots import YouBot
from rfcompass.types import PartEstimate, ReachMap, TagFix
from rfcompass.viz.meshcat_page import RecordingWindow, scene_html, write_scene
from rfcompass.viz.page import PageFigure, PageTable, page_html, write_page
from rfcompass.viz.robot_scene import RobotScene
from rfcompass.viz.sweep_figures import draw_survey

SHARE = np.array([0.0, 0.5, 1.0, 0.0]).reshape(2, 2, 1)
REACH = ReachMap(np.array([0.3, 0.0, 0.1]), 0.1, SHARE)


def a_figure():
    figure = Figure()
    figure.add_subplot().plot([0, 1])
    return figure


def a_scene():
    robot, leg = YouBot(), PartDatabase(":memory:").part("table_leg_3")
    scene = RobotScene()
    scene.draw_robot([robot.visual_shapes(robot.posture(name)) for name in ("folded", "scan")])
    region = np.array([[0.5, -0.1], [0.7, -0.1], [0.7, 0.1]])
    estimate = PartEstimate(leg.part_id, np.array([0.6, 0.0]), 0.3, "partition", 1, region_m=region)
    scene.draw_estimate(estimate, Pose2(1.0, 0.0, 0.0), leg, leg.layout(4).points_m)
    scene.draw_reach(REACH, Pose2(1.0, 0.0, 0.5))
    scene.draw_path("base", np.array([[0.0, 0.0], [1.0, 0.0]]))
    return scene.window


def outside_addresses(html):
    """Addresses that a browser would load; the names of XML languages are none."""
    found = re.findall(r"""(?:src|href)\s*=\s*["']([^"']+)""", html) + re.findall(r"https?://[\w./-]+", html)
    return [address for address in found if not address.startswith(("data:", "http://www.w3.org/"))]


def test_a_page_needs_no_other_file_or_address():
    parts = [PageFigure("a line", a_figure()), PageTable("numbers", ("a", "b"), [(1, 2)]), "text"]
    assert outside_addresses(page_html("title", parts)) == []


def test_a_scene_needs_no_other_file_or_address():
    assert outside_addresses(scene_html(a_scene(), "title")) == []


def test_what_is_written_on_a_page_cannot_become_markup():
    html = page_html("<b>", ["<script>", PageTable("<i>", ("<u>",), [("<s>",)])])
    for tag in ("<b>", "<script>", "<i>", "<u>", "<s>"):
        assert tag not in html.split("</style>")[1]


def test_the_same_scene_is_the_same_bytes():
    assert scene_html(a_scene(), "title") == scene_html(a_scene(), "title")


def test_objects_are_numbered_in_order_of_appearance():
    window = RecordingWindow()
    window.visualizer()["box"].set_object(shapes.Box([1, 1, 1]))
    drawn = window.commands[0]["object"]
    assert drawn["object"]["geometry"] == drawn["geometries"][0]["uuid"] == "object-0"
    assert drawn["object"]["material"] == drawn["materials"][0]["uuid"] == "object-1"


def test_reach_is_a_point_in_each_voxel_that_is_reached_red_to_green():
    scene = RobotScene()
    scene.draw_reach(REACH, Pose2())
    (drawn,) = [
        row["object"] for row in scene.window.commands if row.get("path", "").endswith("/reach") and "object" in row
    ]
    attributes = drawn["geometries"][0]["data"]["attributes"]
    points, colours = (np.frombuffer(attributes[name]["array"].data, np.float32) for name in ("position", "color"))
    assert points.reshape(-1, 3) == pytest.approx(np.array([[0.3, 0.1, 0.1], [0.4, 0.0, 0.1]]))
    assert colours.reshape(-1, 3)[:, :2] == pytest.approx(np.array([[0.5, 0.5], [0.0, 1.0]]))


def test_a_page_is_written_whole_or_not_at_all(tmp_path):
    target = tmp_path / "page.html"
    write_scene(target, a_scene(), "title")
    before = target.read_bytes()
    with pytest.raises(AttributeError):
        write_page(target, "title", [PageFigure("broken", None)])
    assert target.read_bytes() == before
    assert [path.name for path in tmp_path.iterdir()] == ["page.html"]


def test_every_tag_is_on_the_survey_picture():
    fixes = [TagFix(f"00{i}", np.array([0.1 * i, 0.7, 0.0]), np.full(3, 0.1), i > 0) for i in range(3)]
    axes = draw_survey(np.zeros((2, 3)), fixes, "rail").axes[0]
    assert {text.get_text() for text in axes.texts} == {f"…{fix.epc}" for fix in fixes}
