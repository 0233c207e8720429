"""The field of an antenna at a tag, one way, through everything that is in between.

    h(m, t, p, f) = λ/4π √(G_a G_t) Σ_paths (e · u_p) A e^{-jkL} / r

with e the polarisation vector of the field as it arrives, u_p the dipole of port p, A what obstacles leave of the
amplitude and L the electrical length of the path; see `docs/channel.md`. |h|² is the share of the power fed into the
antenna that a matched tag takes out, and by reciprocity the other way round.
"""

from itertools import product

import numpy as np
import numpy.typing as npt

from rfcompass.arrays import ComplexArray, FloatArray, IntArray, read_only
from rfcompass.errors import InputError
from rfcompass.rf.waves import wavenumber
from rfcompass.simulation.antennas import PATTERNS, AntennaModel
from rfcompass.simulation.field_kernels import (
    AntennaRows,
    RoomTable,
    ScattererTable,
    Surroundings,
    TagRows,
    add_images,
    add_scatterers,
)
from rfcompass.simulation.occlusion import obstacle_table
from rfcompass.simulation.placed_tags import PlacedTags
from rfcompass.simulation.radio_scene import RadioScene
from rfcompass.simulation.tracks import AntennaTrack


def one_way_field(
    radio_scene: RadioScene,
    positions_m: FloatArray,
    rotations: FloatArray,
    antenna: AntennaModel,
    tags: PlacedTags,
    frequencies_hz: npt.ArrayLike,
    ports: IntArray | None = None,
) -> ComplexArray:
    """Transfer from an antenna to every tag, or back.

    Args:
        radio_scene: What is in between.
        positions_m: Phase centre of the antenna at each place, scene frame [m], shape (M, 3).
        rotations: R_scene_antenna at each place, shape (M, 3, 3).
        antenna: Its type.
        tags: Where the tags are.
        frequencies_hz: Carriers [Hz], shape (F,).
        ports: Reader port at each place, which chooses the feed of a dual antenna, shape (M,); 1 if left out.

    Returns:
        h, without the tags' own phase, shape (M, T, P, F), P the number of ports of the tags.

    Raises:
        InputError: If a carrier is not above 0, an antenna or a tag is outside the room, or both are in one place.
    """
    f_hz = read_only(frequencies_hz, "one_way_field.frequencies_hz", (None,))
    if not f_hz.size or (f_hz <= 0).any():
        raise InputError(f"one_way_field: carriers must be above 0 Hz, got {f_hz.tolist()}", got=f_hz.tolist())
    track = AntennaTrack(positions_m, rotations, np.ones(len(positions_m), dtype=np.int64) if ports is None else ports)
    _check_places(radio_scene, track, tags)
    k, rows, tag_rows = wavenumber(f_hz), _antenna_rows(track, antenna), TagRows(tags.points_m, tags.axes())
    obstacles = obstacle_table(radio_scene.scene)
    field = np.zeros((len(track), len(tags), tag_rows.axes.shape[1], len(k)), dtype=np.complex128)
    room = _room_table(radio_scene)
    add_images(rows, tag_rows, room, obstacles, k, field)
    if len(radio_scene.scatterers):
        add_scatterers(rows, tag_rows, _scatterer_table(radio_scene), Surroundings(room, obstacles), k, field)
    gains = 10.0 ** ((antenna.gain_dbi + tags.model.gain_dbi + tags.gain_db) / 20.0)
    return np.asarray(field * gains[None, :, None, None] / (2.0 * k))


def image_indices(order: int) -> IntArray:
    """Bounces along x, y and z of every image up to an order, the direct path first, shape (I, 3)."""
    steps = range(-order, order + 1)
    all_ = [n for n in product(steps, steps, steps) if sum(map(abs, n)) <= order]
    return np.array(sorted(all_, key=lambda n: sum(map(abs, n))), dtype=np.int64).reshape(-1, 3)


def _antenna_rows(track: AntennaTrack, antenna: AntennaModel) -> AntennaRows:
    vectors = np.einsum("mij,mj->mi", track.rotations, antenna.vectors(track.ports))
    boresights = np.ascontiguousarray(track.rotations[:, :, 0])
    kind = PATTERNS.index(antenna.pattern)
    return AntennaRows(track.positions_m, vectors, boresights, kind, antenna.exponent, antenna.back_field)


def _room_table(radio_scene: RadioScene) -> RoomTable:
    scene = radio_scene.scene
    if scene.room is None:
        return RoomTable(np.ones(3), np.zeros((1, 3), dtype=np.int64), np.ones((3, 2)))
    sides = [[scene.materials[name] for name in pair] for pair in scene.room.surfaces]
    permittivity = [[-1.0 if material.conductor else material.permittivity for material in pair] for pair in sides]
    return RoomTable(scene.room.size_m, image_indices(radio_scene.order), np.array(permittivity))


def _scatterer_table(radio_scene: RadioScene) -> ScattererTable:
    scatterers = radio_scene.scatterers
    size = np.sqrt(scatterers.cross_section_m2 / (4.0 * np.pi))
    return ScattererTable(scatterers.points_m, size * np.exp(1j * scatterers.phase_rad), scatterers.matrices())


def _check_places(radio_scene: RadioScene, track: AntennaTrack, tags: PlacedTags) -> None:
    points_m: FloatArray = np.concatenate([track.positions_m, tags.points_m, radio_scene.scatterers.points_m])
    room = radio_scene.scene.room
    if room is not None and (outside := ((points_m < 0) | (points_m > room.size_m)).any(axis=1)).any():
        point = points_m[outside][0].tolist()
        what = "an antenna" if np.argmax(outside) < len(track) else "a tag or a scatterer"
        raise InputError(f"{what} at {point} m is outside the room of {room.size_m.tolist()} m", got=point)
    gaps = np.linalg.norm(points_m[: len(track), None] - points_m[None, len(track) :], axis=2)
    if gaps.size and gaps.min() < 1e-6:
        point = points_m[np.unravel_index(gaps.argmin(), gaps.shape)[0]].tolist()
        raise InputError(f"an antenna stands on a tag or a scatterer at {point} m", got=point)
