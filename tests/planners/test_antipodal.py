"""Antipodal grasps: contacts are opposite points of the surface, friction holds there, and nothing comes twice."""

import numpy as np
import pytest
import trimesh
from hypothesis import given
from hypothesis import strategies as st

from planners.antipodal import AntipodalRules, antipodal_grasps, tool_rotation, turn, without_twins
from planners.contact_pairs import closed_surface, contact_pairs
from rfcompass import YouBot
from rfcompass.errors import PartError
from rfcompass.recordings.parts.mesh import part_from_mesh
from rfcompass.robots import Tool
from rfcompass.types import Box, Cylinder, Mesh, Sphere

TOOL = YouBot().tool
LEG = Box(np.array([0.40, 0.05, 0.05]))
SOLIDS = {
    "box": LEG,
    "lying": Cylinder(0.02, 0.3, "x"),
    "standing": Cylinder(0.02, 0.2, "z"),
    "ball": Sphere(0.025),
}
# Radius [m] of a turned leg, against the height [m]: it has waists, so it is not convex.
PROFILE = [[0, -0.2], [0.02, -0.2], [0.025, -0.1], [0.015, 0.0], [0.022, 0.1], [0.012, 0.2], [0, 0.2]]


@pytest.fixture(scope="module")
def turned(tmp_path_factory):
    file = tmp_path_factory.mktemp("parts") / "leg.stl"
    trimesh.creation.revolve(np.array(PROFILE), sections=48).export(file)
    return part_from_mesh(file, "turned_leg", density_kg_m3=500.0).shape


def grasps(shape, seed=0, opening_m=0.075, friction=0.5, **rules):
    rng = np.random.default_rng(seed)
    return antipodal_grasps(shape, TOOL, opening_m=opening_m, friction=friction, rng=rng, rules=AntipodalRules(**rules))


def good(shape, **asked):
    return [row for row in grasps(shape, **asked) if row.rejection is None]


def axes(candidate):
    R = candidate.T_part_hand[:3, :3]
    return R @ TOOL.approach_axis, R @ TOOL.closing_axis


def pairs(shape, seed=0):
    return contact_pairs(shape, spacing_m=0.025, headings=8, samples=400, rng=np.random.default_rng(seed))


@pytest.mark.parametrize("name", SOLIDS)
def test_every_pair_lies_on_the_surface_of_a_solid(name):
    shape = SOLIDS[name]
    for pair in pairs(shape):
        for sign in (1, -1):
            point = pair.middle_m + sign * pair.width_m / 2 * pair.closing
            assert surface_distance(shape, point) == pytest.approx(0, abs=1e-9)
        assert np.linalg.norm(pair.closing) == pytest.approx(1)


def surface_distance(shape, point):
    """Signed distance of a point from the surface of a box, cylinder or ball."""
    match shape:
        case Box():
            return np.max(np.abs(point) - shape.size_m / 2)
        case Sphere():
            return np.linalg.norm(point) - shape.radius_m
        case Cylinder(axis="x"):
            along, across = point[0], np.linalg.norm(point[1:])
        case Cylinder():
            along, across = point[2], np.linalg.norm(point[:2])
    return max(across - shape.radius_m, abs(along) - shape.length_m / 2)


def test_pairs_on_a_turned_leg_lie_on_its_surface_and_follow_its_waist(turned):
    surface = closed_surface(turned)
    found = pairs(turned)
    ends = np.array([pair.middle_m + s * pair.width_m / 2 * pair.closing for pair in found for s in (1, -1)])
    _, distance, _ = trimesh.proximity.closest_point(surface, ends)
    assert distance.max() < 1e-4
    level = [pair for pair in found if abs(pair.closing[1]) > 0.99]
    widths = [pair.width_m for pair in level]
    assert min(widths) < 0.035 < 0.045 < max(widths)  # the waist and the belly


def test_normals_of_a_mesh_are_judged_as_they_are(turned):
    surface = closed_surface(turned)
    for pair in pairs(turned):
        ends = [pair.middle_m + s * pair.width_m / 2 * pair.closing for s in (1, -1)]
        _, _, faces = trimesh.proximity.closest_point(surface, np.array(ends))
        cosines = [surface.face_normals[face] @ (s * pair.closing) for s, face in zip((1, -1), faces, strict=True)]
        # A point on an edge belongs to two faces; one facet of the turned leg is 7.5 degrees.
        assert np.arccos(np.clip(min(cosines), -1, 1)) == pytest.approx(pair.angle_rad, abs=np.deg2rad(16))


@pytest.mark.parametrize("name", [*SOLIDS, "turned"])
def test_what_is_left_opens_wide_enough_and_is_a_pose(name, turned):
    shape = turned if name == "turned" else SOLIDS[name]
    found = good(shape)
    assert found
    for row in found:
        R = row.T_part_hand[:3, :3]
        assert pytest.approx(np.eye(3), abs=1e-9) == R @ R.T
        assert np.linalg.det(R) == pytest.approx(1)
        assert 0 < row.score <= 1
        approach, closing = axes(row)
        assert approach @ closing == pytest.approx(0, abs=1e-9)


