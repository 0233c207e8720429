"""A grasp's page has a node and a row for everything drawn, counts what was rejected, and is the same bytes again."""

import re
from dataclasses import replace

import numpy as np
import pytest
import trimesh
from drawn_plans import LEG, REASONS, ROBOT, T_BASE_PART, a_plan, a_world, an_estimate, candidates

from rfcompass.errors import InputError
from rfcompass.geometry import Pose2
from rfcompass.recordings import part_from_mesh
from rfcompass.types import Body, Box, Cylinder, Failure, GraspFailure, ReachMap, Sphere, World
from rfcompass.types.grasps import GraspCandidate
from rfcompass.viz import colours, grasp_layers
from rfcompass.viz.grasp_view import view

REACH = ReachMap(np.array([0.3, 0.0, 0.1]), 0.1, np.full((2, 2, 1), 0.5))


def a_view(plan=None, **changes):
    given = {"part": LEG, "world": a_world(), "reach": REACH, **changes}
    return view(ROBOT, an_estimate(), plan or a_plan(), **given)


def nodes(drawn):
    """Paths that have an object, below meshcat's root."""
    paths = [row["path"] for row in drawn.window.commands if row["type"] == "set_object"]
    return {path.removeprefix("/meshcat/") for path in paths}


def counts(drawn):
    return {layer.node.rsplit("/", 1)[-1]: layer.count for layer in drawn.overlay.layers}


def test_equal_input_gives_equal_bytes(tmp_path):
    first, second = (a_view().save(tmp_path / name) for name in ("one.html", "two.html"))
    assert first.read_bytes() == second.read_bytes()


def test_everything_has_a_node_of_its_name():
    drawn = nodes(a_view())
    assert {f"candidates/rejected/{reason}" for reason in REASONS} <= drawn
    assert {"candidates/chosen", "candidates/kept", "belief/cloud", "world/crate", "part/body", "reach"} <= drawn
    assert any(node.startswith("robot/gripper_palm_link/") for node in drawn)


def test_every_row_of_the_legend_leads_to_a_node_that_is_drawn():
    shown = a_view()
    for layer in shown.overlay.layers:
        assert any(node == layer.node or node.startswith(f"{layer.node}/") for node in nodes(shown)), layer
        assert f'data-node="{layer.node}"' in shown.html()


def test_the_legend_counts_every_candidate_drawn_or_not(monkeypatch):
    monkeypatch.setattr(grasp_layers, "MOST_DRAWN", 2)
    told = counts(a_view())
    assert {reason: told[reason] for reason in REASONS} == REASONS == a_plan().reasons
    assert told["kept"] + sum(REASONS.values()) == len(candidates())
    assert told["cloud"] == 400


def test_a_failure_shows_why_and_what_was_rejected():
    rejected = tuple(row for row in candidates() if row.rejection is not None)
    drawn = a_view(GraspFailure("no_grasp", "none of <6> works", candidates=rejected))
    told = dict(drawn.overlay.facts)
    assert told["no grasp"] == "no grasp: none of <6> works"
    assert "none of &lt;6&gt; works" in drawn.html()
    assert {reason: counts(drawn)[reason] for reason in REASONS} == REASONS
    assert not drawn.overlay.stages
    assert not drawn.overlay.success_scale


def test_rejected_grasps_hide_behind_a_plan_and_not_behind_a_failure():
    rejected = tuple(row for row in candidates() if row.rejection is not None)
    for plan, shown in ((a_plan(), False), (GraspFailure("no_grasp", "none", candidates=rejected), True)):
        layers = [layer for layer in a_view(plan).overlay.layers if "/rejected/" in layer.node]
        assert [layer.shown for layer in layers] == [shown] * len(REASONS)


def test_a_plain_failure_needs_no_candidates():
    assert dict(a_view(Failure("unreachable", "too far")).overlay.facts)["no grasp"] == "unreachable: too far"


def test_hands_have_the_colour_of_their_success():
    (drawn,) = [
        row["object"] for row in a_view().window.commands
        if row["type"] == "set_object" and row["path"].endswith("candidates/kept")
    ]  # fmt: skip
    packed = drawn["geometries"][0]["data"]["attributes"]["color"]["array"].data
    colour = np.frombuffer(packed, np.float32).reshape(4, -1, 3)
    assert colour[:, 0] == pytest.approx(colours.success_rgb(np.array([0.25, 0.5, 0.75, 1.0])), abs=1e-6)
    assert np.ptp(colour, axis=1).max() == 0


