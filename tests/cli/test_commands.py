"""What each command answers, and how it fails: exit 0 done, 1 no answer, 2 bad input, and nothing half-written."""

import ast
import gzip
import json

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from rfcompass.cli.bench import BENCHMARKS
from rfcompass.recordings import AntennaPoses, Trace, TraceMeta, reads_table, write_trace
from rfcompass.simulation import SweepScene, simulate_sweep
from rfcompass.studies.versions import software_versions


def test_survey_answers_in_the_agreed_shape(run, sweep, tags_m):
    answer = run("survey", sweep, "--json").json
    assert answer["frame"] == "rail"
    assert [tag["epc"] for tag in answer["tags"]] == sorted(tags_m)
    for tag in answer["tags"]:
        assert set(tag) == {"epc", "point_m", "confident", "box_m"}
        assert np.linalg.norm(np.array(tag["point_m"]) - tags_m[tag["epc"]]) < 0.15


def test_the_version_is_told_with_those_of_what_decides_about_numbers(run):
    shown = run("--version")
    assert shown.code == 0
    assert shown.out.strip() == software_versions()


@pytest.mark.parametrize("method", ["hyperbolic", "sar"])
def test_survey_locates_one_tag_on_demand(run, sweep, tags_m, method):
    epc = min(tags_m)
    answer = run("survey", sweep, "--method", method, "--epc", epc, "--json").json
    assert [tag["epc"] for tag in answer["tags"]] == [epc]


@pytest.mark.parametrize("command", ["survey", "proximity"])
@pytest.mark.parametrize("epc", ["silent", "e28011"])
def test_a_tag_that_was_asked_for_and_never_heard_is_no_answer(run, sweep, command, epc):
    ran = run(command, sweep, "--epc", epc, "--json")
    assert ran.code == 1
    assert ran.json["failure"]["kind"] == "TagNeverHeard"
    assert ran.json["failure"]["epc"] == epc


def test_a_survey_from_the_wrist_says_what_to_measure_where_it_is_not_sure(run, sweep):
    """A line of one metre tells little across itself: hardly a box is small."""
    answer = run("survey", sweep, "--method", "wrist", "--json").json
    unsure = {tag["epc"] for tag in answer["tags"] if not tag["confident"]}
    assert set(answer["advice"]) == unsure
    assert all({"aid", "box_m", "enough"} == set(one) for options in answer["advice"].values() for one in options)
    said = run("survey", sweep, "--method", "wrist").out
    assert said.count("measure more") == len(unsure) > 0


def test_survey_shows_a_table_to_people(run, sweep):
    ran = run("survey", sweep)
    assert ran.code == 0
    assert "x [m]" in ran.out
    assert "never heard: silent" in ran.err


def test_proximity_answers_with_a_square_matrix(run, sweep, tags_m):
    answer = run("proximity", sweep, "--json").json
    m = np.array(answer["m"], dtype=float)
    assert answer["epcs"] == sorted(tags_m)
    assert np.isnan(np.diagonal(m)).all()
    assert np.array_equal(m, m.T, equal_nan=True)
    assert m[0, 1] < m[0, 2]
    assert answer["kind"] != "auto"


def test_tags_of_which_no_two_can_be_compared_are_no_answer(run, sweep, damaged, tags_m):
    table = pq.read_table(damaged / "reads.parquet")
    first, second, _ = sorted(tags_m)
    early = table["pose_id"].to_numpy() < 15
    epc = table["epc"].to_numpy(zero_copy_only=False)
    pq.write_table(table.filter(((epc == first) & early) | ((epc == second) & ~early)), damaged / "reads.parquet")
    ran = run("proximity", damaged)
    assert (ran.code, ran.out) == (1, "")
    failure = run("proximity", damaged, "--json").json["failure"]
    assert (failure["kind"], failure["pairs"], failure["tags"]) == ("TooFewPairs", 0, 2)


def test_proximity_of_many_tags_is_readable_without_a_terminal(run, tmp_path):
    rail_m = np.column_stack([np.linspace(0, 1, 20), np.zeros(20), np.zeros(20)])
    tags_m = {f"3008{i:020x}": np.array([0.08 * i, 0.7, 0.0]) for i in range(13)}
    scene = SweepScene(tags_m=tags_m, antenna_positions_m=rail_m, frequencies_hz=np.array([920.6e6]))
    reads = simulate_sweep(scene, np.random.default_rng(0))
    trace = Trace(TraceMeta(frame="rail", dimensions=2), reads_table(reads), AntennaPoses.along(rail_m))
    write_trace(trace, tmp_path / "t")
    m = np.array(run("proximity", tmp_path / "t", "--json").json["m"], dtype=float)
    out = run("proximity", tmp_path / "t").out
    assert "…" not in out
    assert max(map(len, out.splitlines())) <= 80
    lines = [line.replace("│", " ").split() for line in out.splitlines() if "3008" in line]
    assert len(lines) == 78
    index = {epc: i for i, epc in enumerate(sorted(tags_m))}
    assert [number for *_, number in lines] == [f"{m[index[a], index[b]]:.3g}" for a, b, _ in lines]
    listed = [float(number) for *_, number in lines]
    assert listed == sorted(listed)


@pytest.mark.parametrize("kind", ["pinit_dtw", "phase_dtw", "phase_l1", "profile_l1", "aoa", "rssi", "auto"])
def test_every_meter_is_there(run, sweep, kind):
    assert run("proximity", sweep, "--kind", kind, "--json").code == 0


def test_an_unknown_meter_is_bad_input_that_lists_the_known_ones(run, sweep):
    ran = run("proximity", sweep, "--kind", "magic")
    assert ran.code == 2
    assert "pinit_dtw" in ran.err


