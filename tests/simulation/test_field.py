"""The one-way field: it is the reference's, and it keeps the laws."""

import dataclasses

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from reference_channel import reference_field

from rfcompass.errors import InputError
from rfcompass.rf.waves import wavelength, wavenumber
from rfcompass.simulation import (
    DUAL_DIPOLE,
    PATCH_CIRCULAR,
    PATCH_DUAL,
    SQUIGGLE,
    VERT900,
    AntennaModel,
    AntennaTrack,
    PlacedTags,
    RadioScene,
    Scatterers,
    image_indices,
    load_recipe,
    one_way_field,
)
from rfcompass.types.scene import Material, Obstacle, Room, Scene
from rfcompass.types.shapes import Box, Cylinder

F_HZ = np.array([902e6, 915e6, 928e6])
FREE = RadioScene(Scene("free"))
ISOTROPIC = AntennaModel()


def some_tags(rng, low_m, high_m, count=2, model=SQUIGGLE):
    points_m = rng.uniform(low_m, high_m, (count, 3))
    return PlacedTags.draw([f"{i:02x}" for i in range(count)], points_m, rng.normal(size=(count, 3)), model, rng)


def upright(points_m, model=SQUIGGLE):
    count = len(points_m)
    z = np.tile([0.0, 0.0, 1.0], (count, 1))
    return PlacedTags(tuple(f"{i:02x}" for i in range(count)), points_m, z, model, np.zeros(count), np.zeros(count))


def turned_track(rng, low_m, high_m, count=2):
    turns = np.linalg.qr(rng.normal(size=(count, 3, 3)))[0]
    turns *= np.linalg.det(turns)[:, None, None]  # -R of a reflection is a rotation in three dimensions
    return AntennaTrack(rng.uniform(low_m, high_m, (count, 3)), turns, np.arange(1, count + 1))


def field(radio_scene, track, antenna, tags, f_hz=F_HZ):
    return one_way_field(radio_scene, track.positions_m, track.rotations, antenna, tags, f_hz, track.ports)


def close(one, other, rtol=1e-9):
    return np.abs(one - other).max() <= rtol * np.abs(other).max()


@pytest.mark.parametrize(
    ("scene", "antenna", "model"),
    [
        ("free_space", ISOTROPIC, SQUIGGLE),
        ("room_los", VERT900, SQUIGGLE),
        ("room_nlos", PATCH_CIRCULAR, DUAL_DIPOLE),
        ("room_nlos", VERT900, SQUIGGLE),
        ("tabletop", PATCH_DUAL, DUAL_DIPOLE),
    ],
)
def test_the_kernels_agree_with_the_slow_reference(scene, antenna, model):
    rng = np.random.default_rng(3)
    recipe = load_recipe(scene)
    drawn = recipe.draw(rng, part_m=(2.5, 2.5), reader_m=(1.0, 1.0))
    some = Scatterers.draw(rng.uniform(0.5, 2.0, (2, 3)), (0.05, 0.5), rng)
    drawn = dataclasses.replace(drawn, scatterers=some)
    track, tags = turned_track(rng, 0.3, 1.8), some_tags(rng, (2.0, 2.0, 0.02), (3.0, 3.0, 0.3), model=model)
    expected = reference_field(drawn, track, antenna, tags, F_HZ[:2])
    assert close(field(drawn, track, antenna, tags, F_HZ[:2]), expected)


