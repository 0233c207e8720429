"""What a reader reports: who answers when, how it hops, and that a seed gives the same bits."""

import dataclasses

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rfcompass.errors import InputError, ShapeError
from rfcompass.simulation import (
    NOISE_NONE,
    NOISE_R420,
    RIG_PAPER,
    RIG_R420,
    SQUIGGLE,
    AntennaTrack,
    NoiseModel,
    PlacedTags,
    RadioScene,
    backscatter,
    inventory_scan,
    simulate_inventory,
)
from rfcompass.types.scene import Scene

FREE = RadioScene(Scene("free"))
TRACK = AntennaTrack.line((0.0, 1.0, 0.3), (0.6, 1.0, 0.3), facing_m=(0.3, 3.0, 0.3))


def tags(count, rng=None, model=SQUIGGLE):
    rng = rng or np.random.default_rng(0)
    points_m = np.column_stack([rng.uniform(0.0, 1.0, count), rng.uniform(2.0, 3.0, count), np.full(count, 0.2)])
    return PlacedTags.draw([f"{i:04x}" for i in range(count)], points_m, np.tile([0.0, 0, 1.0], (count, 1)), model, rng)


def quiet(rig):
    return dataclasses.replace(rig, noise=dataclasses.replace(rig.noise, **NO_NOISE))


NO_NOISE = {"phase_rad": 0.0, "flip_probability": 0.0, "outlier_probability": 0.0, "rssi_db": 0.0,
            "thermal_dbm": -np.inf, "self_jammer_dbm": -np.inf}  # fmt: skip


def heard(rig, seed=0, count=3, track=TRACK, **more):
    return simulate_inventory(FREE, rig, track, tags(count), np.random.default_rng(seed), **more)


@pytest.mark.parametrize("rig", [RIG_PAPER, RIG_R420], ids=["bistatic", "hopping"])
def test_the_same_seed_gives_the_same_reads_to_the_last_bit_and_another_one_does_not(rig):
    assert heard(rig, 5).reads() == heard(rig, 5).reads()
    assert heard(rig, 5).reads() != heard(rig, 6).reads()


def test_without_noise_every_read_is_the_channel():
    rig = dataclasses.replace(RIG_PAPER, noise=NOISE_NONE)
    run, air = heard(rig), backscatter(FREE, rig, TRACK, tags(3))
    assert len(run) > 0
    assert np.array_equal(run.heard, air.channel[run.transmitters, run.poses, run.tags, run.channels])


@settings(max_examples=10, deadline=None)
@given(st.integers(0, 1000))
def test_the_rate_of_each_tag_falls_with_the_number_of_tags(seed):
    rates = [heard(RIG_PAPER, seed, count).reads_per_tag.mean() for count in (1, 4, 16)]
    assert rates[0] > rates[1] > rates[2] > 0


def test_every_tag_with_power_has_its_turn():
    run = heard(RIG_PAPER, 1, 12)
    assert run.powered.all()
    assert (run.reads_per_tag > 0).all()


def test_a_tag_without_power_is_missing_for_the_whole_slide_and_the_count_says_why():
    deaf = dataclasses.replace(SQUIGGLE, sensitivity_dbm=50.0)
    run = simulate_inventory(FREE, RIG_PAPER, TRACK, tags(2, model=deaf), np.random.default_rng(0))
    assert len(run) == 0
    assert not run.powered.any()
    assert (run.misses.not_powered == run.misses.windows).all()


def test_a_receiver_that_hears_nothing_below_its_floor_says_so():
    rig = dataclasses.replace(RIG_PAPER, noise=dataclasses.replace(RIG_PAPER.noise, self_jammer_dbm=60.0))
    run = heard(rig)
    assert len(run) == 0
    assert run.powered.all()
    assert (run.misses.below_floor > 0).all()


def test_a_hopping_reader_visits_every_carrier_once_before_any_twice():
    run = heard(RIG_R420, 2, 1, AntennaTrack.line((0.0, 1.0, 0.3), (4.0, 1.0, 0.3), facing_m=(2.0, 3.0, 0.3)))
    hops = run.channels[np.flatnonzero(np.diff(run.channels, prepend=-1))]
    F = len(RIG_R420.frequencies_hz)
    first, second = hops[:F], hops[F : 2 * F]
    assert len(set(first.tolist())) == len(first)
    assert len(set(second.tolist())) == len(second)


