"""Every rig gives its own methods' errors and nothing else, and a seed gives them again."""

import numpy as np
import pytest

from rfcompass.studies.accuracy import ACCURACY, AFTER, COLUMNS, METHODS, PAPER_METHOD, RIGS, accuracy_trial


def trial(rig, tags=2, seed=1, sight="in sight"):
    return accuracy_trial({"rig": rig, "tags": tags, "sight": sight}, seed, np.random.default_rng(seed))


def test_a_near_track_gives_every_method_but_the_papers():
    found = trial("near L")
    assert set(found) == set(COLUMNS)
    for count in AFTER:
        assert all(found[f"{method}_centre_{count}_m"] is not None for method in METHODS)
        assert found[f"{PAPER_METHOD}_centre_{count}_m"] is None
        assert found[f"held_{count}"] in (True, False)
        assert found[f"spread_{count}_m"] > 0.005  # the floor of the static bias is a centimetre
    assert found == trial("near L")


def test_one_tag_tells_no_orientation():
    found = trial("far L", tags=1)
    assert found["posterior_centre_3_m"] is not None
    assert found["posterior_theta_3_rad"] is None


@pytest.mark.parametrize("rig", [name for name, rig in RIGS.items() if rig.methods == (PAPER_METHOD,)])
def test_the_papers_rig_asks_its_own_method_only(rig):
    found = trial(rig, sight="hidden")
    assert all(found[f"{method}_centre_{count}_m"] is None for method in METHODS for count in AFTER)


def test_report_and_tuning_use_different_seeds():
    assert not set(ACCURACY.seeds) & set(ACCURACY.tuning_seeds)
