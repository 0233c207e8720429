"""The default meter and the literal PinIt reading on the measured development sweeps, if they are there.

The smoothing of `phase_rms` was chosen on D1train and D3; D1test, D2 and D4 were looked at afterwards.
"""

import json

import numpy as np
import pytest

from rfcompass.evaluation.metrics import JudgedComparisons, triplet_comparisons
from rfcompass.recordings import open_trace
from rfcompass.rf import meter

FAR_M = 0.195  # rows are on an even grid: gaps of 20 cm and more


@pytest.fixture(scope="module")
def judge(measured_data):
    """Judge all triplets of all sweeps of a family, by one meter."""
    scans = {}

    def scan_of(folder):
        if folder not in scans:
            scans[folder] = open_trace(folder).scan()
        return scans[folder]

    def judge_family(family, kind):
        judged = []
        for folder in sorted((measured_data / "traces").glob(f"adarf_{family}*")):
            truth = json.loads((measured_data / "truth" / f"{folder.name}.json").read_text())["tags"]
            found = meter(kind).measure(scan_of(folder))
            points_m = {tag["epc"]: tag["point_m"] for tag in truth}
            judged.append(triplet_comparisons(found.anchor_epcs, found.anchor_m, points_m))
        return JudgedComparisons(
            np.concatenate([one.correct for one in judged]), np.concatenate([one.gap_m for one in judged])
        )

    return judge_family


@pytest.mark.parametrize(("family", "least"), [("D1train", 0.95), ("D1test", 0.95), ("D2", 0.90), ("D4", 0.90)])
def test_the_default_meter_orders_the_tags_of_a_sweep(judge, family, least):
    judged = judge(family, "auto")
    assert judged.share >= least
    assert judged.within(FAR_M).share >= 0.95


@pytest.mark.parametrize("family", ["D1train", "D2", "D4"])
def test_the_literal_reading_of_pinit_is_about_as_good_as_a_coin(judge, family):
    assert 0.35 < judge(family, "pinit_dtw").share < 0.65
