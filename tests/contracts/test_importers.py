"""What every importer of other programs' logs must do: the values as they are, drops counted, defects placed."""

import json

import numpy as np
import pytest

from rfcompass.errors import ImportFormatError, InputError
from rfcompass.recordings import (
    IMPORTERS,
    CarrierLog,
    StillAntennas,
    TraceMeta,
    import_log,
    open_trace,
    write_trace,
)

TABLE_HZ = tuple(902.75e6 + 0.5e6 * np.random.default_rng(0).permutation(50))
RNG = np.random.default_rng(1)
ROWS = [
    {
        "t": 1_746_525_605 + k, "epc": f"3008{k % 4:020x}", "antenna": 1 + k % 2, "rssi": -40 - k,
        "channel": 1 + 7 * k % 50, "code": int(RNG.integers(4096)), "doppler": 0.5 * k,
    }
    for k in range(12)
]  # fmt: skip


def itemtest(row, *, comma=False):
    cells = [str(row["rssi"]), f"{TABLE_HZ[row['channel'] - 1] / 1e6}", f"{phase(row):.12f}", str(row["doppler"])]
    rssi, mhz, angle, doppler = (f'"{cell.replace(".", ",")}"' if comma else cell for cell in cells)
    when = str(np.datetime64(row["t"], "s")) + ".0000000Z"
    return f"{when},{row['epc'].upper()},,{row['antenna']},{rssi},{mhz},host,{angle},{doppler}"


def phase(row):
    return row["code"] / 4096 * 2 * np.pi


def sllurp(row):
    return (
        f"{row['t']}.0,{row['antenna']},{row['rssi']},b'{row['epc']}',{row['code']},{row['channel']},"
        f"{round(16 * row['doppler'])}"
    )


def llrpkit(row):
    degrees = np.degrees(phase(row))
    return (
        f"{row['t']}.0,{row['epc']},{row['antenna']},{row['rssi']}.0,{degrees:.1f},{row['doppler']},{row['channel']},,,"
    )


ITEMTEST_HEADER = "// Timestamp, EPC, TID, Antenna, RSSI, Frequency, Hostname, PhaseAngle, DopplerFrequency"
LAYOUTS = {
    "itemtest": (ITEMTEST_HEADER, itemtest, {}, 1e-9),
    "itemtest comma": (ITEMTEST_HEADER, lambda row: itemtest(row, comma=True), {}, 1e-9),
    "sllurp": (
        "timestamp,antenna,rssi,epc,phase_angle,channel_index,doppler_frequency", sllurp,
        {"frequencies_hz": TABLE_HZ}, 1e-12,
    ),
    "llrpkit": (
        "at,epc,antenna,rssi_dbm,phase_deg,doppler_hz,channel,tid,scheme,identity", llrpkit,
        {"frequencies_hz": TABLE_HZ}, np.radians(0.05) + 1e-9,
    ),
}  # fmt: skip


@pytest.fixture(params=LAYOUTS)
def layout(request, tmp_path):
    """Imports lines of one layout."""
    header, line, options, tolerance_rad = LAYOUTS[request.param]

    def run(lines, end="\n", **more):
        path = tmp_path / "log.csv"
        path.write_text("\n".join([header, *lines]) + end)
        return import_log(request.param.split()[0], path, **options, **more)

    return run, line, tolerance_rad


def told(trace):
    return json.loads(trace.meta.unknown_json)["import"]


def test_the_values_come_through_as_they_are(layout):
    run, line, tolerance_rad = layout
    trace = run([line(row) for row in ROWS])
    reads = trace.reads.to_pylist()
    assert told(trace) == {"rows": 12, "written": 12, "dropped": {}}
    for read, row in zip(reads, ROWS, strict=True):
        assert (read["epc"], read["antenna"], read["rssi_dbm"]) == (row["epc"], row["antenna"], row["rssi"])
        assert read["freq_hz"] == TABLE_HZ[row["channel"] - 1]
        assert read["t_ns"] == row["t"] * 10**9
        assert read["doppler_hz"] == row["doppler"]
        off_rad = (read["phase_rad"] - phase(row) + np.pi) % (2 * np.pi) - np.pi
        assert abs(off_rad) <= tolerance_rad


def test_an_imported_trace_survives_the_disk(layout, tmp_path):
    run, line, _ = layout
    trace = run([line(row) for row in ROWS])
    write_trace(trace, tmp_path / "t")
    again = open_trace(tmp_path / "t")
    assert again.reads.equals(trace.reads)
    assert told(again) == told(trace)


