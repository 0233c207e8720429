"""The JSON of `rfcompass partition`: read exactly, refused with the place of the mistake, answered in full."""

import copy
import json

import numpy as np
import pytest
from compared_scenes import random_stops

from rfcompass.errors import DegenerateAnchors, Infeasible, InputError
from rfcompass.localization.partition_file import METHODS, answer_partition, read_partition

KEYS = {
    "centre_m", "theta_rad", "orientation_norm", "satisfied_relaxed", "satisfied", "total", "epsilon", "region",
    "theta_interval_rad", "gap", "outliers", "method", "centre",
}  # fmt: skip


def as_document(stops, margins=False):
    """Write compared stops as the JSON document that describes them."""
    entries = []
    for stop in stops:
        c, pose = stop.comparisons, stop.T_newest_stop
        columns = zip(c.target.tolist(), c.nearer.tolist(), c.farther.tolist(), c.margin.tolist(), strict=True)
        entries.append({
            "pose": [pose.x_m, pose.y_m, pose.theta_rad],
            "anchors_m": stop.anchors_m.tolist(),
            "comparisons": [
                {"target": k, "nearer": i, "farther": j, **({"margin": margin} if margins else {})}
                for k, i, j, margin in columns
            ],
        })  # fmt: skip
    return {"part_points_m": stops[0].part_points_m.tolist(), "stops": entries}


def a_document(seed=0, **size):
    stops, truth = random_stops(np.random.default_rng(seed), margins=True, **size)
    return as_document(stops, margins=True), truth


def single(document):
    """The same with the keys of one stop at the top."""
    stop = document["stops"][-1]
    return {
        "part_points_m": document["part_points_m"], "anchors_m": stop["anchors_m"], "comparisons": stop["comparisons"]
    }  # fmt: skip


@pytest.mark.parametrize("method", METHODS)
def test_the_answer_has_every_key_and_survives_json(method):
    document, truth = a_document()
    answer = json.loads(json.dumps(answer_partition(json.loads(json.dumps(document)), method)))
    assert set(answer) == KEYS | ({"probability"} if method == "posterior" else set())
    assert answer["method"] == method
    assert answer["total"] == 432
    assert np.hypot(*(np.array(answer["centre_m"]) - truth.translation_m)) < 0.05
    assert 0.9 < answer["orientation_norm"] <= 1.0
    assert (answer["gap"] is None) == (method != "consistency")


def test_reading_gives_back_what_was_written():
    stops, _ = random_stops(np.random.default_rng(3), margins=True)
    again = read_partition(as_document(stops, margins=True))
    assert again.bounds_m is None
    for a, b in zip(stops, again.stops, strict=True):
        assert a.T_newest_stop == b.T_newest_stop
        for name in ("anchors_m", "part_points_m"):
            assert np.array_equal(getattr(a, name), getattr(b, name))
        for name in ("target", "nearer", "farther", "margin"):
            assert np.array_equal(getattr(a.comparisons, name), getattr(b.comparisons, name))


def test_one_stop_may_stand_at_the_top():
    document, _ = a_document(S=1)
    assert answer_partition(single(document)) == answer_partition(document)


def test_bounds_bound_the_centre():
    document, _ = a_document(S=1)
    free = answer_partition(document)
    x = free["centre_m"][0]
    bounded = answer_partition({**document, "bounds_m": [[x - 2.0, x - 1e-3], [-3.0, 3.0]]})
    assert bounded["centre_m"][0] < x - 1e-3
    assert max(p[0] for p in bounded["region"]) <= x - 1e-3 + 1e-9


def test_a_margin_may_be_absent_or_null():
    document, _ = a_document()
    del document["stops"][0]["comparisons"][0]["margin"]
    document["stops"][0]["comparisons"][1]["margin"] = None
    margin = read_partition(document).stops[0].comparisons.margin
    assert np.isnan(margin[:2]).all()
    assert np.isfinite(margin[2:]).all()


