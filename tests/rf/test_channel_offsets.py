"""Offsets of the carriers from a tag at a known place."""

import dataclasses

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from survey_scenes import FREQUENCIES_HZ, RAIL_M, reads_of

from rfcompass.errors import InputError, NotFocused, TooFewReads
from rfcompass.rf import channel_offsets

TAG_M = np.array([0.4, 0.7, 0.1])


def offset_reads(offsets_rad, sign=1, **more):
    """Reads of a reader that adds offsets to its raw phase: h = free space · exp(-j sign o)."""
    trace = reads_of(TAG_M, same_constant=True, **more)
    return dataclasses.replace(trace, channel=trace.channel * np.exp(-1j * sign * np.asarray(offsets_rad)))


@given(st.lists(st.floats(0.0, 6.28), min_size=3, max_size=3), st.sampled_from([1, -1]), st.floats(0.5, 1.0))
def test_what_the_reader_adds_is_found_whatever_its_sign(offsets_rad, sign, heard):
    found = channel_offsets(offset_reads(offsets_rad, sign, heard=heard, seed=3), TAG_M, sign)
    assert found.frequencies_hz.tolist() == FREQUENCIES_HZ.tolist()
    assert np.allclose(np.exp(1j * found.offsets_rad), np.exp(1j * np.array(offsets_rad)), atol=1e-9)
    assert np.allclose(found.agreement, 1.0)


@given(st.lists(st.floats(0.0, 3.14), min_size=3, max_size=3))
def test_half_turn_phases_give_offsets_modulo_half_a_turn(offsets_rad):
    found = channel_offsets(offset_reads(offsets_rad, modulus_rad=np.pi), TAG_M)
    assert np.allclose(np.exp(2j * found.offsets_rad), np.exp(2j * np.array(offsets_rad)), atol=1e-9)
    assert (found.offsets_rad < np.pi).all()


def test_taken_out_again_they_leave_all_carriers_in_step():
    offsets_rad = np.array([0.3, 2.0, 5.0])
    trace = offset_reads(offsets_rad)
    found = channel_offsets(trace, TAG_M)
    bare = dataclasses.replace(trace, channel=trace.channel * np.exp(1j * found.offsets_rad))
    again = channel_offsets(bare, TAG_M)
    assert np.allclose(np.exp(1j * again.offsets_rad), 1.0)


def test_a_carrier_that_was_hardly_heard_has_no_offset():
    trace = offset_reads([0.0, 1.0, 2.0])
    counts = trace.read_counts.copy()
    counts[7:, 1] = 0
    few = dataclasses.replace(trace, read_counts=counts, channel=trace.channel * (counts > 0))
    assert channel_offsets(few, TAG_M).frequencies_hz.tolist() == [FREQUENCIES_HZ[0], FREQUENCIES_HZ[2]]


def test_a_tag_that_is_not_there_is_refused_with_its_agreement():
    with pytest.raises(NotFocused) as caught:
        channel_offsets(reads_of(TAG_M), TAG_M + np.array([1.5, 2.0, 0.0]))
    assert caught.value.numbers["agreement"] < caught.value.numbers["needed"]


def test_a_tag_that_was_hardly_heard_is_refused():
    trace = reads_of(TAG_M, RAIL_M[:5])
    with pytest.raises(TooFewReads):
        channel_offsets(trace, TAG_M)


@pytest.mark.parametrize("sign", [0, 2, -3])
def test_a_sign_that_is_none_is_refused(sign):
    with pytest.raises(InputError):
        channel_offsets(reads_of(TAG_M), TAG_M, sign)
