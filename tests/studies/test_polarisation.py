"""One trial of the study, and what polarisation must do whatever the numbers are."""

from dataclasses import replace

import numpy as np
import pytest

from rfcompass.studies.comparisons import TAGS, robot_and_part
from rfcompass.studies.polarisation import PART_TAGS, POLARISATION, READERS, part_tag_errors_m
from rfcompass.studies.radio_scan import scan_over_part
from rfcompass.studies.radio_setup import RadioSetup
from rfcompass.studies.trial import run_trial

STUDY = POLARISATION
UPRIGHT, LYING, _ = PART_TAGS
WHIP = "vertical whip"


def scanned(part_tags, seed=0, scene="free_space"):
    """One scan with the paper's rig, whose receiver is the vertical whip."""
    robot, part = robot_and_part()
    axis, model = PART_TAGS[part_tags]
    layout = replace(part.layout(TAGS), dipoles=np.tile(axis, (TAGS, 1)))
    radio = RadioSetup(scene=scene, part_tag_model=model)
    return scan_over_part(robot, part, layout, radio, np.random.default_rng(seed))


def power_mw(stop, epc):
    """Mean power of a tag's echo along the track; none where it was silent."""
    traces = stop.observation.scan.traces
    return float((np.abs(traces[epc].channel) ** 2).mean()) if epc in traces else 0.0


@pytest.fixture(scope="module")
def upright():
    return scanned(UPRIGHT)


def test_a_trial_gives_every_metric_and_accounts_for_every_tag():
    record = run_trial(STUDY.name, STUDY.trial, STUDY.metrics, {"part_tags": LYING, "reader": WHIP}, 0)
    assert record.failure is None, record.failure
    wrong, errors_m, unheard = (record.metrics[name] for name in ("wrong", "tag_error_m", "unheard"))
    anchors = len(robot_and_part()[0].layout.epcs)
    assert set(wrong) <= {0.0, 1.0}
    assert 0 < len(wrong) <= TAGS * anchors * (anchors - 1) / 2
    assert len(errors_m) + unheard == TAGS
    assert np.isfinite(errors_m).all()
    assert min(errors_m) >= 0.0


def test_seeds_of_the_report_are_not_those_of_tuning():
    assert not set(STUDY.seeds) & set(STUDY.tuning_seeds)


def test_every_pair_of_tag_and_reader_is_a_cell_and_the_reference_is_one_of_them():
    assert len(STUDY.cells) == len(PART_TAGS) * len(READERS)
    for value in STUDY.paper:
        assert dict(value.cell) in [dict(cell) for cell in STUDY.cells]


@pytest.mark.parametrize("seed", range(3))
def test_an_upright_whip_hears_every_upright_tag_where_there_are_no_walls(seed):
    """36 dBm, at most 4.5 m from the nearer transmitter (-45 dB), 3 dB from circular to linear, 2 dB of pattern and
    slant, and the tag's 1 dB leave -13 dBm: 5 dB to spare, five standard deviations of a tag's gain."""
    stop = scanned(UPRIGHT, seed)
    assert set(stop.truth.targets.epcs) <= set(stop.observation.scan.epcs)


@pytest.mark.parametrize("seed", range(3))
def test_an_upright_whip_hears_a_lying_tag_weaker_than_an_upright_one_in_its_place(seed):
    """Along a nearly level way its field is upright; a lying tag takes the leak and the slant, a few tenths of it."""
    upright, lying = scanned(UPRIGHT, seed), scanned(LYING, seed)
    np.testing.assert_array_equal(upright.truth.targets.points_m, lying.truth.targets.points_m)
    for epc in upright.truth.targets.epcs:
        assert power_mw(lying, epc) < power_mw(upright, epc)


def test_an_error_that_all_tags_share_is_not_counted(upright):
    shift_m = np.array([0.3, -0.2, 0.0])
    truth = upright.truth
    anchors, targets = (
        replace(tags, points_m=tags.points_m + shift_m) for tags in (truth.anchors, truth.targets)
    )  # fmt: skip
    moved = replace(upright, truth=replace(truth, anchors=anchors, targets=targets))
    np.testing.assert_allclose(part_tag_errors_m(moved), part_tag_errors_m(upright), atol=1e-12)


def test_an_error_of_one_part_tag_is_its_own(upright):
    targets = upright.truth.targets
    off_m = np.zeros((TAGS, 3))
    off_m[1, 2] = 1.0
    moved = replace(upright, truth=replace(upright.truth, targets=replace(targets, points_m=targets.points_m + off_m)))
    changed_m = part_tag_errors_m(moved) - part_tag_errors_m(upright)
    assert changed_m[1] > 0.5
    assert np.delete(changed_m, 1) == pytest.approx(0.0, abs=1e-12)


def test_a_tag_that_was_not_heard_has_no_error(upright):
    scan, gone = upright.observation.scan, upright.truth.targets.epcs[2]
    traces = {epc: trace for epc, trace in scan.traces.items() if epc != gone}
    deaf = replace(upright, observation=replace(upright.observation, scan=replace(scan, traces=traces)))
    np.testing.assert_array_equal(part_tag_errors_m(deaf), np.delete(part_tag_errors_m(upright), 2))