def test_contradictions_without_margins_name_consistency_which_answers():
    stops, truth = random_stops(np.random.default_rng(1), flips=0.1)
    document = as_document(stops)
    with pytest.raises(Infeasible, match="consistency"):
        answer_partition(document)
    answer = answer_partition(document, "consistency")
    assert np.hypot(*(np.array(answer["centre_m"]) - truth.translation_m)) < 0.1
    assert answer["satisfied"] + len(answer["outliers"]) == answer["total"]


def test_what_cannot_be_observed_is_null():
    answer = answer_partition(a_document(K=1)[0])
    assert answer["theta_rad"] is answer["orientation_norm"] is answer["theta_interval_rad"] is None


def change(path, value):
    """Return a function that sets or, for ..., deletes one place of a document."""

    def apply(document):
        at = document
        for key in path[:-1]:
            at = at[key]
        if value is ...:
            del at[path[-1]]
        else:
            at[path[-1]] = value
        return document

    return apply


S1 = ("stops", 1)
WRONG = {
    "no part": (change(["part_points_m"], ...), "part_points_m is missing"),
    "no part tag": (change(["part_points_m"], []), "part_points_m"),
    "flat part points": (change(["part_points_m"], [[0.0, 0.0]]), "part_points_m"),
    "no stop": (change(["stops"], []), "stops"),
    "stops no list": (change(["stops"], {}), "stops: expected a list"),
    "stop no object": (change(S1, 3), r"stops\[1\]"),
    "no pose": (change([*S1, "pose"], ...), r"stops\[1\].pose is missing"),
    "short pose": (change([*S1, "pose"], [1.0]), r"stops\[1\].pose"),
    "last pose": (change(["stops", 2, "pose"], [0.1, 0, 0]), r"stops\[2\].pose"),
    "nan anchor": (change([*S1, "anchors_m", 0], [float("nan"), 0, 0]), r"stops\[1\].anchors_m"),
    "text anchor": (change([*S1, "anchors_m", 0], ["x", 0, 0]), r"stops\[1\].anchors_m"),
    "target too large": (change([*S1, "comparisons", 5, "target"], 4), r"stops\[1\].*target 4"),
    "nearer too large": (change([*S1, "comparisons", 5, "nearer"], 9), r"stops\[1\].*nearer 9"),
    "negative index": (change([*S1, "comparisons", 5, "farther"], -1), r"comparisons\[5\].farther"),
    "fractional index": (change([*S1, "comparisons", 5, "farther"], 1.5), r"comparisons\[5\].farther"),
    "true as index": (change([*S1, "comparisons", 5, "target"], True), r"comparisons\[5\].target"),
    "missing index": (change([*S1, "comparisons", 5, "target"], ...), r"comparisons\[5\].target is missing"),
    "margin above one": (change([*S1, "comparisons", 5, "margin"], 1.5), "margin"),
    "margin nan": (change([*S1, "comparisons", 5, "margin"], float("nan")), r"comparisons\[5\].margin"),
    "empty bounds": (change(["bounds_m"], [[1, 0], [0, 1]]), "bounds_m"),
    "both forms": (change(["anchors_m"], [[0, 0, 0]]), "beside stops"),
}


@pytest.mark.parametrize("name", WRONG)
def test_bad_input_is_refused_with_its_place(name):
    spoil, message = WRONG[name]
    document = spoil(copy.deepcopy(a_document()[0]))
    with pytest.raises(InputError, match=message):
        answer_partition(document)


def test_a_document_that_is_no_object_is_refused():
    with pytest.raises(InputError):
        answer_partition([1, 2])


def test_one_anchor_or_all_in_one_place_is_refused():
    document, _ = a_document()
    for anchors in ([[0.1, 0.2, 0.3]], [[0.1, 0.2, 0.3]] * 9):
        document["stops"][1]["anchors_m"] = anchors
        for method in METHODS:
            with pytest.raises(DegenerateAnchors, match=r"stops\[1\]"):
                answer_partition(document, method)


def test_an_unknown_method_is_refused():
    with pytest.raises(InputError, match="consistency"):
        answer_partition(a_document()[0], "guess")