@settings(max_examples=10, deadline=None)
@given(st.integers(0, 10_000))
def test_the_kernels_agree_with_the_reference_among_boxes_and_cylinders_at_any_turn(seed):
    rng = np.random.default_rng(seed)
    lossy = {"m": Material("m", rng.uniform(1.0, 6.0), rng.uniform(0, 30), rng.uniform(0, 10)), "metal": METAL}
    obstacles = []
    for i in range(4):
        R = np.linalg.qr(rng.normal(size=(3, 3)))[0]
        T = np.eye(4)
        T[:3, :3], T[:3, 3] = R * np.linalg.det(R), rng.uniform(0.5, 2.5, 3)
        shape = Box(rng.uniform(0.1, 1.0, 3)) if i % 2 else Cylinder(rng.uniform(0.05, 0.4), 0.7, "xz"[i // 2])
        obstacles.append(Obstacle(f"o{i}", shape, T, "m"))
    room = Room(np.array([3.0, 3.2, 2.9]), "m", "metal", "m")
    scene = RadioScene(Scene("s", room, tuple(obstacles), lossy), order=2)
    track, tags = turned_track(rng, 0.1, 2.8), some_tags(rng, 0.1, 2.8)
    assert close(
        field(scene, track, VERT900, tags, F_HZ[:1]), reference_field(scene, track, VERT900, tags, F_HZ[:1]), 1e-8
    )


METAL = Material("metal", conductor=True)


@given(st.floats(0.3, 10.0))
def test_one_path_is_friis(r_m):
    tags = upright(np.array([[r_m, 0.0, 0.0]]))
    h = field(FREE, AntennaTrack.at(np.zeros((1, 3))), AntennaModel(gain_dbi=2.0, pattern="dipole"), tags)
    gains = 10.0 ** ((2.0 + SQUIGGLE.gain_dbi) / 10.0)
    assert np.allclose(np.abs(h[0, 0, 0]) ** 2, gains * (wavelength(F_HZ) / (4 * np.pi * r_m)) ** 2, rtol=1e-9)
    turns = np.unwrap(np.angle(h[0, 0, 0]) + wavenumber(F_HZ) * r_m)
    assert np.allclose(turns - 2 * np.pi * np.round(turns / (2 * np.pi)), 0.0, atol=1e-6)


@settings(max_examples=25)
@given(st.integers(0, 10_000))
def test_there_and_back_are_the_same(seed):
    """A linear dipole as the antenna and one as the tag change places: images, scatterers and obstacles included."""
    rng = np.random.default_rng(seed)
    scene = load_recipe("room_los").draw(rng, part_m=(3.0, 3.0))
    whip = AntennaModel(gain_dbi=SQUIGGLE.gain_dbi, pattern="dipole")
    a, b = rng.uniform((0.5, 0.5, 0.1), (5.5, 4.5, 2.0), (2, 3))
    there = field(scene, AntennaTrack.at(a[None]), whip, upright(b[None]))
    back = field(scene, AntennaTrack.at(b[None]), whip, upright(a[None]))
    assert close(there, back)


@settings(max_examples=20)
@given(st.integers(0, 10_000), st.floats(-3.0, 3.0))
def test_turning_everything_together_changes_nothing(seed, angle_rad):
    rng = np.random.default_rng(seed)
    some, tags, track = Scatterers.draw(rng.normal(size=(3, 3)), (0.05, 0.5), rng), some_tags(rng, 1.0, 2.0), None
    track = turned_track(rng, -2.0, -1.0)
    c, s = np.cos(angle_rad), np.sin(angle_rad)
    R = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]]) @ np.array([[1, 0, 0], [0, s, c], [0, -c, s]])
    moved = Scatterers(some.points_m @ R.T, some.cross_section_m2, some.phase_rad, some.axes @ R.T, some.depolarisation)
    there = AntennaTrack(track.positions_m @ R.T, R @ track.rotations, track.ports)
    one = field(FREE.with_scatterers(some), track, PATCH_CIRCULAR, tags)
    turned = tags.moved(tags.points_m @ R.T, tags.dipoles @ R.T)
    assert close(field(FREE.with_scatterers(moved), there, PATCH_CIRCULAR, turned), one)


@settings(max_examples=25)
@given(st.integers(0, 10_000))
def test_a_metal_floor_is_the_mirrored_world(seed):
    """Image theory: a vertical dipole over a perfect conductor is the dipole and its equal image below."""
    rng = np.random.default_rng(seed)
    a, b = rng.uniform((1.0, 1.0, 0.1), (9.0, 9.0, 2.0), (2, 3))
    clear = {"metal": METAL, "air": Material("air")}
    room = Room(np.array([10.0, 10.0, 5.0]), "air", "metal", "air")
    over_metal = field(
        RadioScene(Scene("s", room, (), clear), order=1), AntennaTrack.at(a[None]), VERTICAL, upright(b[None])
    )
    both = upright(np.array([b, b * [1, 1, -1]]))
    pair = field(FREE, AntennaTrack.at(a[None]), VERTICAL, both)
    assert close(over_metal[:, 0], pair[:, 0] + pair[:, 1])


VERTICAL = AntennaModel(pattern="dipole")


