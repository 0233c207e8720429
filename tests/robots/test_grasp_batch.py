"""The compiled judge says what the readable one says; and laws that both must obey."""

from dataclasses import replace

import numpy as np
import pytest
from grasp_poses import channel, kind, over, random_poses, turned_leg
from hypothesis import given, settings
from hypothesis import strategies as st

from rfcompass import YouBot
from rfcompass.errors import InputError, ShapeError
from rfcompass.robots import hand_of, judge_grasp, judge_grasps
from rfcompass.robots.grasp_batch import VERDICTS
from rfcompass.types import Box, Cylinder, Sphere

HAND = hand_of(YouBot())
LEG = Box(np.array([0.40, 0.05, 0.05]))
# Questions decided by less than this are left out, the compiled judge's circles being polygons: a distance [m], and a
# share of the friction, the normal of a round face being good to 2.5°.
TIE_M, TIE_MU, TIE_MU_ROUND = 5e-5, 0.01, 0.11
SOLIDS = {
    "leg": (LEG, (0.25, 0.02, 0.03), 0.5, 0.0),
    "leg, far off": (LEG, (0.25, 0.10, 0.01), 3.0, 0.0),
    "tilted leg": (LEG, (0.25, 0.02, 0.03), 0.5, 0.3),
    "cube": (Box(np.full(3, 0.045)), (0.02, 0.02, 0.02), 2.0, 0.5),
    "rod": (Cylinder(0.025, 0.2), (0.12, 0.02, 0.03), 0.5, 0.2),
    "standing rod": (Cylinder(0.03, 0.045, "z"), (0.03, 0.02, 0.02), 0.5, 0.1),
    "ball": (Sphere(0.03), (0.02, 0.02, 0.03), 0.5, 0.2),
}


def ties(shape, poses, verdicts):
    """True where a step of `TIE_M`, or a slightly other friction, changes the verdict."""
    steps = [sign * TIE_M * np.eye(3)[axis] for axis in range(3) for sign in (-1, 1)]
    moved = [poses + np.pad(step[:, None], ((0, 1), (3, 0))) for step in steps]
    others = [judge_grasps(HAND, shape, T) for T in moved]
    slack = TIE_MU_ROUND if isinstance(shape, Cylinder | Sphere) else TIE_MU
    others += [judge_grasps(HAND, shape, poses, friction=mu) for mu in _frictions(len(poses), slack)]
    others += [judge_grasps(HAND.with_opening(HAND.greatest_m + d), shape, poses) for d in (-TIE_M, TIE_M)]
    others += [judge_grasps(replace(HAND, give_m=HAND.give_m * f), shape, poses) for f in (0.95, 1.05)]
    return np.any([other != verdicts for other in others], axis=0)


def _frictions(count, slack):
    return [np.full(count, HAND.friction * (1 + sign * slack)) for sign in (-1, 1)]


def agree(shape, poses):
    verdicts = judge_grasps(HAND, shape, poses)
    tied = ties(shape, poses, verdicts)
    assert tied.mean() <= 0.1
    slow = [kind(judge_grasp(HAND, shape, T)) for T in poses[~tied]]
    assert slow == [VERDICTS[v] for v in verdicts[~tied]]
    return set(slow)


@pytest.mark.parametrize("name", SOLIDS)
def test_both_judges_agree_on_solids(name):
    shape, *spread = SOLIDS[name]
    assert "holds" in agree(shape, random_poses(np.random.default_rng(40), 50, *spread))


@pytest.mark.parametrize("make", [turned_leg, channel])
def test_both_judges_agree_on_concave_meshes(make, tmp_path):
    shape = make(tmp_path).shape
    assert len(agree(shape, random_poses(np.random.default_rng(40), 50, np.array([0.14, 0.02, 0.03]), 0.4, 0.05))) > 1


@pytest.mark.slow
@pytest.mark.parametrize("name", SOLIDS)
def test_both_judges_agree_on_hundreds_of_poses_of_solids(name):
    shape, *spread = SOLIDS[name]
    agree(shape, random_poses(np.random.default_rng(41), 300, *spread))


@pytest.mark.slow
@pytest.mark.parametrize("make", [turned_leg, channel])
def test_both_judges_agree_on_hundreds_of_poses_of_meshes(make, tmp_path):
    poses = random_poses(np.random.default_rng(42), 300, np.array([0.14, 0.02, 0.03]), 0.4, 0.05)
    agree(make(tmp_path).shape, poses)


def test_a_channel_is_held_by_its_wall_or_across_it(tmp_path):
    """Concave: its hull would be hit by a finger that goes inside."""
    part = channel(tmp_path)
    assert part.shape.pieces_by == "vhacd"
    thin = replace(HAND, least_m=0.001)
    wall_m = part.shape.upper_m[1] - 0.004
    assert kind(judge_grasp(thin, part.shape, over(y=wall_m, z=0.0), opening_m=0.03)) == "holds"
    assert kind(judge_grasp(thin, Box(part.size_m), over(y=wall_m, z=0.0), opening_m=0.03)) == "too_wide"
    assert kind(judge_grasp(thin, part.shape, over(z=0.0))) == "holds"


