"""A target among references: exact places give its place back, and the study runs on measured sweeps."""

import numpy as np
import pytest

from rfcompass.studies.measured_target import FAMILIES, METHODS, Surveyed, _answer, target_trial


def exact(rng, count=16):
    places_m = rng.uniform((0.0, 0.4), (1.0, 1.0), (count + 1, 2))
    tags = [Surveyed(place_m, place_m) for place_m in places_m]
    return tags[0], tags[1:]


@pytest.mark.parametrize("method", METHODS)
def test_exact_places_give_the_target_back_as_well_as_the_method_can(method):
    """Sixteen references in a plane of 1 m by 0.6 m: nearest ones are about 0.2 m away, bisectors cut cells of 2 cm."""
    allowed_m = {"posterior": 0.02, "comparisons": 0.08, "consistency": 0.05, "nearest three": 0.25}[method]
    for seed in range(3):
        target, references = exact(np.random.default_rng(seed))
        answer = _answer(method, target, references)
        assert np.linalg.norm(answer.place_m - target.tape_m) < allowed_m
        assert (answer.held is None) == (method != "posterior")


@pytest.mark.parametrize("family", FAMILIES)
def test_a_sweep_gives_an_error_for_every_target_it_answers(measured_data, monkeypatch, family):
    monkeypatch.setenv("RFCOMPASS_MEASURED_DATA", str(measured_data))
    cell = {"family": family, "references": 8, "method": "nearest three"}
    found = target_trial(cell, 0, np.random.default_rng(0))
    assert len(found["error_m"]) > 0
    assert found["unanswered"] == 0.0
    assert found["held"] == []