@pytest.mark.parametrize("name", [*SOLIDS, "turned"])
def test_no_grasp_comes_twice_nor_with_the_jaws_swapped(name, turned):
    found = good(turned if name == "turned" else SOLIDS[name])
    swapped = tool_rotation(Tool("tool", TOOL.approach_axis, -TOOL.closing_axis), *[np.eye(3)[k] for k in (2, 1)])
    assert pytest.approx(swapped) == np.diag([-1.0, -1.0, 1.0])
    assert len(without_twins(found, TOOL)) == len(found)
    twins = [row.__class__(row.T_part_hand @ half_turn(), row.aperture_m, row.score) for row in found]
    assert len(without_twins([*found, *twins], TOOL)) == len(found)


def half_turn():
    T = np.eye(4)
    T[:3, :3] = turn(TOOL.approach_axis, np.pi)
    return T


def test_equal_generators_give_equal_grasps_and_others_do_not(turned):
    first, again, other = (np.array([row.T_part_hand for row in grasps(turned, seed)]) for seed in (3, 3, 4))
    assert np.array_equal(first, again)
    assert first.shape != other.shape or not np.array_equal(first, other)


def test_contacts_spread_along_the_leg_and_from_above_the_hand_closes_across():
    above = [row for row in good(LEG, yaws_rad=()) if axes(row)[0][2] < -0.999]
    places = sorted(row.T_part_hand[0, 3] for row in above)
    assert places == pytest.approx(np.arange(-7, 8) * 0.025)
    for row in above:
        assert abs(axes(row)[1][1]) == pytest.approx(1)  # across, never along its 0.40 m


def test_a_tall_box_is_offered_near_its_top_and_a_plate_near_its_edges():
    tall = [row.T_part_hand[2, 3] for row in good(Box(np.array([0.06, 0.05, 0.3])))]
    assert max(tall) > 0.12
    plate = [row for row in good(Box(np.array([0.3, 0.2, 0.02]))) if abs(axes(row)[1][2]) > 0.99]
    assert max(abs(row.T_part_hand[1, 3]) for row in plate) >= 0.09


def test_pitched_grasps_lie_in_the_plane_across_the_jaws():
    pitched = [row for row in good(LEG) if abs(axes(row)[0][2]) < 0.99 and abs(axes(row)[1][2]) < 1e-6]
    steepness = {round(np.rad2deg(np.arccos(-axes(row)[0][2]))) for row in pitched}
    assert steepness == {15, 30, 45, 60, 75, 90}


def test_the_tool_never_goes_into_the_support():
    for shape in (Box(np.array([0.2, 0.04, 0.012])), LEG, Sphere(0.02)):
        low = min(row.T_part_hand[2, 3] for row in good(shape))
        assert low >= shape.lower_m[2] + 0.003 - 1e-12


@given(width_m=st.floats(0.01, 0.2), opening_m=st.floats(0.02, 0.12))
def test_too_wide_is_exactly_what_the_jaws_do_not_get_around(width_m, opening_m):
    found = grasps(Box(np.array([0.5, width_m, 0.5])), opening_m=opening_m)
    fits = width_m <= opening_m - AntipodalRules().slack_m
    assert any(row.rejection is None for row in found) == fits
    for row in found:
        if row.rejection is not None:
            assert row.rejection.kind == "too_wide"
            numbers = dict(row.rejection.numbers)
            assert numbers["width_m"] > numbers["opening_m"]


def test_slippery_jaws_leave_fewer_grasps_of_a_turned_leg(turned):
    counts = [len(good(turned, friction=friction)) for friction in (0.02, 0.2, 0.6)]
    assert counts[0] < counts[1] < counts[2]
    kinds = {row.rejection.kind for row in grasps(turned, friction=0.02) if row.rejection is not None}
    assert "outside_friction_cone" in kinds


def test_a_fork_is_grasped_by_a_prong_not_across_the_gap():
    boxes = [trimesh.creation.box([0.2, 0.01, 0.03]), trimesh.creation.box([0.2, 0.01, 0.03])]
    boxes[1].apply_translation([0, 0.06, 0])
    fork = trimesh.util.concatenate(boxes)
    piece = np.asarray(fork.convex_hull.vertices)
    shape = Mesh(fork.vertices, fork.faces, (piece,), "hull", np.eye(4))
    level = [pair for pair in pairs(shape) if abs(pair.closing[1]) > 0.99]
    assert level
    assert max(pair.width_m for pair in level) < 0.011


def open_box(pieces):
    box = trimesh.creation.box([0.2, 0.04, 0.04])
    corners = np.asarray(box.vertices)
    return Mesh(corners, np.asarray(box.faces)[2:], (corners,) * pieces, "hull", np.eye(4))


def test_a_mesh_with_holes_is_its_hull_or_no_answer():
    widths = {round(pair.width_m, 6) for pair in pairs(open_box(1)) if abs(pair.closing[1]) > 0.99}
    assert widths == {0.04}
    with pytest.raises(PartError, match="holes"):
        pairs(open_box(2))


def test_rules_that_cannot_be_are_refused():
    for bad in ({"spacing_m": 0.0}, {"headings": 0}, {"pitches_rad": ()}, {"depth_m": np.nan}, {"slack_m": -1.0}):
        with pytest.raises(ValueError, match="AntipodalRules"):
            AntipodalRules(**bad)