def test_antennas_are_at_the_origin_unless_somebody_knows_better(layout, tmp_path):
    run, line, _ = layout
    lines = [line(row) for row in ROWS]
    assert not run(lines).antenna_poses.positions_m.any()
    assert run(lines).antenna_poses.antennas.tolist() == [1, 2]
    still = StillAntennas({1: np.array([1.0, 0, 0]), 2: np.array([0, 1.0, 0])})
    assert run(lines, carriage=still).antenna_poses.positions_m.tolist() == [[1, 0, 0], [0, 1, 0]]
    half = run(lines, carriage=StillAntennas({2: np.array([0, 1.0, 0])}))
    assert told(half) == {"rows": 12, "written": 6, "dropped": {"no_place": 6}}
    assert half.antenna_poses.antennas.tolist() == [2]
    log = tmp_path / "carrier.csv"
    times = [ROWS[0]["t"] * 10**9, ROWS[5]["t"] * 10**9]
    log.write_text(
        "t_ns,antenna,x_m,y_m,z_m\n" + "".join(f"{t},{p},{x},0,0\n" for p in (1, 2) for x, t in enumerate(times))
    )
    moved = run(lines, carriage=CarrierLog.read(log))
    assert told(moved) == {"rows": 12, "written": 6, "dropped": {"no_place": 6}}
    poses = moved.antenna_poses
    assert poses.positions_m[:, 0].max() == 1.0


@pytest.mark.parametrize("kept", [0.2, 0.5, 0.9, 1.0])
def test_a_log_cut_inside_its_last_line_loses_this_line_and_says_so(layout, kept):
    run, line, _ = layout
    last = line(ROWS[-1])
    trace = run([*(line(row) for row in ROWS[:-1]), last[: int(kept * len(last))]], end="")
    assert told(trace) == {"rows": 12, "written": 11, "dropped": {"cut_line": 1}}
    assert trace.reads["t_ns"].to_pylist() == [row["t"] * 10**9 for row in ROWS[:-1]]


def test_a_line_cut_in_the_middle_of_the_log_is_an_error_with_its_row(layout):
    run, line, _ = layout
    lines = [line(row) for row in ROWS]
    lines[3] = lines[3][:25]
    with pytest.raises(ImportFormatError) as caught:
        run(lines)
    assert caught.value.numbers["row"] == 3
    assert caught.value.numbers["file"] == "log.csv"


def test_a_number_that_is_none_is_an_error_with_its_row(layout):
    run, line, _ = layout
    lines = [line(row) for row in ROWS]
    cells = lines[4].split(",")
    cells[0] = "noon"
    lines[4] = ",".join(cells)
    with pytest.raises(ImportFormatError) as caught:
        run(lines)
    assert caught.value.numbers["row"] == 4


@pytest.mark.parametrize("place", [3, 11])
def test_a_line_cut_inside_a_quoted_cell_is_an_error_with_its_row(layout, place):
    run, line, _ = layout
    lines = [line(row) for row in ROWS]
    lines[place] = '"' + lines[place][:8]
    with pytest.raises(ImportFormatError) as caught:
        run(lines)
    assert caught.value.numbers["row"] == place


@pytest.mark.parametrize(
    "wrong", [{"epc": "zzzz not hex"}, {"epc": "300"}, {"antenna": -4}, {"antenna": 0}, {"code": 9999}, {"code": -5}]
)
def test_a_value_that_cannot_be_is_an_error_with_its_row(layout, wrong):
    run, line, _ = layout
    lines = [line({**row, **wrong} if k == 4 else row) for k, row in enumerate(ROWS)]
    with pytest.raises(ImportFormatError) as caught:
        run(lines)
    assert caught.value.numbers["row"] == 4
    assert "column" in caught.value.numbers


@pytest.mark.parametrize("lines", [[], [""]])
def test_a_log_without_a_read_is_an_error(layout, lines):
    with pytest.raises(ImportFormatError, match="no read is of use"):
        layout[0](lines)


def test_conventions_can_be_stated(layout):
    run, line, _ = layout
    meta = TraceMeta(frame="hall", phase_sign=-1, phase_modulus="2pi", dimensions=2)
    found = run([line(ROWS[0])], meta=meta).meta
    assert (found.frame, found.phase_sign, found.phase_modulus, found.dimensions) == ("hall", -1, "2pi", 2)
    assert found.source != "not stated"


@pytest.mark.parametrize("kind", sorted(IMPORTERS))
def test_a_path_that_is_not_there_is_bad_input(kind, tmp_path):
    with pytest.raises(InputError):
        import_log(kind, tmp_path / "nowhere.csv")


@pytest.mark.parametrize("kind", sorted(IMPORTERS))
def test_an_option_that_a_layout_has_no_use_for_is_bad_input_that_lists_the_known_ones(kind, tmp_path):
    with pytest.raises(InputError) as caught:
        import_log(kind, tmp_path, colour="blue")
    assert caught.value.numbers["option"] == "colour"
    assert "colour" not in caught.value.numbers["known"]