poses_of_a_leg = st.tuples(
    st.floats(-0.22, 0.22), st.floats(-0.02, 0.02), st.floats(-0.03, 0.03), st.floats(-0.6, 0.6)
)  # fmt: skip


@given(poses_of_a_leg)
@settings(max_examples=100, deadline=None)
def test_half_a_turn_of_the_hand_is_the_same_grasp(pose):
    x, y, z, yaw = pose
    # The youBot's palm is not the same to both sides, and off its middle by 2.5 mm: a hand without it.
    bare = replace(HAND, palm_m=np.zeros((0, 2, 3)))
    both = judge_grasps(bare, LEG, np.array([over(x, y, z, yaw), over(x, y, z, yaw + np.pi)]))
    assert both[0] == both[1]


@given(poses_of_a_leg)
@settings(max_examples=100, deadline=None)
def test_half_a_turn_of_a_box_about_any_of_its_axes_is_the_same_grasp(pose):
    for axis in np.eye(3):
        turn = np.eye(4)
        turn[:3, :3] = 2 * np.outer(axis, axis) - np.eye(3)
        both = judge_grasps(HAND, LEG, np.array([over(*pose[:3], pose[3]), turn @ over(*pose[:3], pose[3])]))
        assert both[0] == both[1]


def test_what_a_hand_holds_was_between_its_jaws():
    poses = random_poses(np.random.default_rng(41), 4000, np.array([0.25, 0.10, 0.01]), 3.0, 0.0)
    held = poses[judge_grasps(HAND, LEG, poses) == VERDICTS.index("holds")]
    assert len(held) > 50
    assert np.abs(held[:, 1, 3]).max() < (HAND.greatest_m - LEG.size_m[1]) / 2


@given(poses_of_a_leg, st.floats(0.055, 0.095))
@settings(max_examples=100, deadline=None)
def test_a_wider_hand_that_comes_down_free_as_well_never_loses_what_a_narrower_one_holds(pose, opening_m):
    """Its jaws only start further out; the contacts are the same."""
    wide = HAND.with_opening(0.12)
    T = over(*pose[:3], pose[3])[None]
    if judge_grasps(wide, LEG, T, opening_m=opening_m)[0] == 0:
        assert judge_grasps(wide, LEG, T, opening_m=opening_m + 0.02)[0] == 0


@given(poses_of_a_leg)
@settings(max_examples=100, deadline=None)
def test_more_friction_never_loses_a_part(pose):
    T = np.array([over(*pose[:3], pose[3])] * 3)
    holds = judge_grasps(HAND.with_opening(0.12), LEG, T, friction=[0.2, 0.4, 0.8]) == 0
    assert (np.diff(holds.astype(int)) >= 0).all()


def test_the_contacts_move_with_the_part():
    """What is a frame to the hand is none to the part: a longer part elsewhere on it gives the same contacts."""
    longer = Box(np.array([0.8, 0.05, 0.05]))
    ours, theirs = (
        judge_grasp(HAND, LEG, over(0.1, 0.003, yaw=0.1)),
        judge_grasp(HAND, longer, over(0.3, 0.003, yaw=0.1)),
    )
    np.testing.assert_allclose(theirs.points_m - ours.points_m, [[0.2, 0, 0]] * 2, atol=1e-6)
    assert theirs.width_m == pytest.approx(ours.width_m, abs=1e-8)


def test_a_round_thing_does_not_care_for_the_heading():
    headings = np.linspace(0, 2 * np.pi, 50)
    bare = replace(HAND, palm_m=np.zeros((0, 2, 3)))
    standing = judge_grasps(
        bare, Cylinder(0.03, 0.05, "z"), np.array([over(0.002, 0.003, 0.0, yaw) for yaw in headings])
    )
    assert (standing == 0).all()


def test_weight_friction_and_bad_input_in_the_batch():
    T = np.array([over()] * 3)
    assert VERDICTS[judge_grasps(HAND, LEG, T, mass_kg=0.7)[0]] == "too_heavy"
    slippery = judge_grasps(replace(HAND, grip_n=3.0), LEG, T, mass_kg=0.166, friction=[0.1, 0.2, 0.5])
    assert [VERDICTS[v] for v in slippery] == ["too_heavy", "too_heavy", "holds"]
    assert judge_grasps(HAND, LEG, np.zeros((0, 4, 4))).shape == (0,)
    with pytest.raises(ShapeError, match="friction"):
        judge_grasps(HAND, LEG, T, friction=[0.5])
    with pytest.raises(InputError, match="above 0"):
        judge_grasps(HAND, LEG, T, friction=[0.5, 0.0, 0.5])
    with pytest.raises(ShapeError, match="not finite"):
        judge_grasps(HAND, LEG, T * np.nan)
