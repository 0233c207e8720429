"""What tags do to what a search believes; what all beliefs obey is in `contracts/test_beliefs.py`."""

import numpy as np
import pytest

from planners.search_beliefs import OwnTag, PaperBelief
from rfcompass.mapping import VisualMap
from rfcompass.mapping.view_kernels import FREE, SURFACE, UNOBSERVED
from rfcompass.types import ItemSize, TagFix, Workspace

TABLE = Workspace.between(np.array([-0.2, -0.2, 0.0]), np.array([0.2, 0.2, 0.16]), 0.02)
TARGET = ItemSize("target", np.array([0.06, 0.04, 0.04]))
EPC, OWN = "01" * 12, "02" * 12
SOFT = ItemSize("cover_1", np.array([0.10, 0.08, 0.02]), True, EPC)


def seen(*, hidden: bool = True) -> VisualMap:
    state = np.full(TABLE.shape, FREE, dtype=np.uint8)
    if hidden:
        state[5:15, 5:15, :4], state[5:15, 5:15, 4] = UNOBSERVED, SURFACE
    return VisualMap(TABLE, state)


def fix(epc: str, x_m: float = -0.05, *, confident: bool = True) -> TagFix:
    return TagFix(epc, np.array([x_m, 0.0, 0.04]), np.full(3, 0.04), confident)


def test_in_the_papers_map_a_tag_makes_its_surroundings_less_likely() -> None:
    plain, tagged = (PaperBelief().believe(seen(), TARGET, fixes, [SOFT]).values for fixes in ({}, {EPC: fix(EPC)}))
    at = tuple(TABLE.indices(np.array([[-0.05, 0.0, 0.03]]))[0])
    assert tagged[at] < plain[at]


def test_the_spherical_kernel_differs_for_soft_items_under_load_only() -> None:
    low = TagFix(EPC, np.array([0.0, 0.0, 0.02]), np.full(3, 0.04), True)
    rigid = ItemSize("box_1", SOFT.size_m, False, EPC)
    for item, same in ((SOFT, False), (rigid, True)):
        one, other = (
            PaperBelief(rigid=flag).believe(seen(), TARGET, {EPC: low}, [item]).values for flag in (False, True)
        )
        assert (np.abs(one - other).max() < 1e-12) == same


def test_the_targets_own_tag_comes_before_cameras() -> None:
    belief = OwnTag(epc=OWN)
    for view in (seen(), seen(hidden=False)):
        grid = belief.believe(view, TARGET, {OWN: fix(OWN, 0.1)}, ())
        best = np.unravel_index(int(grid.values.argmax()), grid.values.shape)
        assert grid.origin_m + 0.02 * np.array(best) == pytest.approx([0.1, 0.0, 0.04], abs=0.015)


@pytest.mark.parametrize("fixes", [{}, {OWN: fix(OWN, confident=False)}, {OWN: fix(OWN, 3.0)}])
def test_without_a_usable_tag_of_its_own_another_belief_stands(fixes: dict[str, TagFix]) -> None:
    grid = OwnTag(epc=OWN).believe(seen(), TARGET, fixes, ())
    assert (grid.values == PaperBelief().believe(seen(), TARGET, {}, ()).values).all()
