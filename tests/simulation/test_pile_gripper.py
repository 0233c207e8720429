"""Executed grasps: what is held, what slips, what blocks the hand, and what becomes of the rest."""

import numpy as np
import pytest

pytest.importorskip("mujoco", reason="piles need the extra rfcompass[piles]")

from rfcompass.arrays import FloatArray
from rfcompass.errors import PileError, PileUnsettled
from rfcompass.simulation.piles import (
    D415,
    PileHand,
    PileItem,
    PilePhysics,
    PileWorld,
    cast_image,
    flat_state,
    grasp_item,
    gripper,
    look_down,
)

TIPS_M = 0.013


def item(number: int, kind: str, *size_m: float) -> PileItem:
    return PileItem(number, kind, np.array(size_m), "plastic" if kind != "cover" else "cloth", (90, 90, 90))


def at(x_m: float, y_m: float, z_m: float) -> FloatArray:
    T = np.eye(4)
    T[:3, 3] = x_m, y_m, z_m
    return T


def hand_at(x_m: float, y_m: float, tips_m: float, yaw_rad: float = 0.0) -> FloatArray:
    """Tool that points down, its tips at a height, its jaws closing along a yaw."""
    closing, down = np.array([np.cos(yaw_rad), np.sin(yaw_rad), 0.0]), np.array([0.0, 0.0, -1.0])
    T = at(x_m, y_m, tips_m + TIPS_M)
    T[:3, :3] = np.column_stack([np.cross(closing, down), closing, down])
    return T


def world_of(*placed: tuple[PileItem, FloatArray], physics: PilePhysics | None = None) -> PileWorld:
    states = {thing.number: flat_state(thing, T) for thing, T in placed}
    world = PileWorld([thing for thing, _ in placed], states, physics)
    world.settle()
    return world


@pytest.mark.parametrize("kind", ["box", "cylinder", "ellipsoid"])
@pytest.mark.parametrize("yaw_rad", [0.0, np.pi / 2])
def test_a_thing_alone_that_fits_is_held_and_gone(kind: str, yaw_rad: float) -> None:
    world = world_of((item(1, kind, 0.05, 0.05, 0.06), at(0.1, -0.05, 0.03)))
    done = grasp_item(world, hand_at(0.1, -0.05, 0.02, yaw_rad), 0.085)
    assert (done.outcome, done.taken) == ("held", (1,))
    assert done.gap_m == pytest.approx(0.05, abs=0.006)
    assert world.items == ()


def test_what_is_wider_than_the_jaws_blocks_the_hand() -> None:
    world = world_of((item(1, "box", 0.10, 0.09, 0.05), at(0, 0, 0.025)))
    done = grasp_item(world, hand_at(0, 0, 0.02), 0.085)
    assert (done.outcome, done.taken) == ("blocked", ())
    assert done.force_n > PileHand().blocked_n
    assert len(world.items) == 1


def test_where_nothing_is_the_hand_misses() -> None:
    world = world_of((item(1, "box", 0.05, 0.05, 0.05), at(0.3, 0, 0.025)))
    before = world.states[1]
    done = grasp_item(world, hand_at(0, 0, 0.01), 0.085)
    assert (done.outcome, done.gap_m) == ("missed", pytest.approx(0.0, abs=0.002))
    assert np.abs(world.states[1] - before).max() < 1e-3


@pytest.mark.parametrize(("tips_m", "outcome", "gap_m"), [(0.020, "slipped", 0.06), (0.035, "missed", 0.0)])
def test_without_friction_nothing_is_held(tips_m: float, outcome: str, gap_m: float) -> None:
    """Below its widest place the jaws have it until they lift; above that it is squeezed out while they close."""
    slippery = PilePhysics(friction=0.0, torsion_m=0.0, rolling_m=0.0)
    world = world_of((item(1, "ellipsoid", 0.06, 0.05, 0.05), at(0, 0, 0.025)), physics=slippery)
    done = grasp_item(world, hand_at(0, 0, tips_m), 0.085, PileHand(friction=0.0))
    assert (done.outcome, done.taken) == (outcome, ())
    assert done.gap_m == pytest.approx(gap_m, abs=0.005)
    assert len(world.items) == 1


def test_of_two_boxes_the_upper_one_is_taken_and_the_lower_one_stays() -> None:
    lower, upper = item(1, "box", 0.08, 0.08, 0.05), item(2, "box", 0.06, 0.05, 0.04)
    world = world_of((lower, at(0, 0, 0.025)), (upper, at(0, 0, 0.071)))
    done = grasp_item(world, hand_at(0, 0, 0.06, np.pi / 2), 0.085)
    assert (done.outcome, done.taken) == ("held", (2,))
    assert [left.number for left in world.items] == [1]
    assert world.pose(1)[2, 3] == pytest.approx(0.025, abs=0.003)


