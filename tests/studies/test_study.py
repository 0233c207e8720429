import pickle
import subprocess
import sys

import pytest
from toy_study import METRICS, toy_study

from rfcompass.errors import StudyError
from rfcompass.studies.metric import Metric
from rfcompass.studies.study import PaperValue, trial_rng


def test_the_grid_is_the_product_of_the_factors():
    cells = toy_study(factors={"a": (1, 2), "b": ("x", "y", "z")}, paper=()).cells
    assert [tuple(cell.values()) for cell in cells] == [(a, b) for a in (1, 2) for b in "xyz"]


def test_a_seed_gives_the_same_bits_in_every_process():
    code = "from rfcompass.studies.study import trial_rng; print(trial_rng('toy', 5).bytes(16).hex())"
    draws = [
        subprocess.run(
            [sys.executable, "-c", code], check=True, capture_output=True, text=True, env={"PYTHONHASHSEED": s}
        )
        for s in ("1", "2")
    ]
    assert {draw.stdout.strip() for draw in draws} == {trial_rng("toy", 5).bytes(16).hex()}


def test_studies_and_seeds_have_random_numbers_of_their_own():
    draws = {trial_rng(name, seed).random() for name in ("toy", "toy-two", "toy3") for seed in range(50)}
    assert len(draws) == 150


def test_seeds_can_be_fewer_or_go_on():
    assert list(toy_study().first_seeds(3)) == [0, 1, 2]
    assert len(toy_study().first_seeds(20)) == 20
    assert list(toy_study(seeds=(4, 9)).first_seeds()) == [4, 9]
    for study, trials in ((toy_study(), 0), (toy_study(seeds=(4, 9)), 3), (toy_study(), 101)):
        with pytest.raises(StudyError):
            study.first_seeds(trials)


def test_tuning_happens_under_another_name_on_other_seeds():
    tuning = toy_study().on_tuning_seeds()
    assert (tuning.name, tuple(tuning.seeds)) == ("toy-tuning", (100, 101))
    with pytest.raises(StudyError):
        tuning.on_tuning_seeds()


def test_a_paper_value_stands_beside_every_cell_it_belongs_to():
    study = toy_study()
    found = [study.paper_value(cell, "error_m", "median") for cell in study.cells]
    assert [value is not None for value in found] == [True, True, False, False]
    assert study.paper_value(study.cells[0], "error_m", "p90") is None


@pytest.mark.parametrize(
    "changes",
    [
        {"name": "Toy Study"},
        {"factors": {"seed": (1, 2)}},
        {"factors": {"error_m": (1, 2)}},
        {"factors": {"noise_m": ()}},
        {"factors": {"noise_m": (1, "one")}},
        {"factors": {"noise_m": (1, True)}},
        {"factors": {"noise_m": (0.1, 0.1)}},
        {"metrics": (*METRICS, Metric("error_m"))},
        {"seeds": ()},
        {"seeds": (1, 1)},
        {"seeds": range(-1, 3)},
        {"tuning_seeds": (3,)},
        {"paper": (PaperValue("error_m", "mean", 1.0, ""),)},
        {"paper": (PaperValue("error_m", "median", 1.0, "", cell={"noise_m": 0.2}),)},
        {
            "paper": (
                PaperValue("error_m", "p90", 1.0, ""),
                PaperValue("error_m", "p90", 2.0, "", cell={"noise_m": 0.1}),
            )
        },
    ],
)
def test_a_declaration_that_contradicts_itself_is_refused(changes):
    with pytest.raises(StudyError):
        toy_study(**{"paper": (), **changes})


def test_a_worker_pays_for_numpy_and_nothing_heavier():
    code = "import sys, rfcompass.studies.trial; print(*sys.modules)"
    loaded = subprocess.run([sys.executable, "-c", code], check=True, capture_output=True, text=True).stdout.split()
    assert "numpy" in loaded
    assert not {"pyarrow", "joblib", "numba", "scipy", "matplotlib"} & set(loaded)


def test_a_metric_can_travel_to_a_worker():
    assert pickle.loads(pickle.dumps(METRICS)) == METRICS
