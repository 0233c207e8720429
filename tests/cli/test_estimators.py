"""Every estimator from the command line, in the agreed shape."""

import numpy as np
import pytest

SHAPE = {
    "part", "centre_m", "theta_rad", "bearing_rad", "distance_m", "covariance", "region", "probability", "method",
    "proximity", "stops", "outliers",
}  # fmt: skip


def fetched(run, folder, estimator, *options):
    where = ("--proximity", "noisy_distance", "--sigma", 0.02, "--seed", 3, "--database", ":memory:", "--json")
    return run("fetch", "table_leg_3", *where, "--estimator", estimator, "--out", folder, *options)


@pytest.mark.parametrize("estimator", ["partition", "consistency", "posterior", "sar", "nearest_tag"])
def test_fetch_answers_in_the_agreed_shape_whatever_the_estimator(run, tmp_path, estimator):
    ran = fetched(run, tmp_path / "run", estimator)
    if estimator == "nearest_tag":  # its places lie within the robot, so that it never gets the hand over the part
        assert ran.json["failure"]["kind"] == "OutOfReach"
        return
    assert ran.code == 0, ran.err
    answer = ran.json
    assert set(answer) >= SHAPE
    assert answer["method"] == estimator
    covariance = np.array(answer["covariance"], dtype=float)
    assert covariance.shape == (3, 3)
    assert np.isfinite(covariance[:2, :2]).all()
    assert np.isfinite(covariance).all() == (answer["theta_rad"] is not None)


def test_a_posterior_says_how_sure_it_is_and_null_for_what_it_cannot_tell(run, tmp_path):
    answer = fetched(run, tmp_path / "one", "posterior", "--tags", 1).json
    assert answer["theta_rad"] is None
    assert answer["covariance"][2] == [None, None, None]
    assert answer["probability"] == 0.9
    assert len(answer["region"]) >= 3
    # A simulated meter of noisy distances measures no pairs of anchors, or measures them well: either is said.
    assert answer["diagnostics"]["evidence"] in ("distances", "comparisons")
    assert answer["diagnostics"]["why"]
