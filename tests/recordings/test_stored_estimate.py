"""Estimates come back from their files as they were, and every defect is named."""

import json

import numpy as np
import pytest

from rfcompass.arrays import plain
from rfcompass.cli.estimates import estimate_json
from rfcompass.errors import EstimateError, NoEstimate, ShapeError
from rfcompass.recordings import read_estimate
from rfcompass.types import PartEstimate

ESTIMATE = PartEstimate(
    "leg", np.array([0.42, 0.03]), 1.4, "posterior", 3, 0.025, np.diag([1e-4, 2e-4, 3e-3]),
    samples=np.random.default_rng(0).normal(size=(50, 3)),
)  # fmt: skip


def write(folder, samples=True, **changed):
    content = plain({**estimate_json(ESTIMATE, "auto"), **changed})
    (folder / "estimate.json").write_text(json.dumps(content), encoding="utf-8")
    if samples:
        np.savez(folder / "samples.npz", samples=ESTIMATE.samples)
    return folder


@pytest.mark.parametrize("name", [".", "estimate.json"])
def test_a_run_folder_and_its_file_give_the_estimate_back(tmp_path, name):
    back = read_estimate(write(tmp_path) / name)
    for field in ("part_id", "theta_rad", "method", "stops", "height_m"):
        assert getattr(back, field) == getattr(ESTIMATE, field)
    for field in ("centre_m", "covariance", "samples"):
        assert np.array_equal(getattr(back, field), getattr(ESTIMATE, field))


def test_an_orientation_that_was_not_observed_stays_unknown(tmp_path):
    covariance = [[1e-4, 0, None], [0, 1e-4, None], [None, None, None]]
    back = read_estimate(write(tmp_path, theta_rad=None, covariance=covariance, samples=False))
    assert back.theta_rad is None
    assert len(back.samples) == 0
    assert np.isnan(back.covariance[2]).all()


def test_a_height_that_the_file_does_not_have_must_come_from_elsewhere(tmp_path):
    file = write(tmp_path) / "estimate.json"
    content = json.loads(file.read_text(encoding="utf-8"))
    del content["height_m"]
    file.write_text(json.dumps(content), encoding="utf-8")
    assert read_estimate(file, height_m=0.04).height_m == 0.04
    with pytest.raises(EstimateError, match="height"):
        read_estimate(file)


def test_a_failure_is_no_estimate(tmp_path):
    (tmp_path / "estimate.json").write_text('{"failure": {"kind": "TagNeverHeard", "message": "none"}}')
    with pytest.raises(NoEstimate) as caught:
        read_estimate(tmp_path)
    assert caught.value.numbers["failure"] == "TagNeverHeard"


def test_a_covariance_that_is_not_finite_where_the_pose_was_observed_is_refused(tmp_path):
    with pytest.raises(ShapeError, match="covariance"):
        read_estimate(write(tmp_path, covariance=[[None] * 3] * 3))


@pytest.mark.parametrize(
    ("changed", "key"),
    [({"part": 3}, "part"), ({"theta_rad": "north"}, "theta_rad"), ({"stops": True}, "stops"),
     ({"centre_m": ["x", 1]}, "centre_m"), ({"height_m": None}, "height_m"), ({"diagnostics": [1]}, "diagnostics")],
)  # fmt: skip
def test_a_key_that_is_ill_typed_is_named(tmp_path, changed, key):
    with pytest.raises(EstimateError) as caught:
        read_estimate(write(tmp_path, **changed))
    assert caught.value.numbers["key"] == key


@pytest.mark.parametrize("text", ["", "[]", "{"])
def test_what_is_no_json_object_is_refused(tmp_path, text):
    (tmp_path / "estimate.json").write_text(text, encoding="utf-8")
    with pytest.raises(EstimateError):
        read_estimate(tmp_path)
    with pytest.raises(EstimateError):
        read_estimate(tmp_path / "nothing.json")


def test_samples_that_cannot_be_read_are_refused(tmp_path):
    write(tmp_path, samples=False)
    (tmp_path / "samples.npz").write_bytes(b"no archive")
    with pytest.raises(EstimateError, match="samples"):
        read_estimate(tmp_path)


def test_diagnostics_come_back_without_what_is_no_scalar(tmp_path):
    told = {"alpha_m": 0.01, "evidence": "distances", "lift_m": None, "modes": 1, "list": [1, 2]}
    diagnostics = read_estimate(write(tmp_path, diagnostics=told)).diagnostics
    assert dict(diagnostics) == {key: value for key, value in told.items() if key != "list"}
