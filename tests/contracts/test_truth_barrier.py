"""Estimators cannot see truth: no record has a slot for it, files answer as memory does, shuffled reads say nothing."""

import dataclasses
import importlib
import inspect
import pkgutil

import numpy as np
import pytest

import rfcompass.types
from rfcompass.evaluation.metrics import order_comparisons
from rfcompass.geometry import Pose2
from rfcompass.localization import ConsistencyLocalizer, PartitionLocalizer, measure_proximities, survey
from rfcompass.recordings import AntennaPoses, PartDatabase, Trace, TraceMeta, open_trace, reads_table, write_trace
from rfcompass.rf import SarNearfieldMeter
from rfcompass.robots import YouBot
from rfcompass.simulation import SweepScene, simulate_sweep
from rfcompass.studies.comparisons import wrong_comparisons
from rfcompass.studies.fetch_trace import fetch_trace
from rfcompass.studies.fetching import FetchTask, SimulatedFetch
from rfcompass.studies.radio_scan import scan_over_part
from rfcompass.studies.radio_setup import RadioSetup

# What an estimator says about its own work; goes out, never in.
FREE_FORM = {("PartEstimate", "diagnostics")}


def all_records():
    for module in pkgutil.iter_modules(rfcompass.types.__path__):
        for _, cls in inspect.getmembers(importlib.import_module(f"rfcompass.types.{module.name}"), inspect.isclass):
            if dataclasses.is_dataclass(cls):
                yield cls


def test_no_record_has_a_slot_for_truth():
    for cls in all_records():
        for field in dataclasses.fields(cls):
            assert not {"truth", "true", "actual", "error"} & set(field.name.split("_")), (cls, field.name)


def test_no_record_takes_free_form_metadata():
    for cls in all_records():
        for field in dataclasses.fields(cls):
            free_form = str(field.type) in ("dict", "Any", "object") or "Any]" in str(field.type)
            assert not free_form or (cls.__name__, field.name) in FREE_FORM, (cls, field.name, field.type)


def a_sweep(seed=3):
    tags_m = {f"30080000000000000000000{i}": np.array([0.1 + 0.2 * i, 0.7, 0.0]) for i in range(5)}
    rail_m = np.column_stack([np.linspace(0, 1, 40), np.zeros(40), np.zeros(40)])
    return SweepScene(tags_m=tags_m, antenna_positions_m=rail_m, frequencies_hz=np.array([920.6e6, 924.1e6]))


def as_trace(scene, reads):
    return Trace(
        TraceMeta(frame="rail", dimensions=2), reads_table(reads), AntennaPoses.along(scene.antenna_positions_m)
    )


@pytest.mark.parametrize("method", ["hyperbolic", "sar"])
def test_a_survey_from_a_file_is_the_survey_from_memory_to_the_last_bit(method, tmp_path):
    scene = a_sweep()
    trace = as_trace(scene, simulate_sweep(scene, np.random.default_rng(1)))
    write_trace(trace, tmp_path / "trace")
    in_memory, from_file = survey(trace.scan(), method), survey(open_trace(tmp_path / "trace").scan(), method)
    for a, b in zip(in_memory, from_file, strict=True):
        assert a.epc == b.epc
        assert np.array_equal(a.point_m, b.point_m)
        assert np.array_equal(a.box_m, b.box_m)


def test_reads_shuffled_among_the_tags_tell_nothing():
    """Each read keeps its place, frequency and phase, but gets the name of another tag."""
    scene = a_sweep()
    truth = np.array([point[0] for point in scene.tags_m.values()])
    right, shuffled = [], []
    for seed in range(6):
        rng = np.random.default_rng(seed)
        reads = simulate_sweep(scene, rng)
        names = rng.permutation([read.epc for read in reads])
        mixed = [dataclasses.replace(read, epc=str(name)) for read, name in zip(reads, names, strict=True)]
        for heard, into in ((reads, right), (mixed, shuffled)):
            fixes = survey(as_trace(scene, heard).scan(), "sar")
            into.append(order_comparisons([fix.point_m[0] for fix in fixes], truth).share)
    assert np.mean(right) == 1.0
    assert 0.25 < np.mean(shuffled) < 0.75


@pytest.mark.parametrize(
    "localizer", [PartitionLocalizer(), ConsistencyLocalizer()], ids=lambda one: type(one).__name__
)
def test_a_fetch_located_again_from_its_trace_gives_the_same_answer(localizer, tmp_path):
    leg = PartDatabase(":memory:").part("table_leg_3")
    task = FetchTask(robot=YouBot(), part=leg, tags=4, localizer=localizer, seed=2)
    run = SimulatedFetch(task)
    steps = [judged.step for judged in run.steps()]
    write_trace(fetch_trace(task.robot, run.stops), tmp_path / "trace")
    again = localizer.estimate(open_trace(tmp_path / "trace").observations(task.robot, leg))
    assert np.array_equal(again.centre_m, steps[-1].estimate.centre_m)
    assert again.theta_rad == steps[-1].estimate.theta_rad


def a_radio_stop(seed, part):
    radio = RadioSetup(scene="free_space")
    return scan_over_part(YouBot(), part, part.layout(2), radio, np.random.default_rng(seed))


def with_traces_exchanged(observation, order):
    """The same observation, but every tag has the reads of another one."""
    traces = observation.scan.traces
    names = list(traces)
    exchanged = {name: dataclasses.replace(traces[names[o]], epc=name) for name, o in zip(names, order, strict=True)}
    return dataclasses.replace(observation, scan=dataclasses.replace(observation.scan, traces=exchanged))


def test_reads_of_a_radio_exchanged_among_the_tags_tell_no_better_than_a_coin():
    part = PartDatabase(":memory:").part("table_leg_3")
    right, exchanged = [], []
    for seed in range(3):
        stop, rng = a_radio_stop(seed, part), np.random.default_rng(seed)
        order = rng.permutation(len(stop.observation.scan.traces))
        for heard, into in ((stop.observation, right), (with_traces_exchanged(stop.observation, order), exchanged)):
            matrix = measure_proximities(heard, SarNearfieldMeter(amplitude=False))
            into.extend(wrong_comparisons(matrix.m, stop.distances_m, 0.0).tolist())
    assert np.mean(right) < 0.2
    assert 0.3 < np.mean(exchanged) < 0.7


def test_a_world_that_changes_after_the_scan_changes_no_answer():
    part = PartDatabase(":memory:").part("table_leg_3")
    task = FetchTask(
        robot=YouBot(),
        part=part,
        tags=2,
        localizer=ConsistencyLocalizer(),
        seed=1,
        radio=RadioSetup(scene="free_space"),
    )
    run = SimulatedFetch(task)
    first = next(iter(run.steps())).step
    before = task.localizer.estimate([first.measured])
    run._device._true = Pose2(9.0, 9.0, 1.0)
    after = task.localizer.estimate([dataclasses.replace(first.observation, proximity=None)])
    assert np.array_equal(before.centre_m, after.centre_m)
    assert before.theta_rad == after.theta_rad
