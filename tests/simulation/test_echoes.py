"""What comes back: powers, phases, and when a tag has power at all."""

import dataclasses

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rfcompass.errors import InputError
from rfcompass.rf.waves import wavenumber
from rfcompass.simulation import (
    DUAL_DIPOLE,
    NOISE_NONE,
    RIG_PAPER,
    RIG_WRIST,
    SQUIGGLE,
    AntennaModel,
    AntennaTrack,
    FixedTransmitters,
    PlacedTags,
    RadioScene,
    ReaderRig,
    TagModel,
    WristTransmitter,
    backscatter,
)
from rfcompass.types.scene import Scene

FREE = RadioScene(Scene("free"))
F_HZ = np.array([915e6, 920e6])
DIPOLE = AntennaModel(gain_dbi=2.0, pattern="dipole")
MONO = ReaderRig(rx=DIPOLE, frequencies_hz=F_HZ, noise=NOISE_NONE)
CP = AntennaModel(polarisation="rhcp")


def tags_at(*points_m, model=SQUIGGLE, phase_rad=0.0):
    count = len(points_m)
    z = np.tile([0.0, 0.0, 1.0], (count, 1))
    epcs = tuple(f"{i:02x}" for i in range(count))
    return PlacedTags(epcs, np.array(points_m), z, model, np.full(count, phase_rad), np.zeros(count))


def at_origin(count=1):
    return AntennaTrack.at(np.zeros((count, 3)))


@given(st.floats(0.5, 5.0), st.floats(1.1, 3.0))
def test_the_power_of_a_monostatic_echo_falls_with_the_fourth_power_of_distance(r_m, factor):
    near, far = (backscatter(FREE, MONO, at_origin(), tags_at((r, 0.0, 0.0))).channel for r in (r_m, factor * r_m))
    assert np.allclose(np.abs(near / far) ** 2, factor**4, rtol=1e-9)


@given(st.floats(0.5, 5.0), st.floats(0.001, 0.08))
def test_the_phase_falls_by_two_wavenumbers_a_metre_when_the_antenna_sends_too_and_by_one_when_it_listens(r_m, step_m):
    sender = FixedTransmitters.looking_at([[0.0, 3.0, 0.0]], [1.0, 0.0, 0.0], DIPOLE)
    moved = AntennaTrack.at(np.array([[0.0, 0.0, 0.0], [-step_m, 0.0, 0.0]]))
    for rig, legs in ((MONO, 2), (dataclasses.replace(MONO, tx=sender), 1)):
        h = backscatter(FREE, rig, moved, tags_at((r_m, 0.0, 0.0))).channel[0, :, 0, :]
        assert np.allclose(np.angle(h[1] / h[0] * np.exp(1j * legs * wavenumber(F_HZ) * step_m)), 0.0, atol=1e-9)


def test_on_the_wrist_the_round_trip_is_out_to_the_tag_and_back_to_the_other_antenna():
    tx = WristTransmitter(np.array([0.0, 0.3, 0.0]), DIPOLE)
    point_m = np.array([1.0, 0.7, 0.0])
    h = backscatter(FREE, dataclasses.replace(MONO, tx=tx), at_origin(), tags_at(point_m)).channel[0, 0, 0]
    way_m = np.linalg.norm(point_m) + np.linalg.norm(point_m - [0.0, 0.3, 0.0])
    assert np.allclose(np.angle(h * np.exp(1j * wavenumber(F_HZ) * way_m)), 0.0, atol=1e-9)


def test_power_at_the_chip_and_at_the_reader_are_the_budget_of_free_space():
    """Pilot study's table: EIRP 36 dBm, 2 dBi: -3.3 dBm and -46.5 dBm at 3 m; its reader antenna has 6 dBi."""
    tag = TagModel(gain_dbi=2.0, gain_spread_db=0.0)
    rig = dataclasses.replace(MONO, rx=AntennaModel(gain_dbi=6.0, pattern="dipole"), frequencies_hz=np.array([915e6]))
    echo = backscatter(FREE, rig, at_origin(), tags_at((3.0, 0.0, 0.0), model=tag))
    friis_db = 20 * np.log10(299792458.0 / 915e6 / (4 * np.pi * 3.0))
    assert echo.tag_power_dbm[0, 0, 0, 0] == pytest.approx(36.0 + 2.0 + friis_db, abs=1e-9)
    received = echo.tag_power_dbm[0, 0, 0, 0] - 6.0 + 2.0 + 6.0 + friis_db
    assert 20 * np.log10(abs(echo.channel[0, 0, 0, 0])) == pytest.approx(received, abs=1e-9)
    assert echo.tag_power_dbm[0, 0, 0, 0] == pytest.approx(-3.3, abs=0.1)


