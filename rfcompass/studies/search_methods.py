"""The ways of searching that studies and the command line know, by name.

`fusebot` and `xray` are the papers', with their own views and updates. Names that end in `_equal` have the views, the
updates of the map and the memory of failures that our own method has. `fusebot_posterior` has its map as well, and
`ours_plain` has our policy without the surer grasp before the last failure: these two differ in the policy alone.
"""

from collections.abc import Callable, Mapping
from typing import Any

from planners.extraction import (
    ActionCosts,
    FewestActionsPolicy,
    FuseBotPolicy,
    LargestMaskPolicy,
    MapMassPolicy,
    NaivePolicy,
    RandomPolicy,
    XRayPolicy,
)
from planners.search_beliefs import Belief, OwnTag, PaperBelief, PosteriorBelief, XRayBelief
from planners.search_method import OVERHEAD, PEAK, WHOLE_VIEW_M, SearchMethod
from rfcompass.errors import InputError
from rfcompass.types import ItemSize

# Choose from where one image shows all, grasp from near, look again at all that a view shows, remember failures.
_OUR_VIEWS: Mapping[str, Any] = {
    "looks": OVERHEAD,
    "looks_closer": True,
    "update_edge_m": WHOLE_VIEW_M,
    "remembers": True,
}
# Every choice from one image of all, the first included; no scan.
_ONE_IMAGE: Mapping[str, Any] = {"looks": OVERHEAD, "scans": False}
Maker = Callable[[ItemSize, int], SearchMethod]


def search_method(name: str, target: ItemSize, seed: int = 0) -> SearchMethod:
    """Make a way of searching.

    Args:
        name: One of `METHODS`.
        target: What is sought. If it carries a tag, that tag is used by every method whose belief is the paper's map
            or the posterior.
        seed: Of `random` and `random_gate`.

    Raises:
        InputError: If there is no such method.
    """
    check_search_method(name)
    return METHODS[name](target, seed)


def check_search_method(name: str) -> None:
    """Check that there is such a way of searching.

    Raises:
        InputError: If not.
    """
    if name not in METHODS:
        raise InputError(f"no way of searching is called {name!r}; known: {', '.join(METHODS)}", known=list(METHODS))


def _with_own_tag(belief: Belief, target: ItemSize) -> Belief:
    return belief if target.epc is None else OwnTag(epc=target.epc, otherwise=belief)


def _fusebot(name: str, *, gate: bool = True) -> Maker:
    return lambda target, _: SearchMethod(
        name=name,
        policy=FuseBotPolicy(gate=gate, remembers=False),
        belief=_with_own_tag(PaperBelief(), target),
    )


def _fusebot_equal(target: ItemSize, seed: int) -> SearchMethod:  # noqa: ARG001
    return SearchMethod(
        name="fusebot_equal",
        policy=FuseBotPolicy(),
        belief=_with_own_tag(PaperBelief(), target),
        **_OUR_VIEWS,
    )


def _fusebot_posterior(target: ItemSize, seed: int) -> SearchMethod:  # noqa: ARG001
    return SearchMethod(
        name="fusebot_posterior",
        policy=FuseBotPolicy(),
        belief=_with_own_tag(PosteriorBelief(), target),
        **_OUR_VIEWS,
    )


def _spherical(target: ItemSize, seed: int) -> SearchMethod:  # noqa: ARG001
    return SearchMethod(
        name="spherical",
        policy=FuseBotPolicy(remembers=False),
        belief=_with_own_tag(PaperBelief(rigid=True), target),
    )


def _xray(name: str, *, gate: bool, equal: bool = False) -> Maker:
    def make(target: ItemSize, seed: int) -> SearchMethod:  # noqa: ARG001
        policy = XRayPolicy(target_m=target.size_m, gate=gate, remembers=equal)
        return SearchMethod(name=name, policy=policy, belief=None, **(_OUR_VIEWS if equal else _ONE_IMAGE))

    return make


def _xray_views(name: str, *, gate: bool) -> Maker:
    return lambda _, __: SearchMethod(name=name, policy=MapMassPolicy(gate=gate), belief=XRayBelief(), **_OUR_VIEWS)


def _naive(name: str, *, gate: bool) -> Maker:
    return lambda target, _: SearchMethod(
        name=name,
        policy=NaivePolicy(gate=gate, remembers=False),
        belief=_with_own_tag(PaperBelief(), target),
        looks=PEAK,
    )


def _largest(name: str, *, gate: bool) -> Maker:
    return lambda _, __: SearchMethod(
        name=name, policy=LargestMaskPolicy(gate=gate, remembers=False), belief=None, **_ONE_IMAGE
    )


def _random(name: str, *, gate: bool) -> Maker:
    return lambda _, seed: SearchMethod(
        name=name, policy=RandomPolicy(seed=seed, gate=gate, remembers=False), belief=None, **_ONE_IMAGE
    )


def _ours(name: str, costs: ActionCosts | None) -> Maker:
    return lambda target, _: SearchMethod(
        name=name,
        policy=FewestActionsPolicy(target_m=target.size_m, gate=True, removals=1),
        belief=_with_own_tag(PosteriorBelief(), target),
        costs=costs,
        **_OUR_VIEWS,
    )


METHODS: Mapping[str, Maker] = {
    "fusebot": _fusebot("fusebot"),
    "fusebot_no_gate": _fusebot("fusebot_no_gate", gate=False),
    "fusebot_equal": _fusebot_equal,
    "fusebot_posterior": _fusebot_posterior,
    "spherical": _spherical,
    "xray": _xray("xray", gate=False),
    "xray_gate": _xray("xray_gate", gate=True),
    "xray_equal": _xray("xray_equal", gate=True, equal=True),
    "xray_views": _xray_views("xray_views", gate=True),
    "xray_views_no_gate": _xray_views("xray_views_no_gate", gate=False),
    "naive": _naive("naive", gate=False),
    "naive_gate": _naive("naive_gate", gate=True),
    "largest": _largest("largest", gate=False),
    "largest_gate": _largest("largest_gate", gate=True),
    "random": _random("random", gate=False),
    "random_gate": _random("random_gate", gate=True),
    "ours": _ours("ours", ActionCosts()),
    "ours_plain": _ours("ours_plain", None),
}