def without_column(folder, name):
    table = pq.read_table(folder / "reads.parquet")
    pq.write_table(table.drop_columns([name]), folder / "reads.parquet")


def with_value(folder, name, value):
    table = pq.read_table(folder / "reads.parquet")
    values = table[name].to_pylist()
    values[7] = value
    index = table.column_names.index(name)
    pq.write_table(
        table.set_column(index, name, pa.array(values, table.schema.field(name).type)), folder / "reads.parquet"
    )


def with_meta(folder, **changes):
    meta = json.loads((folder / "meta.json").read_text())
    (folder / "meta.json").write_text(json.dumps({**meta, **changes}))


def truncate(folder):
    content = (folder / "reads.parquet").read_bytes()
    (folder / "reads.parquet").write_bytes(content[: len(content) // 2])


def repeat_pose(folder):
    lines = (folder / "antenna_poses.csv").read_text().splitlines()
    (folder / "antenna_poses.csv").write_text("\n".join([*lines, lines[-1]]) + "\n")


DEFECTS = {
    "truncated Parquet": truncate,
    "missing column": lambda folder: without_column(folder, "phase_rad"),
    "NaN phase": lambda folder: with_value(folder, "phase_rad", float("nan")),
    "frequency 0": lambda folder: with_value(folder, "freq_hz", 0.0),
    "read without its pose": lambda folder: with_value(folder, "pose_id", 999),
    "pose given twice": repeat_pose,
    "duplicate EPC in meta": lambda folder: with_meta(folder, tags=[{"epc": "a"}, {"epc": "a"}]),
    "meta of another schema": lambda folder: with_meta(folder, schema="other/2"),
    "no trace at all": lambda folder: (folder / "meta.json").unlink(),
}


@pytest.mark.parametrize("command", ["survey", "proximity", "view"])
@pytest.mark.parametrize("defect", DEFECTS)
def test_a_damaged_trace_is_bad_input_and_nothing_is_written(run, damaged, command, defect):
    DEFECTS[defect](damaged)
    before = sorted(damaged.parent.rglob("*"))
    ran = run(command, damaged, "--json")
    assert ran.code == 2
    assert ran.json["failure"]["kind"] == "TraceError"
    assert sorted(damaged.parent.rglob("*")) == before


def test_a_path_that_is_not_there_is_bad_input(run, tmp_path):
    assert run("survey", tmp_path / "nowhere").code == 2


def test_view_writes_one_page(run, sweep, tags_m, tmp_path):
    page = tmp_path / "scan.html"
    assert run("view", sweep, "--out", page).code == 0
    html = page.read_text()
    assert html.count("<img") == 1 + 2 * len(tags_m)
    assert "src='data:image/png;base64," in html


def adarf_csv(x_m):
    rows = [f"a,1,921125000,0,-50,{phase},0,0,{x_m},1.63,0,0" for phase in (1.0, 1.1)]
    header = "epc,antennaIndex,frequency,time,RSSI,phase,dopplerShift,velocity,x,y,z,angle"
    return ("\ufeff" + "\n".join([header, *rows]) + "\n").encode()


def test_import_makes_a_trace_that_survey_understands(run, tmp_path):
    source = tmp_path / "campaign"
    source.mkdir()
    for index in range(3):
        (source / f"190110-01-3-1_{index}.csv.gz").write_bytes(gzip.compress(adarf_csv(0.02 * (index + 1))))
    ran = run("import", "adarf", source, "--out", tmp_path / "trace", "--json")
    assert (ran.code, ran.json["reads"], ran.json["epcs"]) == (0, 6, ["a"])
    alone = run("proximity", tmp_path / "trace", "--json")
    assert (alone.code, alone.json["failure"]["kind"], alone.json["failure"]["tags"]) == (1, "TooFewPairs", 1)
    assert run("import", "adarf", source, "--out", tmp_path / "trace").code == 2
    assert run("import", "adarf", source, "--out", tmp_path / "trace", "--overwrite").code == 0


def test_import_refuses_an_unknown_layout_and_a_broken_file(run, tmp_path):
    assert run("import", "morse", tmp_path, "--out", tmp_path / "trace").code == 2
    (tmp_path / "190110-01-3-1_0.csv").write_text("epc,nonsense\na,1\n")
    assert run("import", "adarf", tmp_path, "--out", tmp_path / "trace").code == 2
    assert not (tmp_path / "trace").exists()


def test_study_lists_what_can_be_run(run):
    names = {study["name"] for study in run("study", "list", "--json").json["studies"]}
    assert {"measured-survey", "measured-proximity"} <= names
    assert run("study", "run", "nothing").code == 2


def test_a_study_without_its_data_is_bad_input_and_leaves_nothing(run, tmp_path, monkeypatch):
    monkeypatch.setenv("RFCOMPASS_MEASURED_DATA", str(tmp_path / "nowhere"))
    ran = run("study", "run", "measured-survey", "--out", tmp_path / "out", "--json")
    assert (ran.code, ran.json["failure"]["kind"]) == (2, "StudyError")
    assert not (tmp_path / "out").exists()


def test_every_benchmark_that_bench_finds_can_be_run_by_it():
    for file in BENCHMARKS.glob("bench_*.py"):
        tree = ast.parse(file.read_text(encoding="utf-8"))
        takes = [one.args for one in tree.body if isinstance(one, ast.FunctionDef) and one.name == "run"]
        assert takes, file
        assert [given.arg for given in takes[0].args][:1] == ["fast"], file
        assert len(takes[0].args) == len(takes[0].defaults), file


def test_bench_runs_and_reports_ratios(run):
    answer = run("bench", "dtw", "--fast", "--json").json
    assert all(timing["ratio"] > 0 and timing["agreement"] < 1e-6 for timing in answer["timings"])
    assert run("bench", "nothing").code == 2
