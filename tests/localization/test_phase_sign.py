"""The sign of the phase, told by what comes into focus."""

import dataclasses
import os
from pathlib import Path

import numpy as np
import pytest
from survey_scenes import RAIL_M, reads_of

from rfcompass.errors import NotFocused, TagNeverHeard
from rfcompass.localization import detect_phase_sign
from rfcompass.recordings import open_trace
from rfcompass.types import Scan, SearchVolume

PLANE = SearchVolume(np.array([-0.1, 0.2, 0.0]), np.array([1.1, 1.3, 0.0]))
SWEEPS = Path(os.environ.get("RFCOMPASS_MEASURED_DATA", "../shared/data/measured")) / "traces"


def scan_of(*traces):
    named = [dataclasses.replace(trace, epc=f"{i:02x}") for i, trace in enumerate(traces)]
    return Scan(traces={trace.epc: trace for trace in named}, dimensions=2)


@pytest.mark.parametrize("seed", range(4))
def test_reads_as_they_are_are_in_focus_and_reversed_ones_are_found_out(seed):
    place = np.random.default_rng(seed).uniform((0.1, 0.4, 0.0), (0.9, 0.9, 0.0))
    right = reads_of(place, seed=seed)
    wrong = dataclasses.replace(right, channel=right.channel.conj())
    assert not detect_phase_sign(scan_of(right), PLANE).reversed
    found = detect_phase_sign(scan_of(wrong), PLANE)
    assert found.reversed
    assert found.focus < found.focus_reversed <= 1.0 + 1e-6


def test_a_tag_too_far_for_a_short_path_has_no_sign():
    short = RAIL_M[:10] * 0.2
    with pytest.raises(NotFocused) as caught:
        detect_phase_sign(scan_of(reads_of([0.02, 3.0, 0.0], short)), SearchVolume([-2.0, 1.0, 0.0], [2.0, 4.0, 0.0]))
    assert caught.value.numbers["focus"] > 0.5


def test_nothing_heard_is_no_answer():
    with pytest.raises(TagNeverHeard):
        detect_phase_sign(Scan(), PLANE)


@pytest.mark.slow
@pytest.mark.skipif(not SWEEPS.is_dir(), reason="the measured sweeps are not there; set RFCOMPASS_MEASURED_DATA")
def test_every_measured_sweep_has_the_sign_that_its_trace_states():
    for folder in sorted(SWEEPS.iterdir()):
        assert not detect_phase_sign(open_trace(folder).scan()).reversed, folder.name