@given(st.floats(0.0, 6.28))
def test_a_tags_own_phase_turns_its_echo_and_nothing_else(phase_rad):
    one, other = (backscatter(FREE, MONO, at_origin(), tags_at((1.0, 0.5, 0.2), phase_rad=p)) for p in (0.0, phase_rad))
    assert np.allclose(other.channel, one.channel * np.exp(1j * phase_rad))
    assert np.array_equal(one.tag_power_dbm, other.tag_power_dbm)


@given(st.integers(0, 100))
def test_channel_offsets_are_what_is_added_to_the_raw_phase(seed):
    rng = np.random.default_rng(seed)
    rig = MONO.with_channel_offsets(rng)
    plain = backscatter(FREE, MONO, at_origin(), tags_at((1.0, 0.5, 0.2))).channel
    shifted = backscatter(FREE, rig, at_origin(), tags_at((1.0, 0.5, 0.2))).channel
    raw = -np.angle(shifted / plain)[0, 0, 0]
    assert np.allclose(np.exp(1j * raw), np.exp(1j * rig.channel_offsets_rad))


def test_a_tag_in_a_fade_of_its_only_sender_is_without_power_at_every_place_of_the_receiver():
    deaf = dataclasses.replace(SQUIGGLE, sensitivity_dbm=0.0)
    track = AntennaTrack.line((0.0, 1.0, 0.3), (3.0, 1.0, 0.3))
    powered = backscatter(FREE, RIG_PAPER, track, tags_at((3.0, 2.0, 0.1), model=deaf)).powered
    assert (powered.all(axis=1) | ~powered.any(axis=1)).all()
    assert powered.shape[:2] in {(2, 1), (2, len(track))}


def test_two_crossed_dipoles_in_step_send_nothing_back_to_the_hand_they_came_from():
    """A circular antenna that hears its own hand: an even tag turns the hand round. A quarter turn between the ports
    brings the echo back."""
    rig = dataclasses.replace(MONO, rx=CP)
    in_step = dataclasses.replace(DUAL_DIPOLE, port_phase_rad=0.0)
    silent, heard = (
        backscatter(FREE, rig, at_origin(), tags_at((1.0, 0.0, 0.0), model=model)) for model in (in_step, DUAL_DIPOLE)
    )
    assert np.abs(silent.channel).max() < 1e-12 * np.abs(heard.channel).max()
    assert silent.powered.all()


@given(st.floats(0.0, 3.14))
def test_two_crossed_dipoles_in_step_are_heard_alike_at_any_roll_by_a_linear_antenna(roll_rad):
    model = dataclasses.replace(DUAL_DIPOLE, port_phase_rad=0.0)
    upright = tags_at((1.0, 0.0, 0.0), model=model)
    first = np.array([[0.0, np.sin(roll_rad), np.cos(roll_rad)]])
    second = np.array([[0.0, np.cos(roll_rad), -np.sin(roll_rad)]])
    rig = dataclasses.replace(MONO, rx=AntennaModel(gain_dbi=2.0))
    one = backscatter(FREE, rig, at_origin(), upright)
    other = backscatter(FREE, rig, at_origin(), upright.moved(upright.points_m, first, second))
    assert np.allclose(one.channel, other.channel)
    assert np.allclose(one.tag_power_dbm, other.tag_power_dbm)


@pytest.mark.parametrize(
    "bad", [{"frequencies_hz": []}, {"frequencies_hz": [2.0, 1.0]}, {"eirp_dbm": np.nan}, {"hop_s": 0.0}]
)
def test_a_rig_that_cannot_be_is_refused(bad):
    with pytest.raises(InputError):
        dataclasses.replace(MONO, **bad)


def test_the_shipped_rigs_are_what_they_are_called():
    assert RIG_PAPER.frequencies_hz.tolist() == [920e6]
    assert len(RIG_PAPER.tx_ports) == 2
    assert RIG_WRIST.tx_ports == (2,)
