"""What every belief of a search obeys: ours, the papers', the target's own tag, and the bounds that know the truth."""

import pickle
from types import SimpleNamespace

import numpy as np
import pytest

from planners.search_beliefs import OwnTag, PaperBelief, PosteriorBelief, XRayBelief
from rfcompass.errors import NothingHidden
from rfcompass.mapping import VisualMap
from rfcompass.mapping.view_kernels import FREE, SURFACE, UNOBSERVED
from rfcompass.simulation.piles import PileItem
from rfcompass.studies.search_bounds import TrueOthers, TruePlace
from rfcompass.types import ItemSize, TagFix, Workspace

TABLE = Workspace.between(np.array([-0.2, -0.2, 0.0]), np.array([0.2, 0.2, 0.16]), 0.02)
TARGET = ItemSize("target", np.array([0.06, 0.04, 0.04]))
EPC, OWN, STRAY = "01" * 12, "02" * 12, "ff" * 12
SIZES = (ItemSize("cover_1", np.array([0.10, 0.08, 0.02]), True, EPC), ItemSize("box_2", np.array([0.08, 0.05, 0.04])))
HERE, QUARTER = np.eye(4), np.array([[0.0, -1, 0, 0], [1, 0, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]])


def shifted(x_m, y_m, z_m):
    T = np.eye(4)
    T[:3, 3] = x_m, y_m, z_m
    return T


def told(T):
    """Stands for a simulated robot, which knows where a box and the target are; the world moved by T."""
    poses = {1: T @ shifted(0.045, 0.035, 0.035), 2: T @ shifted(-0.05, 0.01, 0.03)}
    sizes_m = {1: (0.04, 0.06, 0.06), 2: (0.06, 0.04, 0.04)}
    items = [PileItem(number, "box", np.array(size_m), "card", (9, 9, 9)) for number, size_m in sizes_m.items()]
    world = SimpleNamespace(items=items, pose=poses.__getitem__, panel_poses=lambda number: [poses[number]])
    return SimpleNamespace(world=world, scene=SimpleNamespace(target=2))


RECORDS = {
    "paper": PaperBelief(),
    "paper, all rigid": PaperBelief(rigid=True),
    "posterior": PosteriorBelief(),
    "xray": XRayBelief(),
    "own tag": OwnTag(epc=OWN),
    "own tag, else posterior": OwnTag(epc=OWN, otherwise=PosteriorBelief()),
}
BOUNDS = {"true place": TruePlace, "true others": TrueOthers}
every_belief = pytest.mark.parametrize("name", [*RECORDS, *BOUNDS])


def belief_of(name, T=HERE):
    return RECORDS[name] if name in RECORDS else BOUNDS[name](told(T))


def seen(*, hidden=True, turns=0, table=TABLE):
    """A heap that nobody looked into, the same from no two sides."""
    state = np.full(TABLE.shape, FREE, dtype=np.uint8)
    if hidden:
        state[5:15, 5:13, :4], state[5:15, 5:13, 4] = UNOBSERVED, SURFACE
        state[5:8, 5:9, 4:6], state[5:8, 5:9, 6] = UNOBSERVED, SURFACE
    return VisualMap(table, np.rot90(state, turns))


def fix(epc, point_m=(-0.05, 0.01, 0.04), *, confident=True, T=HERE):
    return TagFix(epc, T[:3, :3] @ point_m + T[:3, 3], np.full(3, 0.04), confident)


HEARD = {
    "nothing": {},
    "a thing": {EPC: fix(EPC)},
    "the target": {OWN: fix(OWN, (0.03, 0.0, 0.04))},
    "both": {EPC: fix(EPC), OWN: fix(OWN, (0.03, 0.0, 0.04))},
}
whatever_is_heard = pytest.mark.parametrize("fixes", HEARD.values(), ids=HEARD)


def map_of(name, fixes, sizes=SIZES, **of_map):
    return belief_of(name).believe(seen(**of_map), TARGET, fixes, sizes)


