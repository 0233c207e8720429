"""Methods are what docs/search.md says: the literal ones have the papers' views, updates and no memory."""

import numpy as np
import pytest

from planners.extraction import (
    FewestActionsPolicy,
    FuseBotPolicy,
    LargestMaskPolicy,
    MapMassPolicy,
    NaivePolicy,
    RandomPolicy,
    XRayPolicy,
)
from planners.search_beliefs import OwnTag, PaperBelief, PosteriorBelief, XRayBelief
from rfcompass.studies.search_methods import METHODS, search_method
from rfcompass.types import ItemSize

SIZE_M, EPC = np.array([0.06, 0.05, 0.04]), "01" * 12
# Policy, belief, gate, looks.
LITERAL = {
    "fusebot": (FuseBotPolicy, PaperBelief, True, "cluster"),
    "fusebot_no_gate": (FuseBotPolicy, PaperBelief, False, "cluster"),
    "spherical": (FuseBotPolicy, PaperBelief, True, "cluster"),
    "naive": (NaivePolicy, PaperBelief, False, "peak"),
    "naive_gate": (NaivePolicy, PaperBelief, True, "peak"),
    "xray": (XRayPolicy, type(None), False, "overhead"),
    "xray_gate": (XRayPolicy, type(None), True, "overhead"),
    "largest": (LargestMaskPolicy, type(None), False, "overhead"),
    "largest_gate": (LargestMaskPolicy, type(None), True, "overhead"),
    "random": (RandomPolicy, type(None), False, "overhead"),
    "random_gate": (RandomPolicy, type(None), True, "overhead"),
}
EQUAL = {
    "ours": (FewestActionsPolicy, PosteriorBelief),
    "ours_plain": (FewestActionsPolicy, PosteriorBelief),
    "fusebot_equal": (FuseBotPolicy, PaperBelief),
    "fusebot_posterior": (FuseBotPolicy, PosteriorBelief),
    "xray_equal": (XRayPolicy, type(None)),
    "xray_views": (MapMassPolicy, XRayBelief),
    "xray_views_no_gate": (MapMassPolicy, XRayBelief),
}


def made(name, epc=None):
    return search_method(name, ItemSize("target", SIZE_M, False, epc), 7)


def test_every_method_is_literal_or_has_our_views():
    assert set(LITERAL) | set(EQUAL) == set(METHODS)


@pytest.mark.parametrize("name", LITERAL)
def test_a_literal_method_has_the_papers_views_updates_and_no_memory(name):
    policy, belief, gate, looks = LITERAL[name]
    method = made(name)
    assert (type(method.policy), type(method.belief), method.policy.gate) == (policy, belief, gate)
    assert (method.looks, method.looks_closer, method.update_edge_m) == (looks, False, 0.10)
    assert method.scans == (method.belief is not None)
    assert (method.remembers, method.policy.remembers, method.costs) == (False, False, None)


@pytest.mark.parametrize("name", EQUAL)
def test_the_others_have_the_same_views_updates_and_memory(name):
    policy, belief = EQUAL[name]
    method = made(name)
    gate = not name.endswith("_no_gate")
    assert (type(method.policy), type(method.belief), method.policy.gate) == (policy, belief, gate)
    assert (method.looks, method.looks_closer, method.update_edge_m, method.scans) == ("overhead", True, 0.60, True)
    assert (method.remembers, method.policy.remembers) == (True, True)
    assert (method.costs is not None) == (name == "ours")


def test_the_literal_policy_measures_depth_and_gates_as_we_read_the_paper():
    policy = made("fusebot").policy
    assert (policy.per_column, policy.literal_gate) == (False, False)
    assert made("spherical").belief.rigid
    assert not made("fusebot").belief.rigid


@pytest.mark.parametrize("name", METHODS)
def test_the_targets_own_tag_is_used_wherever_there_is_a_map_of_the_paper_or_a_posterior(name):
    belief = made(name, EPC).belief
    uses = isinstance(made(name).belief, PaperBelief | PosteriorBelief)
    assert isinstance(belief, OwnTag) == uses
    if uses:
        assert (belief.epc, belief.otherwise) == (EPC, made(name).belief)