def test_walls_of_air_do_not_exist():
    rng = np.random.default_rng(0)
    room = Room(np.array([5.0, 5.0, 3.0]), "air", "air", "air")
    scene = RadioScene(Scene("s", room, (), {"air": Material("air")}))
    track, tags = turned_track(rng, 0.5, 2.0), some_tags(rng, 2.5, 2.9)
    assert close(field(scene, track, VERT900, tags), field(FREE, track, VERT900, tags))


@given(st.floats(1.0, 8.0), st.floats(0.0, 40.0), st.floats(0.0, 15.0), st.floats(0.01, 0.5))
def test_an_obstacle_costs_and_delays_what_its_material_says(permittivity, per_m, surface_db, thick_m):
    T = np.eye(4)
    T[0, 3] = 1.0
    board = Obstacle("board", Box(np.array([thick_m, 2.0, 2.0])), T, "m")
    material = Material("m", permittivity, per_m, surface_db)
    tags, track = upright(np.array([[2.0, 0.0, 0.0]])), AntennaTrack.at(np.zeros((1, 3)))
    bare = field(FREE, track, VERTICAL, tags)
    behind = field(RadioScene(Scene("s", None, (board,), {"m": material})), track, VERTICAL, tags)
    loss = 10.0 ** (-(surface_db + per_m * thick_m) / 20.0)
    delayed = np.exp(-1j * wavenumber(F_HZ) * (np.sqrt(permittivity) - 1.0) * thick_m)
    assert np.allclose(behind, bare * loss * delayed, rtol=1e-9)
    assert (np.abs(behind) <= np.abs(bare) * (1 + 1e-12)).all()


def test_a_dipole_hears_nothing_along_its_axis_and_a_crossed_one_nothing_across():
    track = AntennaTrack.at(np.zeros((1, 3)))
    above = field(FREE, track, VERTICAL, upright(np.array([[0.0, 0.0, 1.0]])))
    assert np.abs(above).max() < 1e-12
    lying = upright(np.array([[1.0, 0.0, 0.0]])).moved(np.array([[1.0, 0.0, 0.0]]), np.array([[0.0, 1.0, 0.0]]))
    assert np.abs(field(FREE, track, VERTICAL, lying)).max() < 1e-12


@given(st.floats(0.0, 6.3))
def test_a_circular_antenna_hears_a_dipole_at_any_roll_and_its_phase_turns_with_it(roll_rad):
    ideal = AntennaModel(pattern="isotropic", polarisation="rhcp")
    points_m = np.array([[1.0, 0.0, 0.0]])
    rolled = upright(points_m).moved(points_m, np.array([[0.0, np.sin(roll_rad), np.cos(roll_rad)]]))
    track = AntennaTrack.at(np.zeros((1, 3)))
    one, other = field(FREE, track, ideal, upright(points_m)), field(FREE, track, ideal, rolled)
    assert np.allclose(np.abs(one), np.abs(other), rtol=1e-9)
    turn = np.angle(other / one)
    assert np.allclose(np.exp(1j * turn), np.exp(1j * roll_rad), atol=1e-9) or np.allclose(
        np.exp(1j * turn), np.exp(-1j * roll_rad), atol=1e-9
    )


def test_there_are_25_images_up_to_second_order_and_the_direct_path_is_first():
    assert [len(image_indices(order)) for order in range(3)] == [1, 7, 25]
    assert image_indices(2)[0].tolist() == [0, 0, 0]


@pytest.mark.parametrize(
    ("tag_m", "antenna_m", "f_hz"),
    [((7.0, 1.0, 1.0), (1.0, 1.0, 1.0), F_HZ), ((1.0, 1.0, 1.0), (1.0, 1.0, -1.0), F_HZ),
     ((1.0, 1.0, 1.0), (1.0, 1.0, 1.0), F_HZ), ((1.0, 1.0, 1.0), (2.0, 1.0, 1.0), [0.0]),
     ((1.0, 1.0, 1.0), (2.0, 1.0, 1.0), [])],
)  # fmt: skip
def test_what_is_outside_the_room_in_one_place_or_without_a_carrier_is_refused(tag_m, antenna_m, f_hz):
    scene = load_recipe("room_los").draw(np.random.default_rng(0), part_m=(3.0, 3.0))
    with pytest.raises(InputError):
        field(scene, AntennaTrack.at(np.array([antenna_m])), VERT900, upright(np.array([tag_m])), f_hz)