def test_what_lay_on_the_thing_falls() -> None:
    below, above = item(1, "box", 0.06, 0.05, 0.05), item(2, "box", 0.05, 0.03, 0.02)
    world = world_of((below, at(0, 0, 0.025)), (above, at(0, 0, 0.061)))
    high_m = world.pose(2)[2, 3]
    done = grasp_item(world, hand_at(0, 0, 0.015, np.pi / 2), 0.085)
    assert done.taken == (1,)
    assert world.pose(2)[2, 3] < high_m - 0.02


def test_a_cover_is_pinched() -> None:
    world = world_of((item(1, "cover", 0.20, 0.15, 0.01), at(0, 0, 0.006)))
    done = grasp_item(world, hand_at(0, 0, 0.008), 0.04)
    assert (done.outcome, done.taken, done.pinched) == ("held", (1,), True)


@pytest.mark.parametrize("share", [-0.4, -0.2, 0.2, 0.4])
@pytest.mark.parametrize("yaw_rad", [0.0, np.pi / 2])
def test_a_cover_is_held_wherever_it_is_pinched(share: float, yaw_rad: float) -> None:
    """By its end its middle rises less than the hand."""
    world = world_of((item(1, "cover", 0.24, 0.15, 0.01), at(0, 0, 0.006)))
    done = grasp_item(world, hand_at(share * 0.24, 0, 0.008, yaw_rad), 0.04)
    assert (done.outcome, done.taken, world.items) == ("held", (1,), ())


@pytest.mark.parametrize(
    ("thing", "z_m", "tips_m"),
    [(("box", 0.06, 0.05, 0.05), 0.025, 0.015), (("cover", 0.2, 0.15, 0.01), 0.006, 0.008)],
)
def test_the_slow_solver_says_what_the_fast_one_says(monkeypatch, thing, z_m: float, tips_m: float) -> None:
    done = []
    for tries in (gripper._TRIES[:1], gripper._TRIES[-2:]):
        monkeypatch.setattr(gripper, "_TRIES", tries)
        world = world_of((item(1, *thing), at(0, 0, z_m)))
        done.append(grasp_item(world, hand_at(0, 0, tips_m, np.pi / 2), 0.085))
    assert done[0].outcome == done[1].outcome == "held"
    assert done[0].gap_m == pytest.approx(done[1].gap_m, abs=1e-3)


def test_a_pinched_cover_is_lost_when_too_much_pulls() -> None:
    world = world_of((item(1, "cover", 0.20, 0.15, 0.01), at(0, 0, 0.006)))
    done = grasp_item(world, hand_at(0, 0, 0.008), 0.04, PileHand(pinch_holds_n=0.05))
    assert done.taken == ()
    assert len(world.items) == 1


def test_the_hand_leaves_no_trace() -> None:
    world = world_of((item(1, "box", 0.05, 0.05, 0.05), at(0.2, 0, 0.025)))
    geoms, view = world.model.ngeom, look_down(0.0, 0.0, 0.7)
    grasp_item(world, hand_at(0, 0, 0.01), 0.085)
    assert world.model.ngeom == geoms
    assert set(np.unique(cast_image(world, D415, view).numbers)) <= {-1, 0, 1}


def test_the_same_grasp_gives_the_same_bits() -> None:
    results = []
    for _ in range(2):
        box, capsule = item(1, "box", 0.06, 0.05, 0.05), item(2, "capsule", 0.04, 0.04, 0.09)
        world = world_of((box, at(0, 0, 0.025)), (capsule, at(0.07, 0, 0.05)))
        results.append((grasp_item(world, hand_at(0, 0, 0.015, 1.4), 0.085), world.states))
    assert results[0][0] == results[1][0]
    assert all((results[0][1][n] == results[1][1][n]).all() for n in results[0][1])


@pytest.mark.parametrize("aperture_m", [0.0, -0.01, 0.09, np.nan])
def test_an_opening_that_the_hand_does_not_have_is_refused(aperture_m: float) -> None:
    world = world_of((item(1, "box", 0.05, 0.05, 0.05), at(0, 0, 0.025)))
    with pytest.raises(PileError, match="jaws"):
        grasp_item(world, hand_at(0, 0, 0.02), aperture_m)
    assert len(world.items) == 1


