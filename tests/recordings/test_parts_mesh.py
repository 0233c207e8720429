"""A part from a mesh: the physics does not depend on how the file was drawn, and a bad file stores nothing."""

import sys

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st

from rfcompass.errors import PartError
from rfcompass.recordings.parts import PartDatabase, part_from_mesh
from rfcompass.recordings.parts import mesh as mesh_module
from rfcompass.types.shapes import Box

LEG_M = np.array([0.4, 0.06, 0.05])


def drawn(folder, mesh, name="part.ply"):
    path = folder / name
    mesh.export(path)
    return path


def a_leg(T=None):
    leg = trimesh.creation.box(LEG_M)
    return leg if T is None else leg.apply_transform(T)


def an_angle():
    """A concave prism of two equal limbs: L-shaped, 0.1 m long, 0.02 m thick, 0.02 m high."""
    corners = np.array([[0, 0], [0.1, 0], [0.1, 0.02], [0.02, 0.02], [0.02, 0.1], [0, 0.1]])
    floor = [[0, 2, 1], [0, 3, 2], [0, 4, 3], [0, 5, 4]]
    walls = [[i, (i + 1) % 6, (i + 1) % 6 + 6] for i in range(6)] + [[i, (i + 1) % 6 + 6, i + 6] for i in range(6)]
    roof = [[a + 6, c + 6, b + 6] for a, b, c in floor]
    vertices = np.vstack([np.column_stack([corners, np.full(6, z)]) for z in (0, 0.02)])
    return trimesh.Trimesh(vertices, floor + walls + roof, process=False)


def a_motion(seed):
    T = np.array(trimesh.transformations.random_rotation_matrix(np.random.default_rng(seed).random(3)))
    T[:3, 3] = np.random.default_rng(seed).normal(size=3)
    return T


def test_a_box_drawn_as_a_mesh_is_the_box(tmp_path):
    part = part_from_mesh(drawn(tmp_path, a_leg()), "leg", density_kg_m3=700)
    box = Box(LEG_M)
    assert np.allclose(part.size_m, LEG_M)
    assert np.isclose(part.mass_kg, 700 * box.volume_m3)
    assert np.allclose(part.inertia_kg_m2, part.mass_kg * box.inertia_per_mass_m2, atol=1e-9)
    assert np.isclose(part.grasp_width_m, 0.06)
    assert np.isclose(part.resting_height_m, 0.025)  # it lies on the wider side
    assert part.shape.pieces_by == "convex"
    assert np.allclose(part.shape.T_part_file, np.eye(4))


@settings(max_examples=15)
@given(st.integers(0, 10**6))
def test_the_part_does_not_depend_on_the_frame_it_was_drawn_in(tmp_path_factory, seed):
    folder = tmp_path_factory.mktemp("drawing")
    part = part_from_mesh(drawn(folder, a_leg(a_motion(seed))), "leg", density_kg_m3=700)
    box = Box(LEG_M)
    assert np.allclose(part.size_m, LEG_M, atol=1e-6)
    assert np.allclose(part.inertia_kg_m2, part.mass_kg * box.inertia_per_mass_m2, rtol=1e-4, atol=1e-8)


def test_a_place_in_the_drawing_is_found_on_the_part(tmp_path):
    T = a_motion(3)
    end_m = (T @ [0.2, 0, 0, 1])[:3]
    part = part_from_mesh(drawn(tmp_path, a_leg(T)), "leg", density_kg_m3=700)
    assert np.allclose(np.abs(part.shape.from_file_m(end_m[None])), [[0.2, 0, 0]], atol=1e-6)


@pytest.mark.parametrize("suffix", ["stl", "obj", "ply", "off"])
@pytest.mark.parametrize(("unit", "scale"), [("m", 1), ("cm", 100), ("mm", 1000), ("inch", 1 / 0.0254)])
def test_every_format_and_unit_gives_the_same_part(tmp_path, suffix, unit, scale):
    path = drawn(tmp_path, a_leg().apply_scale(scale), f"leg.{suffix}")
    part = part_from_mesh(path, "leg", density_kg_m3=700, unit=unit)
    assert np.allclose(part.size_m, LEG_M, rtol=1e-5)
    assert np.isclose(part.mass_kg, 700 * np.prod(LEG_M), rtol=1e-5)


def test_stable_poses_stand_on_the_support_and_their_probabilities_sum_to_one(tmp_path):
    part = part_from_mesh(drawn(tmp_path, a_leg(a_motion(5))), "leg", density_kg_m3=700)
    assert np.isclose(sum(pose.probability for pose in part.stable_poses), 1.0)
    assert [pose.probability for pose in part.stable_poses] == sorted(
        (pose.probability for pose in part.stable_poses), reverse=True
    )
    for pose in part.stable_poses:
        heights = part.shape.vertices_m @ pose.T_support_part[2, :3] + pose.height_m
        assert np.isclose(heights.min(), 0.0, atol=1e-7)
        assert np.isclose(pose.height_m, LEG_M / 2, atol=1e-6).any()
    assert np.isclose(part.stable_poses[0].height_m, part.resting_height_m, atol=1e-6)


