"""`rfcompass partition`: comparisons in, pose out."""

import json

import numpy as np
import pytest

from rfcompass.geometry import Pose2

ANCHORS_M = [[0.4, 0.06, 0.2], [0.4, -0.06, 0.2], [0.5, 0.0, 0.2], [0.3, 0.1, 0.06], [0.3, -0.1, 0.06], [0, 0.2, 0.06]]
POINTS_M = [[0.2, 0.0, 0.05], [-0.2, 0.0, 0.05]]
TRUTH = Pose2(0.42, 0.05, 1.2)


def comparisons(anchors_m=ANCHORS_M, truth=TRUTH, margins=True):
    tags_m = truth.apply(np.array(POINTS_M))
    d = np.linalg.norm(tags_m[:, None] - np.array(anchors_m)[None], axis=2)
    rows = []
    for k in range(len(d)):
        for i in range(d.shape[1]):
            for j in range(d.shape[1]):
                if d[k, i] < d[k, j]:
                    margin = {"margin": 1 - d[k, i] / d[k, j]} if margins else {}
                    rows.append({"target": k, "nearer": i, "farther": j, **margin})
    return rows


@pytest.fixture
def problem(tmp_path):
    def write(**changes):
        content = {"anchors_m": ANCHORS_M, "part_points_m": POINTS_M, "comparisons": comparisons(), **changes}
        file = tmp_path / "problem.json"
        file.write_text(json.dumps({key: value for key, value in content.items() if value is not None}))
        return file

    return write


SHAPE = {"centre_m", "theta_rad", "orientation_norm", "satisfied_relaxed", "satisfied", "total", "epsilon", "region"}


@pytest.mark.parametrize("method", ["partition", "consistency", "posterior"])
def test_it_answers_in_the_agreed_shape_and_meets_every_comparison(run, problem, method):
    answer = run("partition", problem(), "--method", method, "--json").json
    assert SHAPE | {"theta_interval_rad", "gap"} <= set(answer)
    assert np.linalg.norm(np.array(answer["centre_m"]) - TRUTH.translation_m) < 0.1
    assert answer["satisfied"] == answer["total"] == len(comparisons())


def test_several_stops_are_brought_into_the_last_frame(run, problem):
    T_last_first = Pose2(0.1, -0.2, 0.4)
    first = {
        "pose": [0.1, -0.2, 0.4],
        "anchors_m": ANCHORS_M,
        "comparisons": comparisons(truth=T_last_first.inverse() @ TRUTH),
    }
    last = {"pose": [0, 0, 0], "anchors_m": ANCHORS_M, "comparisons": comparisons()}
    file = problem(anchors_m=None, comparisons=None, stops=[first, last])
    answer = run("partition", file, "--json").json
    assert answer["total"] == 2 * len(comparisons())
    assert answer["satisfied_relaxed"] == answer["total"]
    assert np.linalg.norm(np.array(answer["centre_m"]) - TRUTH.translation_m) < 0.05


def test_comparisons_that_contradict_each_other_name_consistency(run, problem):
    rows = comparisons(margins=False)
    flipped = [{"target": row["target"], "nearer": row["farther"], "farther": row["nearer"]} for row in rows[:5]]
    ran = run("partition", problem(comparisons=rows + flipped), "--json")
    assert ran.code == 1
    assert ran.json["failure"]["kind"] == "Infeasible"
    assert "consistency" in ran.json["failure"]["message"]
    assert run("partition", problem(comparisons=rows + flipped), "--method", "consistency").code == 0


@pytest.mark.parametrize(
    ("changes", "kind"),
    [
        ({"anchors_m": ANCHORS_M[:1], "comparisons": []}, "DegenerateAnchors"),
        ({"anchors_m": [ANCHORS_M[0]] * 6}, "DegenerateAnchors"),
        ({"comparisons": [{"target": 0, "nearer": 0, "farther": 99}]}, "InputError"),
        ({"comparisons": [{"target": 0, "nearer": 0}]}, "InputError"),
        ({"part_points_m": None}, "InputError"),
        ({"bounds_m": [[1, -1], [0, 1]]}, "ShapeError"),
        ({"anchors_m": [[0, 0, None], *ANCHORS_M[1:]]}, "ShapeError"),
    ],
)
def test_a_problem_that_cannot_be_is_bad_input(run, problem, changes, kind):
    ran = run("partition", problem(**changes), "--json")
    assert (ran.code, ran.json["failure"]["kind"]) == (2, kind)


def test_a_file_that_is_no_json_is_bad_input(run, tmp_path):
    (tmp_path / "x.json").write_text("{")
    assert run("partition", tmp_path / "x.json").code == 2
    assert run("partition", tmp_path / "nowhere.json").code == 2