def test_offsets_of_a_hopping_reader_are_constant_for_each_channel():
    rng = np.random.default_rng(4)
    rig = quiet(RIG_R420.with_channel_offsets(rng))
    plain = quiet(RIG_R420)
    with_, without = heard(rig, 3, 1), heard(plain, 3, 1)
    turn = -np.angle(with_.heard / without.heard)
    expected = rig.channel_offsets_rad[with_.channels]
    assert np.allclose(np.exp(1j * turn), np.exp(1j * expected))


def test_phases_lie_on_the_readers_grid_and_within_half_a_step_of_the_truth():
    run = heard(quiet(RIG_R420), 1, 2)
    step = 2 * np.pi / 4096
    raw = np.array([read.phase_rad for read in run.reads()])
    assert np.allclose(raw / step, np.round(raw / step), atol=1e-6)
    assert np.abs(np.angle(np.exp(1j * (raw + np.angle(run.heard))))).max() <= step / 2 + 1e-9
    assert ((raw >= 0) & (raw < 2 * np.pi)).all()


def test_a_software_radio_reports_the_complex_channel_and_a_commercial_reader_does_not():
    assert all(read.i is not None and read.q is not None for read in heard(RIG_PAPER).reads())
    assert all(read.i is None and read.q is None for read in heard(RIG_R420).reads())


def test_every_pose_that_a_read_names_has_its_antennas():
    run = heard(RIG_PAPER)
    rows = {(row.pose_id, row.antenna) for row in run.antenna_rows(first_pose_id=100)}
    for read in run.reads(first_pose_id=100):
        assert {(read.pose_id, read.antenna), (read.pose_id, read.tx_antenna)} <= rows


def test_times_ascend_and_stay_within_the_stop():
    run = heard(RIG_PAPER)
    assert (np.diff(run.times_s) >= 0).all()
    assert run.times_s[-1] <= len(TRACK) * RIG_PAPER.dwell_s


def test_tracks_that_do_not_belong_together_are_refused():
    with pytest.raises(ShapeError):
        heard(RIG_PAPER, nominal_track=AntennaTrack.line((0.0, 1.0, 0.3), (0.2, 1.0, 0.3)))


def test_a_port_that_sends_and_receives_in_a_bistatic_rig_is_refused():
    with pytest.raises(InputError):
        heard(RIG_PAPER, track=AntennaTrack.line((0.0, 1.0, 0.3), (0.6, 1.0, 0.3), port=101))


def test_the_noise_of_a_reader_is_as_large_as_it_says():
    h = np.full(200_000, 1e-3 + 0j)
    noise = NoiseModel(phase_rad=0.16, thermal_dbm=-np.inf, self_jammer_dbm=-np.inf)
    turn = np.angle(noise.heard(h, np.random.default_rng(0)))
    assert turn.std() == pytest.approx(0.16, rel=0.02)
    floor = dataclasses.replace(noise, phase_rad=0.0, self_jammer_dbm=-80.0)
    extra = floor.heard(h, np.random.default_rng(0)) - h
    assert 10 * np.log10(np.mean(np.abs(extra) ** 2)) == pytest.approx(-80.0, abs=0.1)


def test_the_commercial_preset_scatters_as_the_recordings_do():
    """18 % of pairs differ by more than a quarter turn, 7 % lie within 0.3 rad of a half turn (pilot study)."""
    turn = np.angle(NOISE_R420.heard(np.full(200_000, 1.0 + 0j), np.random.default_rng(1)))
    gap = np.abs(np.angle(np.exp(1j * (turn[::2] - turn[1::2]))))
    assert np.mean(gap > np.pi / 2) == pytest.approx(0.18, abs=0.03)
    assert np.mean(gap > np.pi - 0.3) == pytest.approx(0.07, abs=0.02)


def test_a_scan_of_nothing_is_empty():
    run = heard(RIG_PAPER)
    assert inventory_scan(run, ["unknown"]).epcs == ()