def test_a_concave_shape_is_cut_into_convex_pieces(tmp_path):
    pytest.importorskip("vhacdx", reason="vhacdx is not installed, so no decomposition can be made")
    angle = an_angle()
    part = part_from_mesh(drawn(tmp_path, angle), "angle", density_kg_m3=1000)
    pieces = [trimesh.convex.convex_hull(np.array(piece)) for piece in part.shape.pieces_m]
    assert part.shape.pieces_by == "vhacd"
    assert len(pieces) >= 2
    assert np.isclose(sum(piece.volume for piece in pieces), angle.volume, rtol=0.1)
    hull = angle.convex_hull.volume
    assert hull > 1.5 * angle.volume  # so the hull would have failed the line above
    assert np.isclose(part.mass_kg, 1000 * angle.volume)


def test_without_the_decomposition_the_hull_stands_in_and_says_so(tmp_path, monkeypatch, caplog):
    monkeypatch.setitem(sys.modules, "vhacdx", None)
    part = part_from_mesh(drawn(tmp_path, an_angle()), "angle", density_kg_m3=1000)
    assert part.shape.pieces_by == "hull"
    assert len(part.shape.pieces_m) == 1
    assert "hull stands for" in caplog.text


def test_a_shape_with_many_facets_is_thinned_out_but_still_stands_on_the_support(tmp_path, monkeypatch):
    monkeypatch.setattr(mesh_module, "HULL_CORNERS", 60)
    ball = trimesh.creation.icosphere(3, radius=0.05).apply_scale([1, 1, 0.5])
    part = part_from_mesh(drawn(tmp_path, ball), "pebble", density_kg_m3=1000)
    assert len(part.stable_poses) <= mesh_module.MAX_POSES
    assert np.isclose(part.resting_height_m, 0.025, rtol=0.02)
    for pose in part.stable_poses:
        heights = part.shape.vertices_m @ pose.T_support_part[2, :3] + pose.height_m
        assert np.isclose(heights.min(), 0.0, atol=1e-9)


def test_an_open_surface_is_refused_unless_its_hull_will_do(tmp_path):
    closed = a_leg()
    path = drawn(tmp_path, trimesh.Trimesh(closed.vertices, closed.faces[:-1], process=False))
    with pytest.raises(PartError, match="not closed"):
        part_from_mesh(path, "leg", density_kg_m3=700)
    part = part_from_mesh(path, "leg", density_kg_m3=700, allow_open=True)
    assert np.isclose(part.mass_kg, 700 * closed.volume)
    assert part.shape.pieces_by == "hull"


def test_a_surface_that_is_inside_out_is_turned(tmp_path):
    leg = a_leg()
    path = drawn(tmp_path, trimesh.Trimesh(leg.vertices, leg.faces[:, ::-1], process=False))
    part = part_from_mesh(path, "leg", density_kg_m3=700)
    assert np.isclose(part.mass_kg, 700 * leg.volume)
    assert np.allclose(part.size_m, LEG_M)


def bad_files(folder):
    flat = trimesh.Trimesh([[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0]], [[0, 1, 2], [1, 3, 2]], process=False)
    garbage, empty, scene = folder / "garbage.stl", folder / "empty.obj", folder / "leg.dae"
    garbage.write_bytes(b"\x00\xff" * 60)
    empty.write_text("# nothing\n")
    scene.write_text("<COLLADA/>")
    overlapping = trimesh.util.concatenate([a_leg(), a_leg().apply_translation((0.05, 0, 0))])
    truncated = drawn(folder, a_leg(), "truncated.stl")
    truncated.write_bytes(truncated.read_bytes()[:-30])
    return {
        "missing": folder / "missing.stl",
        "garbage": garbage,
        "empty": empty,
        "suffix": scene,
        "truncated": truncated,
        "overlapping": drawn(folder, overlapping, "overlapping.ply"),
        "flat": drawn(folder, flat, "flat.ply"),
        "millimetres": drawn(folder, a_leg().apply_scale(1000), "mm.stl"),
    }


@pytest.mark.parametrize(
    "name", ["missing", "garbage", "empty", "suffix", "truncated", "overlapping", "flat", "millimetres"]
)
def test_a_bad_file_is_named_and_nothing_is_stored(tmp_path, name):
    path = bad_files(tmp_path)[name]
    with PartDatabase(":memory:") as database:
        before = database.part_ids()
        with pytest.raises(PartError) as caught:
            database.add(part_from_mesh(path, "leg", density_kg_m3=700))
        assert database.part_ids() == before
    assert caught.value.numbers["file"] == path.name


@pytest.mark.parametrize("changes", [{"density_kg_m3": 0.0}, {"density_kg_m3": np.nan}, {"unit": "furlong"}])
def test_arguments_that_cannot_be_are_refused(tmp_path, changes):
    with pytest.raises(PartError):
        part_from_mesh(drawn(tmp_path, a_leg()), "leg", **{"density_kg_m3": 700, **changes})


def test_a_part_from_a_mesh_is_kept_with_all_its_corners(tmp_path):
    part = part_from_mesh(drawn(tmp_path, an_angle()), "angle", density_kg_m3=1000)
    with PartDatabase(":memory:") as database:
        database.add(part)
        stored = database.part("angle")
    assert np.array_equal(stored.shape.vertices_m, part.shape.vertices_m)
    assert np.array_equal(stored.shape.triangles, part.shape.triangles)
    assert all(np.array_equal(a, b) for a, b in zip(stored.shape.pieces_m, part.shape.pieces_m, strict=True))