@every_belief
@whatever_is_heard
def test_the_map_is_over_the_columns_of_the_workspace_finite_and_somewhere_above_0(name, fixes):
    grid = map_of(name, fixes)
    assert np.array_equal(grid.origin_m, TABLE.origin_m)
    assert grid.spacing_m == TABLE.spacing_m
    assert grid.values.shape[:2] == TABLE.shape[:2]
    assert grid.values.shape[2] in (1, TABLE.shape[2])  # X-Ray's has one layer, on the table
    assert np.isfinite(grid.values).all()
    assert grid.values.min() >= 0 < grid.values.max()


@every_belief
@whatever_is_heard
def test_strays_and_what_is_not_located_change_nothing(name, fixes):
    plain = map_of(name, fixes).values
    assert np.array_equal(map_of(name, {**fixes, STRAY: fix(STRAY)}).values, plain)
    unsure = {epc: fix(epc, confident=False) for epc in (EPC, OWN)}
    assert map_of(name, {**unsure, **fixes}).values == pytest.approx(plain, abs=1e-12)


@pytest.mark.parametrize("name", [name for name in RECORDS if name != "xray"])
def test_the_tag_of_a_known_thing_counts_while_the_targets_is_not_located(name):
    plain, tagged = (map_of(name, {**fixes, OWN: fix(OWN, confident=False)}).values for fixes in ({}, {EPC: fix(EPC)}))
    assert np.abs(tagged - plain).max() > 1e-4


@every_belief
def test_the_database_says_nothing_about_places(name):
    assert np.array_equal(map_of(name, {}, ()).values, map_of(name, {}).values)


@every_belief
@whatever_is_heard
def test_the_order_of_tags_and_things_does_not_matter(name, fixes):
    other = map_of(name, dict(reversed(fixes.items())), SIZES[::-1])
    assert other.values == pytest.approx(map_of(name, fixes).values, abs=1e-9)


@every_belief
@whatever_is_heard
def test_the_map_moves_with_the_table(name, fixes):
    T = shifted(0.37, -0.21, 0.75)
    moved = {epc: fix(epc, one.point_m, T=T) for epc, one in fixes.items()}
    table = Workspace(TABLE.lower_m + T[:3, 3], TABLE.shape, TABLE.spacing_m)
    grid, other = map_of(name, fixes), belief_of(name, T).believe(seen(table=table), TARGET, moved, SIZES)
    assert np.array_equal(other.origin_m, table.origin_m)
    assert other.values == pytest.approx(grid.values, abs=1e-5 * grid.values.max())


@every_belief
@whatever_is_heard
def test_the_map_turns_with_what_was_seen_and_heard(name, fixes):
    """By a quarter turn, about the middle of a square table; the posterior draws where tagged things may lie."""
    share = 0.05 if "posterior" in name and EPC in fixes else 1e-5
    turned = {epc: fix(epc, one.point_m, T=QUARTER) for epc, one in fixes.items()}
    other = belief_of(name, QUARTER).believe(seen(turns=1), TARGET, turned, SIZES).values
    values = map_of(name, fixes).values
    assert other == pytest.approx(np.rot90(values), abs=share * values.max())


@every_belief
def test_what_all_views_saw_to_be_free_holds_no_target(name):
    values = map_of(name, {}).values
    beside = np.concatenate([values[:3].ravel(), values[-3:].ravel(), values[:, :3].ravel(), values[:, -3:].ravel()])
    assert beside.max() < 1e-6 * values.max()


@pytest.mark.parametrize("name", [name for name in [*RECORDS, *BOUNDS] if name != "true place"])
def test_where_nothing_is_hidden_no_place_is_left(name):
    """Who believes says so, or gives no place a value."""
    try:
        values = map_of(name, {}, hidden=False).values
    except NothingHidden:
        return
    assert not values.any()


@every_belief
def test_equal_questions_have_equal_answers_also_after_others(name):
    belief = belief_of(name)
    first = belief.believe(seen(), TARGET, HEARD["both"], SIZES).values
    belief.believe(seen(turns=1), TARGET, {}, ())
    assert np.array_equal(belief.believe(seen(), TARGET, HEARD["both"], SIZES).values, first)


@pytest.mark.parametrize("name", RECORDS)
def test_a_belief_goes_through_a_pickle(name):
    copy = pickle.loads(pickle.dumps(RECORDS[name]))
    values = copy.believe(seen(), TARGET, HEARD["both"], SIZES).values
    assert np.array_equal(values, map_of(name, HEARD["both"]).values)