def test_a_tool_that_does_not_point_down_is_refused() -> None:
    with pytest.raises(PileError, match="straight down"):
        grasp_item(PileWorld(), np.eye(4), 0.05)


@pytest.mark.parametrize("name", ["opening_m", "grip_n", "blocked_n", "speed_m_s"])
def test_a_hand_without_a_size_or_force_is_refused(name: str) -> None:
    with pytest.raises(PileError, match=name):
        PileHand(**{name: 0.0})


def test_cloth_gives_way_under_one_tip_until_the_other_has_it_too() -> None:
    prop, cover = item(1, "box", 0.03, 0.16, 0.02), item(2, "cover", 0.20, 0.15, 0.01)
    tilted = at(0.02, 0.0, 0.03)
    c, s = np.cos(0.2), np.sin(0.2)
    tilted[:3, :3] = np.array([[c, 0, s], [0, 1, 0], [-s, 0, c]])
    outcomes = []
    for gives_m in (0.03, 1e-6):
        world = world_of((prop, at(-0.05, 0, 0.01)), (cover, tilted))
        done = grasp_item(world, hand_at(0.06, 0, 0.002), 0.06, PileHand(cloth_gives_m=gives_m))
        outcomes.append(done.pinched)
    assert outcomes == [True, False]


def test_rigid_things_are_never_pinched() -> None:
    world = world_of((item(1, "box", 0.20, 0.15, 0.01), at(0, 0, 0.005)))
    done = grasp_item(world, hand_at(0, 0, 0.008), 0.04)
    assert not done.pinched
    assert done.outcome != "held"


@pytest.mark.parametrize("limit", ["_TOO_FAST_M_S", "_TOO_FAR_M"])
def test_things_that_fly_off_are_no_physics_and_leave_the_pile_as_it_was(
    limit: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """No light thing flies off here: with a limit of nearly nothing, any motion counts as that."""
    monkeypatch.setattr(gripper, limit, 1e-9)
    world = world_of(
        (item(1, "box", 0.05, 0.05, 0.06), at(0, 0, 0.03)), (item(2, "box", 0.05, 0.05, 0.04), at(0, 0, 0.08))
    )
    before = world.states
    with pytest.raises(PileUnsettled, match="blew up"):
        grasp_item(world, hand_at(0, 0, 0.02), 0.085)
    assert {n: state.tolist() for n, state in world.states.items()} == {n: s.tolist() for n, s in before.items()}


@pytest.mark.parametrize(("meet", "simulated"), [(False, [1]), (True, [1, 2])])
def test_what_was_left_out_is_simulated_if_something_came_to_touch_it(
    meet: bool, simulated: list[int], monkeypatch: pytest.MonkeyPatch
) -> None:
    world = world_of(
        (item(1, "box", 0.05, 0.05, 0.06), at(0, 0, 0.03)), (item(2, "box", 0.05, 0.05, 0.04), at(0.4, 0, 0.02))
    )
    counts, inner = [], gripper._simulated

    def simulated_too(pile: PileWorld, *more: object) -> object:
        counts.append(len(pile.items))
        return inner(pile, *more)  # type: ignore[arg-type]

    monkeypatch.setattr(gripper, "_meet", lambda whole, after: meet)
    monkeypatch.setattr(gripper, "_simulated", simulated_too)
    done = grasp_item(world, hand_at(0, 0, 0.02), 0.085)
    assert (counts, done.taken, [left.number for left in world.items]) == (simulated, (1,), [2])


def test_if_all_that_is_simulated_then_blows_up_the_pile_stays_as_it_was(monkeypatch: pytest.MonkeyPatch) -> None:
    world = world_of(
        (item(1, "box", 0.05, 0.05, 0.06), at(0, 0, 0.03)), (item(2, "box", 0.05, 0.05, 0.04), at(0.4, 0, 0.02))
    )
    before, counts = world.states, []

    def rests(pile: PileWorld) -> bool:
        counts.append(len(pile.items))
        return len(counts) == 1

    monkeypatch.setattr(gripper, "_meet", lambda whole, after: True)
    monkeypatch.setattr(gripper, "_comes_to_rest", rests)
    with pytest.raises(PileUnsettled, match="blew up"):
        grasp_item(world, hand_at(0, 0, 0.02), 0.085)
    assert counts == [0] + [1] * len(gripper._TRIES)  # without the box in the hand; then both piles, try by try
    assert {n: state.tolist() for n, state in world.states.items()} == {n: s.tolist() for n, s in before.items()}
