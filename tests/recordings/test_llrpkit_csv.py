"""CSV captures of llrpkit, as its own writer writes them."""

import math

import pytest

from rfcompass.errors import ImportFormatError
from rfcompass.recordings import import_llrpkit

TABLE_HZ = (915.25e6, 902.75e6)


def test_a_capture_of_llrpkit_comes_back_to_the_digits_that_it_keeps(tmp_path):
    llrpkit = pytest.importorskip("llrpkit", reason="llrpkit is not installed (extra llrp)")
    tags = [
        llrpkit.TagReport(
            epc=bytes.fromhex("30080000000000000000000a"), antenna=1 + k % 2, rssi_dbm=-50.25 - k,
            channel_index=1 + k % 2, phase_deg=12.34 * k, doppler_hz=None if k == 3 else 0.5 * k,
        )
        for k in range(20)
    ]  # fmt: skip
    with llrpkit.TagWriter(tmp_path / "log.csv") as writer:
        for tag in tags:
            writer.write(tag)
    reads = import_llrpkit(tmp_path / "log.csv", frequencies_hz=TABLE_HZ).reads.to_pylist()
    assert len(reads) == 20
    for read, tag in zip(reads, tags, strict=True):
        assert (read["epc"], read["antenna"], read["rssi_dbm"]) == (tag.epc_hex, tag.antenna, tag.rssi_dbm)
        assert read["doppler_hz"] == tag.doppler_hz
        assert read["freq_hz"] == TABLE_HZ[tag.channel_index - 1]
        assert abs(read["phase_rad"] - math.radians(tag.phase_deg) % (2 * math.pi)) <= math.radians(0.05) + 1e-9
        assert read["t_ns"] > 1_600_000_000 * 10**9


def test_a_tag_that_was_reported_without_phase_is_dropped_and_counted(tmp_path):
    header = "at,epc,antenna,rssi_dbm,phase_deg,doppler_hz,channel,tid,scheme,identity\n"
    (tmp_path / "log.csv").write_text(f"{header}1,aa,1,-50.0,90.0,,1,,,\n2,aa,1,-50.0,,,1,,,\n")
    trace = import_llrpkit(tmp_path / "log.csv", frequencies_hz=TABLE_HZ)
    assert trace.reads["phase_rad"].to_pylist() == [math.pi / 2]
    assert '"no_phase": 1' in trace.meta.unknown_json


@pytest.mark.parametrize("cell", ["360.1", "-0.1", "3072"])
def test_a_phase_beyond_a_turn_is_an_error_rather_than_wrapped(tmp_path, cell):
    header = "at,epc,antenna,rssi_dbm,phase_deg,doppler_hz,channel,tid,scheme,identity\n"
    (tmp_path / "log.csv").write_text(f"{header}1,aa,1,-50.0,359.9,,1,,,\n2,aa,1,-50.0,{cell},,1,,,\n")
    with pytest.raises(ImportFormatError) as caught:
        import_llrpkit(tmp_path / "log.csv", frequencies_hz=TABLE_HZ)
    assert (caught.value.numbers["column"], caught.value.numbers["row"]) == ("phase_deg", 1)