def test_an_estimate_without_draws_is_an_ellipse():
    estimate = replace(an_estimate(), samples=np.zeros((0, 3)))
    drawn = view(ROBOT, estimate, part=LEG)
    assert "region/ellipse" in nodes(drawn)
    assert "belief/cloud" not in nodes(drawn)


def test_without_an_orientation_the_part_is_not_drawn():
    covariance = np.full((3, 3), np.nan)
    covariance[:2, :2] = np.eye(2) * 1e-4
    estimate = replace(an_estimate(), theta_rad=None, covariance=covariance, samples=np.zeros((0, 3)))
    drawn = view(ROBOT, estimate, Failure("no_orientation", "θ is not known"), part=LEG)
    assert "part/body" not in nodes(drawn)
    assert "θ unknown" in dict(drawn.overlay.facts)["estimate"]


def test_obstacles_of_every_shape_are_drawn_where_they_are():
    T = np.eye(4)
    T[:3, 3] = 1.0, 2.0, 3.0
    solids = {
        "box": Box(np.full(3, 0.1)),
        "ball": Sphere(0.1),
        "lying": Cylinder(0.1, 0.5),
        "standing": Cylinder(0.1, 0.5, "z"),
    }
    world = World(tuple(Body(name, solid, T) for name, solid in solids.items()))
    drawn = a_view(world=world)
    placed = {
        row["path"].rsplit("/", 1)[-1]: np.reshape(row["matrix"], (4, 4)).T
        for row in drawn.window.commands if row["type"] == "set_transform" and "/world/" in row["path"]
    }  # fmt: skip
    assert set(placed) == set(solids)
    assert all(T_world[:3, 3] == pytest.approx(T[:3, 3]) for T_world in placed.values())
    along = {name: placed[name][:3, 1] for name in ("lying", "standing")}  # meshcat's cylinders stand along y
    assert np.abs(along["lying"]) == pytest.approx([1, 0, 0])
    assert np.abs(along["standing"]) == pytest.approx([0, 0, 1])


def test_a_part_of_any_shape_is_drawn_as_it_is(tmp_path):
    profile_m = np.array([[0.0, -0.1], [0.02, -0.1], [0.01, 0.0], [0.02, 0.1], [0.0, 0.1]])
    trimesh.creation.revolve(profile_m, sections=12).export(tmp_path / "leg.stl")
    turned = part_from_mesh(tmp_path / "leg.stl", "turned_leg", density_kg_m3=500.0)
    (body,) = [
        row["object"] for row in view(ROBOT, replace(an_estimate(), part_id="turned_leg"), part=turned).window.commands
        if row["type"] == "set_object" and row["path"].endswith("part/body")
    ]  # fmt: skip
    drawn = np.frombuffer(body["geometries"][0]["data"]["attributes"]["position"]["array"].data, np.float32)
    assert drawn.reshape(-1, 3) == pytest.approx(turned.shape.vertices_m, abs=1e-6)


def test_the_part_lies_where_the_plan_says():
    drawn = a_view(a_plan(Pose2(0.3, 0.0, 0.0)))
    T = T_BASE_PART.copy()
    T[0, 3] += 0.3
    tracks = [
        clip["clip"]["tracks"] for row in drawn.window.commands if row["type"] == "set_animation"
        for clip in row["animations"] if clip["path"] == "/meshcat/part"
    ]  # fmt: skip
    first = tracks[0][0]["keys"][0]["value"]
    assert first == pytest.approx(T[:3, 3], abs=1e-6)


def test_the_motion_is_in_the_page_once():
    kinds = [row["type"] for row in a_view().window.commands]
    assert kinds.count("set_animation") == 1


def test_what_does_not_belong_together_is_refused():
    with pytest.raises(InputError, match="do not belong together"):
        view(ROBOT, replace(an_estimate(), part_id="table_leg_1"), a_plan())


def test_a_page_of_a_grasp_needs_no_other_address():
    html = a_view().html()
    found = re.findall(r"""(?:src|href)\s*=\s*["']([^"'#][^"']*)""", html) + re.findall(r"https?://[\w./-]+", html)
    assert [address for address in found if not address.startswith(("data:", "http://www.w3.org/"))] == []


def test_a_reason_is_text_whatever_it_is():
    row = GraspCandidate(np.eye(4), 0.05, rejection=Failure("<script>", "bad"))
    html = a_view(GraspFailure("no_grasp", "bad", candidates=(row,))).html()
    assert "rejected: &lt;script&gt;" in html


def test_a_live_scene_is_served_and_holds_the_candidates():
    live = a_view().show(open_browser=False)
    served = live.visualizer.static_html()
    assert live.url.startswith("http://127.0.0.1")
    assert len(served) > 500_000
    live.close()
    assert live.visualizer.window.server_proc.poll() is not None
