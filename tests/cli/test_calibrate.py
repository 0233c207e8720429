"""`rfcompass calibrate`: what it finds, what it writes, and what it refuses."""

import dataclasses

import numpy as np
import pytest

from rfcompass.recordings import Trace, open_trace, write_trace

EPC = "300800000000000000000000"


@pytest.fixture
def reversed_sweep(sweep, tmp_path):
    opened = open_trace(sweep)
    meta = dataclasses.replace(opened.meta, phase_sign=-1)
    write_trace(Trace(meta, opened.reads, opened.antenna_poses), tmp_path / "reversed")
    return tmp_path / "reversed"


def test_a_trace_that_states_the_wrong_sign_is_found_out_and_mended(run, reversed_sweep, tmp_path):
    answer = run("calibrate", reversed_sweep, "--out", tmp_path / "mended", "--json")
    assert answer.code == 0
    assert (answer.json["stated"], answer.json["phase_sign"]) == (-1, 1)
    assert open_trace(tmp_path / "mended").meta.phase_sign == 1
    assert "opposite" in run("calibrate", reversed_sweep).out


def test_a_known_tag_gives_an_offset_for_each_carrier(run, sweep, tags_m, tmp_path):
    at = ",".join(map(str, tags_m[EPC]))
    answer = run("calibrate", sweep, "--tag", EPC, "--at", at, "--out", tmp_path / "calibrated", "--json").json
    assert len(answer["channel_offsets_rad"]) == 2
    assert min(answer["agreement"]) > 0.6
    pairs = open_trace(tmp_path / "calibrated").meta.channel_offsets_rad
    assert np.allclose([offset for _, offset in pairs], list(answer["channel_offsets_rad"].values()))


@pytest.mark.parametrize(
    ("options", "code", "kind"),
    [
        (("--tag", EPC), 2, "InputError"),
        (("--tag", EPC, "--at", "1,2"), 2, "InputError"),
        (("--tag", "ff", "--at", "1,2,0"), 1, "TagNeverHeard"),
        (("--tag", EPC, "--at", "9,9,0"), 1, "NotFocused"),
    ],
)
def test_what_cannot_be_is_refused_and_nothing_is_written(run, sweep, tmp_path, options, code, kind):
    ran = run("calibrate", sweep, *options, "--out", tmp_path / "out", "--json")
    assert (ran.code, ran.json["failure"]["kind"]) == (code, kind)
    assert not (tmp_path / "out").exists()


def test_offsets_are_not_taken_out_twice(run, sweep, tags_m, tmp_path):
    at = ",".join(map(str, tags_m[EPC]))
    run("calibrate", sweep, "--tag", EPC, "--at", at, "--out", tmp_path / "once")
    again = run("calibrate", tmp_path / "once", "--tag", EPC, "--at", at, "--json")
    assert again.code == 2
