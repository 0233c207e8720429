"""Reports become reads in SI units, on frequencies that the reader itself states."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

pytest.importorskip("llrpkit", reason="llrpkit is not installed (extra llrp)")
from llrpkit.exceptions import MessageDecodeError
from llrpkit.protocol import BitStr, decode_message, impinj, messages, params

from rfcompass.errors import ReaderRefused
from rfcompass.recordings.sources.llrp_reads import frequency_table_hz, read_of

TABLE_HZ = (915.25e6, 902.75e6, 927.25e6)


def report(**changes):
    values = {
        "epc_parameter": params.EPC_96(epc=bytes.fromhex("30080000000000000000000a")),
        "antenna_id": params.AntennaID(antenna_id=2),
        "peak_rssi": params.PeakRSSI(peak_rssi=-53),
        "channel_index": params.ChannelIndex(channel_index=1),
        "first_seen_timestamp_utc": params.FirstSeenTimestampUTC(microseconds=5),
        "last_seen_timestamp_utc": params.LastSeenTimestampUTC(microseconds=7),
        "custom": [impinj.ImpinjRFPhaseAngle(phase_angle=1024)],
    }
    return params.TagReportData(**{**values, **changes})


def test_a_report_becomes_a_read():
    read = read_of(report(), TABLE_HZ, 99)
    assert (read.epc, read.antenna, read.freq_hz, read.channel_index) == ("30080000000000000000000a", 2, 915.25e6, 1)
    assert (read.t_ns, read.t_reader_us, read.rssi_dbm) == (99, 7, -53.0)
    assert read.phase_rad == math.pi / 2
    assert read.doppler_hz is None


def test_the_fine_power_goes_before_the_coarse_one():
    extensions = [impinj.ImpinjRFPhaseAngle(phase_angle=0), impinj.ImpinjPeakRSSI(rssi=-5312)]
    assert read_of(report(custom=extensions), TABLE_HZ, 0).rssi_dbm == pytest.approx(-53.12, abs=1e-12)
    assert read_of(report(custom=extensions, peak_rssi=None), TABLE_HZ, 0).rssi_dbm == pytest.approx(-53.12, abs=1e-12)


def test_doppler_comes_in_sixteenths_of_a_hertz():
    extensions = [impinj.ImpinjRFPhaseAngle(phase_angle=0), impinj.ImpinjRFDopplerFrequency(doppler_frequency=-40)]
    assert read_of(report(custom=extensions), TABLE_HZ, 0).doppler_hz == -2.5


def test_an_epc_of_another_length_is_kept():
    short = params.EPCData(epc=BitStr.from_bytes(bytes.fromhex("e280")))
    assert read_of(report(epc_parameter=short), TABLE_HZ, 0).epc == "e280"


@given(code=st.integers(0, 4095), index=st.integers(1, 3))
def test_every_code_is_a_phase_below_a_full_turn_and_every_index_a_carrier_of_the_table(code, index):
    custom = [impinj.ImpinjRFPhaseAngle(phase_angle=code)]
    read = read_of(report(custom=custom, channel_index=params.ChannelIndex(channel_index=index)), TABLE_HZ, 0)
    assert 0.0 <= read.phase_rad < 2 * math.pi
    assert round(read.phase_rad / (2 * math.pi) * 4096) == code
    assert read.freq_hz == TABLE_HZ[index - 1]


@pytest.mark.parametrize(
    ("changes", "reason"),
    [
        ({"custom": []}, "no_phase"),
        ({"peak_rssi": None}, "no_rssi"),
        ({"antenna_id": None}, "no_antenna"),
        ({"channel_index": None}, "no_channel"),
        ({"channel_index": params.ChannelIndex(channel_index=0)}, "channel_outside_table"),
        ({"channel_index": params.ChannelIndex(channel_index=4)}, "channel_outside_table"),
        ({"epc_parameter": params.EPCData(epc=BitStr())}, "no_epc"),
    ],
)
def test_what_cannot_be_used_is_a_reason(changes, reason):
    assert read_of(report(**changes), TABLE_HZ, 0) == reason


def test_a_carrier_of_0_hz_is_none():
    assert read_of(report(), (0.0,), 0) == "channel_outside_table"


@settings(max_examples=200)
@given(place=st.integers(10, 90), value=st.integers(0, 255))
def test_whatever_can_be_decoded_is_a_read_that_is_possible_or_a_reason(place, value):
    frame = bytearray(messages.RO_ACCESS_REPORT(tag_report_datas=[report()]).to_bytes(message_id=0))
    frame[min(place, len(frame) - 1)] = value
    try:
        decoded = decode_message(bytes(frame))
    except MessageDecodeError:
        return
    for data in getattr(decoded, "tag_report_datas", ()):
        read = read_of(data, TABLE_HZ, 0)
        assert isinstance(read, str) or (read.epc and read.freq_hz in TABLE_HZ and 0 <= read.phase_rad < 2 * math.pi)


def capabilities(hopping, tables=(), fixed=None):
    information = params.FrequencyInformation(
        hopping=hopping,
        frequency_hop_tables=[params.FrequencyHopTable(hop_table_id=k, frequency=list(t)) for k, t in tables],
        fixed_frequency_table=None if fixed is None else params.FixedFrequencyTable(frequency=list(fixed)),
    )
    band = params.UHFBandCapabilities(frequency_information=information)
    regulatory = params.RegulatoryCapabilities(country_code=0, communications_standard=0, uhf_band_capabilities=band)
    return messages.GET_READER_CAPABILITIES_RESPONSE(
        llrp_status=params.LLRPStatus(), regulatory_capabilities=regulatory
    )


@given(seed=st.integers(0, 1000))
def test_a_shuffled_hop_table_is_taken_as_it_stands(seed):
    table_khz = np.random.default_rng(seed).permutation(902_750 + 500 * np.arange(50)).tolist()
    assert frequency_table_hz(capabilities(True, [(1, table_khz)]), None) == tuple(1000.0 * khz for khz in table_khz)


def test_a_reader_that_does_not_hop_states_a_fixed_table():
    assert frequency_table_hz(capabilities(False, fixed=[865_700, 866_300]), None) == (865.7e6, 866.3e6)


def test_of_several_hop_tables_one_must_be_named():
    several = capabilities(True, [(1, [902_750]), (2, [915_250])])
    assert frequency_table_hz(several, 2) == (915.25e6,)
    for asked in (None, 3):
        with pytest.raises(ReaderRefused) as caught:
            frequency_table_hz(several, asked)
        assert caught.value.numbers["tables"] == [1, 2]


@pytest.mark.parametrize(
    "silent", [capabilities(True), messages.GET_READER_CAPABILITIES_RESPONSE(llrp_status=params.LLRPStatus())]
)
def test_a_reader_without_a_table_is_refused_rather_than_guessed(silent):
    with pytest.raises(ReaderRefused):
        frequency_table_hz(silent, None)
