"""The search ends when it should, with the reason, and remembers what it should; the robot plays by a script."""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np
import pytest

from planners import pile_search
from planners.extraction import ActionCosts, Cluster, LargestMaskPolicy
from planners.pile_search import PileSearch, PileSearchRules
from planners.search_beliefs import PaperBelief, PosteriorBelief
from planners.search_method import CLUSTER, NEAR_M, OVERHEAD, OVERHEAD_M, PEAK, SearchMethod
from rfcompass.arrays import FloatArray
from rfcompass.errors import ArmStopped, InputError, NothingToGrasp, OutOfReach
from rfcompass.interfaces import ExtractionPolicy
from rfcompass.mapping import VisualMap
from rfcompass.mapping.camera import points_image
from rfcompass.types import (
    DepthView,
    ExtractionAction,
    GraspAttempt,
    GraspMaps,
    InstanceMasks,
    ItemSize,
    PileLook,
    SearchResult,
    TagFix,
    VoxelGrid,
    Workspace,
)

H, W, F = 60, 80, 70.0
TABLE = Workspace.between(np.array([-0.2, -0.15, 0.0]), np.array([0.2, 0.15, 0.2]), 0.02)
TARGET = ItemSize("target", np.array([0.06, 0.04, 0.03]))
EPC, STRAY = "01" * 12, "ff" * 12
TAGGED = ItemSize("box_001", np.array([0.08, 0.05, 0.04]), False, EPC)
HELD, MISSED = GraspAttempt("held", 0.04, 2.0), GraspAttempt("missed", 0.0, 2.0)
FOUND = GraspAttempt("held", 0.04, 2.0, shows_target=True)


def down(x_m: float, y_m: float, z_m: float) -> FloatArray:
    T = np.diag([1.0, -1.0, -1.0, 1.0])
    T[:3, 3] = x_m, y_m, z_m
    return T


def image(x_m: float, y_m: float, z_m: float, *, box: bool = True, red: bool = False) -> DepthView:
    """A box of 8 x 8 x 10 cm about the origin, seen from above; its top is red if the target is in sight."""
    K = np.array([[F, 0, (W - 1) / 2], [0, F, (H - 1) / 2], [0, 0, 1.0]])
    v, u = np.indices((H, W))
    top_m = z_m - 0.10
    on_box = (abs(x_m + (u - K[0, 2]) / F * top_m) < 0.04) & (abs(y_m - (v - K[1, 2]) / F * top_m) < 0.04) & box
    colour = np.where((on_box & red)[..., None], (200, 25, 25), (120, 120, 120))
    return DepthView(np.where(on_box, top_m, z_m), K, down(x_m, y_m, z_m), colour)


@dataclass
class ScriptedRobot:
    """Grasps end as the script says; the target is in sight from a grasp on."""

    script: Sequence[GraspAttempt]
    red_from: int = 99
    box: bool = True
    fixes: tuple[TagFix, ...] = ()
    heard_later: tuple[TagFix, ...] = ()
    blind: bool = False
    red_only_below_m: float = np.inf
    out_of_reach: int = 0
    stops_at: int = 99
    elapsed_s: float = 0.0
    done: list[ExtractionAction] = field(default_factory=list)
    asked: list[ExtractionAction] = field(default_factory=list)
    scans: int = 0
    listened: int = 0
    heard_again: tuple[TagFix, ...] = ()
    asked_tags: list[tuple[TagFix, ...]] = field(default_factory=list)
    heights_m: list[float] = field(default_factory=list)
    looked_m: list[FloatArray] = field(default_factory=list)

    def scan(self) -> PileLook:
        self.scans += 1
        self.elapsed_s += 10.0
        views = [self._image(x, y, 0.7) for x, y in ((-0.1, 0.0), (0.1, 0.0), (0.0, 0.1))]
        return PileLook(tuple(views), self.fixes)

    def listen_again(self) -> tuple[TagFix, ...]:
        self.listened += 1
        self.elapsed_s += 3.0
        return self.heard_again

    def look(self, point_m: FloatArray, height_m: float, tags: Sequence[TagFix] = ()) -> PileLook:
        if self.blind:
            raise OutOfReach("the arm cannot look there")
        self.heights_m.append(height_m)
        self.looked_m.append(np.array(point_m))
        self.asked_tags.append(tuple(tags))
        epcs = [fix.epc for fix in tags]
        heard = tuple(fix for fix in self.heard_later if fix.epc in epcs)
        return PileLook((self._image(float(point_m[0]), float(point_m[1]), height_m),), heard)

    def reaches(self, action: ExtractionAction) -> bool:
        self.asked.append(action)
        return len(self.asked) > self.out_of_reach

    def grasp(self, action: ExtractionAction) -> GraspAttempt:
        self.done.append(action)
        if len(self.done) >= self.stops_at:
            raise ArmStopped("protective stop", during="grasp")
        attempt = self.script[min(len(self.done), len(self.script)) - 1]
        self.elapsed_s += attempt.duration_s
        return attempt

    def _image(self, x_m: float, y_m: float, z_m: float) -> DepthView:
        red = len(self.done) >= self.red_from and z_m < self.red_only_below_m
        return image(x_m, y_m, z_m, box=self.box, red=red)


@dataclass
class Noted:
    """A policy that takes the middle of the image and notes what it was told."""

    told: list[int] = field(default_factory=list)
    refuses: bool = False

    def choose(
        self,
        grid: VoxelGrid,
        view: DepthView,
        masks: InstanceMasks,
        grasps: GraspMaps,
        failed_m: Sequence[FloatArray] = (),
    ) -> ExtractionAction:
        if self.refuses:
            raise NothingToGrasp("nothing", masks=0)
        self.told.append(len(failed_m))
        return ExtractionAction(1, down(0.0, 0.0, 0.08), 0.06, 1.0)


class AnyMasks:
    def segment(self, view: DepthView) -> InstanceMasks:
        return InstanceMasks((view.depth_m < view.depth_m.max() - 0.05).astype(np.int64))


class AnyGrasps:
    def quality(self, view: DepthView) -> GraspMaps:
        flat = np.zeros(view.depth_m.shape)
        return GraspMaps(flat + 0.5, flat, flat + 0.05, flat + 0.02)


def search(robot: ScriptedRobot, policy: ExtractionPolicy | None = None, **more: object) -> PileSearch:
    method = SearchMethod(name="test", policy=policy or Noted(), **more)
    return PileSearch(
        robot=robot,
        method=method,
        target=TARGET,
        workspace=TABLE,
        segmenter=AnyMasks(),
        quality=AnyGrasps(),
        sizes=(TAGGED,),
    )


def fix(x_m: float, *, confident: bool = True) -> TagFix:
    return TagFix(EPC, np.array([x_m, 0.0, 0.05]), np.full(3, 0.05), confident)


def test_a_target_that_comes_into_sight_is_grasped_and_ends_the_search() -> None:
    robot = ScriptedRobot([HELD, HELD, FOUND], red_from=2)
    result = search(robot).run()
    assert (result.outcome, result.actions, result.failed_grasps) == ("found", 3, 0)
    assert [step.on_target for step in result.steps] == [False, False, True]
    assert [step.chance for step in result.steps] == [0.5] * 3  # as the grasps of every image promise


def test_a_target_in_sight_from_the_start_needs_one_action() -> None:
    policy = Noted()
    result = search(ScriptedRobot([FOUND], red_from=0), policy).run()
    assert (result.outcome, result.actions, policy.told) == ("found", 1, [])


def test_a_target_that_comes_along_ends_the_search() -> None:
    assert search(ScriptedRobot([HELD, FOUND])).run().actions == 2


def test_fifteen_actions_are_the_most() -> None:
    result = search(ScriptedRobot([HELD])).run()
    assert (result.outcome, result.actions) == ("too_many_actions", 15)


@pytest.mark.parametrize("outcome", ["slipped", "missed", "blocked"])
def test_five_failures_in_a_row_end_it_but_not_five_in_all(outcome: str) -> None:
    failed = GraspAttempt(outcome, 0.0, 2.0)
    assert search(ScriptedRobot([failed])).run().actions == 5
    script = [failed] * 4 + [HELD] + [failed] * 5
    result = search(ScriptedRobot(script)).run()
    assert (result.outcome, result.actions, result.failed_grasps) == ("too_many_failures", 10, 9)


def test_failures_are_told_only_to_methods_that_remember_and_forgotten_after_a_success() -> None:
    for remembers, told in ((True, [0, 1, 2, 0, 1]), (False, [0] * 5)):
        policy = Noted()
        robot = ScriptedRobot([MISSED, MISSED, HELD, MISSED, FOUND])
        search(robot, policy, remembers=remembers).run()
        assert policy.told == told


class WithAStrip:
    """A box in the middle, and a thing at the left border of every image that is much surer to hold."""

    def segment(self, view: DepthView) -> InstanceMasks:
        labels = (view.depth_m < view.depth_m.max() - 0.05).astype(np.int64)
        labels[20:40, :4] = 2
        return InstanceMasks(labels)

    def quality(self, view: DepthView) -> GraspMaps:
        flat = np.zeros(view.depth_m.shape)
        quality = flat + 0.2
        quality[20:40, :4] = 0.9
        return GraspMaps(quality, flat, flat + 0.05, flat + 0.02)


def with_a_strip(robot: ScriptedRobot, **more: object) -> SearchResult:
    bare = search(robot, **more)
    both = WithAStrip()
    return replace(bare, segmenter=both, quality=both).run()


@pytest.mark.parametrize("red_from", [0, 99])
def test_before_failures_end_a_search_that_counts_their_cost_a_surer_thing_is_taken(red_from: int) -> None:
    """With a loss of ten actions three more failures cost 0.9, two 3 and one 10: the fourth try goes elsewhere."""
    script = [MISSED] * 3 + [HELD] + [MISSED] * 5
    robot = ScriptedRobot(script, red_from)
    result = with_a_strip(robot, costs=ActionCosts(), looks=OVERHEAD, looks_closer=True, remembers=True)
    aside = [bool(abs(action.T_world_hand[0, 3]) > 0.1) for action in robot.done]
    assert aside[:8] == [False] * 3 + [True] + [False] * 3 + [True]
    assert [step.on_target for step in result.steps][:4] == [red_from == 0] * 3 + [False]
    for step in result.steps:  # a label is one of the image that is kept with it
        row, column = np.argwhere(step.masks.labels == step.action.mask_label)[0]
        shown_m = points_image(step.view)[row, column, :2]
        assert np.linalg.norm(shown_m - step.action.T_world_hand[:2, 3]) < 0.12
    without = ScriptedRobot(script, red_from)
    with_a_strip(without, looks_closer=True, remembers=True)
    assert not any(abs(action.T_world_hand[0, 3]) > 0.1 for action in without.done)


@pytest.mark.parametrize("remembers", [True, False])
def test_what_failed_is_remembered_beyond_a_success_elsewhere(remembers: bool) -> None:
    first = ScriptedRobot([FOUND], red_from=0)
    search(first).run()
    place_m = first.done[0].T_world_hand[:3, 3]

    class ThereThenFar(Noted):
        """The grasp that a target would get fails; then something far away is taken, and the target comes to light."""

        def choose(self, *told: object) -> ExtractionAction:
            action = super().choose(*told)  # type: ignore[arg-type]
            return replace(action, T_world_hand=down(*(place_m if len(self.told) == 1 else (0.4, 0.0, 0.05))))

    robot = ScriptedRobot([MISSED, HELD, FOUND], red_from=2)
    search(robot, ThereThenFar(), remembers=remembers).run()
    off_m = np.linalg.norm(robot.done[2].T_world_hand[:2, 3] - place_m[:2])
    assert (off_m >= 0.03) == remembers


def test_an_empty_table_ends_with_the_map_as_its_verdict() -> None:
    result = search(ScriptedRobot([HELD], box=False)).run()
    assert (result.outcome, result.actions, result.hidden_m3) == ("nothing_hidden", 0, 0.0)


def test_nothing_to_grasp_is_a_typed_end() -> None:
    assert search(ScriptedRobot([HELD]), Noted(refuses=True)).run().outcome == "nothing_to_grasp"


def test_a_pile_that_the_arm_cannot_look_at_is_a_typed_end() -> None:
    result = search(ScriptedRobot([HELD], blind=True)).run()
    assert (result.outcome, result.message) == ("out_of_reach", "the arm cannot look there")


def test_a_table_that_the_arm_cannot_go_round_is_a_typed_end() -> None:
    robot = ScriptedRobot([HELD])

    def refuse() -> PileLook:
        raise OutOfReach("the arm cannot go round the table")

    robot.scan = refuse  # type: ignore[method-assign]
    result = search(robot).run()
    assert (result.outcome, result.actions, result.hidden_m3) == ("out_of_reach", 0, 0.0)


@pytest.mark.parametrize("red_from", [0, 99])
def test_where_the_arm_cannot_look_from_near_the_image_of_all_will_do(red_from: int) -> None:
    class High(ScriptedRobot):
        """Cannot come near the table."""

        def look(self, point_m: FloatArray, height_m: float, tags: Sequence[TagFix] = ()) -> PileLook:
            if height_m < OVERHEAD_M:
                raise OutOfReach("too low")
            return super().look(point_m, height_m, tags)

    robot = High([FOUND], red_from)
    assert (search(robot).run().outcome, robot.heights_m) == ("found", [OVERHEAD_M])


def test_a_camera_below_the_table_is_not_passed_over() -> None:
    class Low(ScriptedRobot):
        """Its frames are wrong after a grasp."""

        def look(self, point_m: FloatArray, height_m: float, tags: Sequence[TagFix] = ()) -> PileLook:
            look = super().look(point_m, height_m, tags)
            if not self.done:
                return look
            low = look.views[0].T_world_camera.copy()
            low[2, 3] = -0.5
            return PileLook((replace(look.views[0], T_world_camera=low),))

    with pytest.raises(InputError, match="table"):
        search(Low([HELD, FOUND])).run()


@pytest.mark.parametrize("part", ["segmenter", "quality"])
def test_parts_that_know_another_table_are_refused(part: str) -> None:
    class OnADesk(AnyMasks, AnyGrasps):
        def __init__(self, table_m: float) -> None:
            self.table_m = table_m

    begun = search(ScriptedRobot([FOUND]))
    assert replace(begun, **{part: OnADesk(0.0)}).workspace.table_m == 0.0
    for height, said in ((0.75, r"0\.75"), (None, "None"), ("0.0", "0.0"), (np.nan, "nan")):
        with pytest.raises(InputError, match=said):
            replace(begun, **{part: OnADesk(height)})  # type: ignore[arg-type]


def test_each_action_is_told_also_the_one_after_which_the_camera_is_blocked() -> None:
    class GoesBlind(ScriptedRobot):
        """Sees nothing after a grasp."""

        def look(self, point_m: FloatArray, height_m: float, tags: Sequence[TagFix] = ()) -> PileLook:
            look = super().look(point_m, height_m, tags)
            dark = replace(look.views[0], depth_m=np.full((H, W), np.nan))
            return PileLook((dark,)) if self.done else look

    told: list[object] = []
    result = search(GoesBlind([HELD, FOUND])).run(told.append)
    assert (result.outcome, result.actions) == ("camera_blocked", 1)
    assert tuple(told) == result.steps


def test_a_method_that_looks_closer_does_so_before_each_removal() -> None:
    near, far = (ScriptedRobot([HELD, FOUND]) for _ in range(2))
    search(near, looks_closer=True).run()
    search(far).run()
    assert len(near.heights_m) == len(far.heights_m) + 2


UNSURE = TagFix(EPC, np.array([0.1, 0.0, 0.05]), np.full(3, 0.05), False)


@pytest.mark.parametrize(("fixes", "listened"), [((), 1), ((UNSURE,), 1), ((replace(UNSURE, confident=True),), 0)])
def test_a_tag_that_is_not_located_is_listened_to_on_another_way_whose_time_counts(
    fixes: tuple[TagFix, ...], listened: int
) -> None:
    robot = ScriptedRobot([FOUND], fixes=fixes)
    result = search(robot).run()
    assert (robot.scans, robot.listened) == (1, listened)
    assert result.elapsed_s == pytest.approx(10.0 + 3.0 * listened + 2.0)


def test_what_was_heard_on_both_ways_counts() -> None:
    robot = ScriptedRobot([FOUND], fixes=(UNSURE,), heard_again=(fix(0.05),))
    assert search(robot).run().tags_located == 1


def test_nobody_listens_again_where_the_target_is_in_sight_or_nothing_carries_a_tag() -> None:
    seen, untagged = ScriptedRobot([FOUND], red_from=0), ScriptedRobot([FOUND])
    search(seen).run()
    replace(search(untagged), sizes=()).run()
    assert (seen.listened, untagged.listened) == (0, 0)


def test_the_targets_own_tag_is_one_that_is_known_of() -> None:
    robot = ScriptedRobot([FOUND])
    replace(search(robot), sizes=(), target=replace(TARGET, epc=EPC)).run()
    assert robot.listened == 1


def test_another_way_that_the_arm_cannot_go_ends_nothing() -> None:
    class Stiff(ScriptedRobot):
        """Goes round in one way alone."""

        def listen_again(self) -> tuple[TagFix, ...]:
            raise OutOfReach("the arm cannot go there")

    assert search(Stiff([FOUND])).run().found


def test_located_tags_are_those_before_the_first_action() -> None:
    assert search(ScriptedRobot([FOUND], fixes=(fix(0.1),))).run().tags_located == 1
    assert search(ScriptedRobot([FOUND], fixes=(fix(0.1, confident=False),))).run().tags_located == 0


@dataclass
class NotedBelief:
    """Notes which fixes it was given."""

    seen: list[dict[str, float]] = field(default_factory=list)
    fixes: list[dict[str, TagFix]] = field(default_factory=list)

    def believe(self, seen, target, fixes, sizes):  # type: ignore[no-untyped-def]
        self.fixes.append(dict(fixes))
        self.seen.append({epc: float(one.point_m[0]) for epc, one in fixes.items()})
        return PaperBelief().believe(seen, target, {}, ())


def test_a_tag_that_is_carried_away_is_forgotten() -> None:
    belief = NotedBelief()
    gone = GraspAttempt("held", 0.04, 2.0, epcs=(EPC,))
    search(ScriptedRobot([gone, FOUND], fixes=(fix(0.1),)), belief=belief).run()
    assert [len(fixes) for fixes in belief.seen] == [1, 0]


@pytest.mark.parametrize(("x_m", "then_m"), [(0.1, 0.05), (0.4, 0.4)])
def test_a_tag_near_a_grasp_is_where_it_is_heard_next(x_m: float, then_m: float) -> None:
    belief = NotedBelief()
    robot = ScriptedRobot([HELD, FOUND], fixes=(fix(x_m),), heard_later=(fix(0.05),))
    search(robot, belief=belief).run()
    (before,), (after,) = (list(fixes.values()) for fixes in belief.seen)
    assert (before, after) == (x_m, then_m)


def test_a_tag_that_has_gone_further_than_it_is_followed_has_no_place_and_is_listened_to_no_more() -> None:
    belief = NotedBelief()
    robot = ScriptedRobot([HELD, HELD, FOUND], fixes=(fix(0.1),), heard_later=(fix(0.0, confident=False),))
    search(robot, belief=belief).run()
    assert [next(iter(told.values())).confident for told in belief.fixes] == [True, False, False]
    assert [len(tags) for tags in robot.asked_tags if tags] == [1]


def test_an_overhead_method_looks_from_where_it_sees_all() -> None:
    robot = ScriptedRobot([HELD, FOUND])
    search(robot, looks=OVERHEAD, belief=None).run()
    assert robot.heights_m[0] == OVERHEAD_M


@pytest.mark.parametrize("belief", [PaperBelief(), PosteriorBelief(), None])
def test_a_tag_that_no_database_knows_changes_nothing(belief: object) -> None:
    stray = TagFix(STRAY, np.array([0.0, 0.0, 0.05]), np.full(3, 0.05), True)
    robot = ScriptedRobot([FOUND], fixes=(stray, fix(0.1)))
    assert search(robot, belief=belief).run().found


@pytest.mark.parametrize("name", ["most_actions", "most_failures"])
def test_rules_under_which_no_search_can_begin_are_refused(name: str) -> None:
    with pytest.raises(InputError, match=name):
        PileSearchRules(**{name: 0})


def test_a_method_with_unknown_views_is_refused() -> None:
    with pytest.raises(InputError, match="cluster, peak, overhead"):
        SearchMethod(name="test", policy=Noted(), looks="sideways")
    for threshold in (-0.1, 1.0):
        with pytest.raises(InputError, match="cluster_threshold"):
            SearchMethod(name="test", policy=Noted(), cluster_threshold=threshold)


def test_the_threshold_of_the_method_says_which_part_of_the_map_is_looked_at(monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[float] = []
    cluster = pile_search.best_cluster

    def noted(grid: VoxelGrid, threshold: float) -> Cluster:
        asked.append(threshold)
        return cluster(grid, threshold)

    monkeypatch.setattr(pile_search, "best_cluster", noted)
    next(search(ScriptedRobot([HELD]), cluster_threshold=0.6).steps())
    assert asked == [0.6]


def test_a_target_that_only_the_closer_look_shows_is_grasped() -> None:
    robot = ScriptedRobot([FOUND], red_from=0, red_only_below_m=0.65)
    result = search(robot, looks=OVERHEAD, looks_closer=True).run()
    assert [step.on_target for step in result.steps] == [True]


def test_what_the_arm_cannot_reach_is_not_chosen() -> None:
    """Qualities are even: each other choice is at least 2 cm from the ones before."""
    robot = ScriptedRobot([FOUND], red_from=0, out_of_reach=3)
    search(robot).run()
    (done,) = robot.done
    refused_m = [action.T_world_hand[:2, 3] for action in robot.asked[:3]]
    assert all(np.linalg.norm(done.T_world_hand[:2, 3] - place_m) >= 0.02 for place_m in refused_m)


UNREACHED = GraspAttempt("unreachable", 0.04, 0.0, message="too far")


def test_where_the_arm_reaches_nothing_five_times_that_is_the_end_and_the_reason() -> None:
    result = search(ScriptedRobot([UNREACHED], out_of_reach=10**6)).run()
    assert (result.outcome, result.failed_grasps) == ("out_of_reach", 5)
    assert "too far" in result.message
    missed_once = search(ScriptedRobot([UNREACHED] * 4 + [MISSED], out_of_reach=10**6)).run()
    assert missed_once.outcome == "too_many_failures"


class HalfReach(ScriptedRobot):
    """Reaches the thing at the left border of the image alone."""

    def reaches(self, action: ExtractionAction) -> bool:
        self.asked.append(action)
        return bool(abs(action.T_world_hand[0, 3]) > 0.1)


@pytest.mark.parametrize("gate", [True, False])
def test_an_object_that_the_arm_cannot_reach_does_not_block_one_that_it_can(gate: bool) -> None:
    robot = HalfReach([FOUND])
    policy = LargestMaskPolicy(gate=gate, tau=0.1)
    both = WithAStrip()
    begun = search(robot, policy, looks=OVERHEAD, belief=None)
    assert replace(begun, segmenter=both, quality=both).run().found
    assert len(robot.done) == 1
    assert abs(robot.done[0].T_world_hand[0, 3]) > 0.1


class TwoPlaces:
    """A column that holds most together to the left, the highest voxel to the right."""

    def believe(self, seen: VisualMap, *_: object) -> VoxelGrid:
        values = np.zeros(seen.uncertainty().values.shape)
        values[3, 7, :4] = 0.5
        values[16, 7, 2] = 0.9
        return replace(seen.uncertainty(), values=values)


@pytest.mark.parametrize(("looks", "at_x_m"), [(CLUSTER, -0.13), (PEAK, 0.13)])
def test_an_image_is_taken_above_what_the_method_looks_at(looks: str, at_x_m: float) -> None:
    robot = ScriptedRobot([FOUND])
    assert search(robot, looks=looks, belief=TwoPlaces()).run().found
    assert robot.heights_m == [NEAR_M]
    assert robot.looked_m[0][0] == pytest.approx(at_x_m, abs=0.011)


def test_what_is_out_of_reach_above_a_cluster_does_not_block_the_rest_of_the_table() -> None:
    class AllButNear(ScriptedRobot):
        """Reaches what the image of all shows."""

        def reaches(self, action: ExtractionAction) -> bool:
            return self.heights_m[-1] == OVERHEAD_M

    robot = AllButNear([FOUND])
    assert search(robot, looks=CLUSTER).run().found
    assert robot.heights_m == [NEAR_M, OVERHEAD_M]


def test_an_attempt_that_was_none_moves_nothing_and_asks_no_tag() -> None:
    robot = ScriptedRobot([UNREACHED, HELD, FOUND], fixes=(fix(0.1),))
    search(robot).run()
    asked = [bool(tags) for tags in robot.asked_tags]
    assert asked.count(True) == 1  # after what was held alone


def test_a_surer_grasp_that_the_arm_cannot_make_is_none() -> None:
    class Middle(ScriptedRobot):
        """Reaches the middle of the table alone."""

        def reaches(self, action: ExtractionAction) -> bool:
            return bool(abs(action.T_world_hand[0, 3]) < 0.1)

    robot = Middle([MISSED])
    with_a_strip(robot, costs=ActionCosts(), looks=OVERHEAD, looks_closer=True, remembers=True)
    assert len(robot.done) == 5
    assert all(abs(action.T_world_hand[0, 3]) < 0.1 for action in robot.done)


def test_where_nothing_was_mapped_no_room_is_claimed() -> None:
    robot = ScriptedRobot([HELD])

    def refuse() -> PileLook:
        raise OutOfReach("the arm cannot go round the table")

    robot.scan = refuse  # type: ignore[method-assign]
    assert search(robot).run().room_m3 is None
    assert search(ScriptedRobot([FOUND])).run().room_m3 is not None


def test_a_grasp_that_only_the_far_image_shows_in_reach_is_made() -> None:
    class High(ScriptedRobot):
        """Reaches the grasps of a policy alone, which are 8 cm high."""

        def reaches(self, action: ExtractionAction) -> bool:
            return bool(np.isclose(action.T_world_hand[2, 3], 0.08))

    robot = High([FOUND])
    search(robot, looks=OVERHEAD, looks_closer=True).run()
    assert robot.done[0].T_world_hand[2, 3] == pytest.approx(0.08)


def test_a_target_that_only_the_image_of_all_shows_is_grasped() -> None:
    class FromAfar(ScriptedRobot):
        """Its near images are not sharp enough to show a colour."""

        def _image(self, x_m: float, y_m: float, z_m: float) -> DepthView:
            return image(x_m, y_m, z_m, box=self.box, red=z_m == OVERHEAD_M)

    result = search(FromAfar([FOUND]), Noted(refuses=True)).run()
    assert [step.on_target for step in result.steps] == [True]


def test_a_method_without_a_map_begins_with_the_image_of_all() -> None:
    robot = ScriptedRobot([HELD, FOUND])
    result = search(robot, looks=OVERHEAD, belief=None, scans=False).run()
    assert (result.outcome, robot.scans, robot.listened, robot.heights_m[0]) == ("found", 0, 0, OVERHEAD_M)


@pytest.mark.parametrize("needs", [{"belief": PaperBelief(), "looks": OVERHEAD}, {"belief": None, "looks": CLUSTER}])
def test_a_map_needs_a_scan(needs: dict[str, object]) -> None:
    with pytest.raises(InputError, match="scans"):
        SearchMethod(name="test", policy=Noted(), scans=False, **needs)


def test_a_look_after_a_grasp_that_the_arm_cannot_take_ends_nothing() -> None:
    robot = ScriptedRobot([HELD, FOUND])
    look = robot.look

    def not_after(point_m: FloatArray, height_m: float, tags: Sequence[TagFix] = ()) -> PileLook:
        if len(robot.done) > len(robot.heights_m) - 1:  # one look before each action, none after it
            raise OutOfReach("the arm cannot look there")
        return look(point_m, height_m, tags)

    robot.look = not_after  # type: ignore[method-assign]
    robot.heights_m.append(0.0)
    assert search(robot).run().actions == 2


def test_a_closer_look_that_the_arm_cannot_take_leaves_the_first_choice() -> None:
    robot = ScriptedRobot([FOUND])
    look = robot.look

    def not_near(point_m: FloatArray, height_m: float, tags: Sequence[TagFix] = ()) -> PileLook:
        if height_m < OVERHEAD_M:
            raise OutOfReach("the arm cannot look there")
        return look(point_m, height_m, tags)

    robot.look = not_near  # type: ignore[method-assign]
    assert search(robot, looks=OVERHEAD, looks_closer=True).run().actions == 1


@pytest.mark.parametrize("looks", [CLUSTER, OVERHEAD])
def test_nothing_to_take_above_the_cluster_is_no_end_before_all_was_looked_at(looks: str) -> None:
    class OnlyFromAfar(Noted):
        def choose(self, grid: VoxelGrid, view: DepthView, *more: object) -> ExtractionAction:
            if view.T_world_camera[2, 3] < OVERHEAD_M:
                raise NothingToGrasp("nothing", masks=0)
            return super().choose(grid, view, *more)  # type: ignore[arg-type]

    robot = ScriptedRobot([FOUND])
    assert search(robot, OnlyFromAfar(), looks=looks).run().found
    assert robot.heights_m == ([NEAR_M] if looks == CLUSTER else []) + [OVERHEAD_M]


def test_a_camera_that_sees_nothing_is_a_typed_end() -> None:
    robot = ScriptedRobot([HELD])
    dark = DepthView(
        np.full((H, W), np.nan), image(0, 0, 0.7).intrinsics, down(0, 0, 0.7), np.zeros((H, W, 3), np.int64)
    )
    scan = robot.scan
    robot.scan = lambda: replace(scan(), views=(dark,))  # type: ignore[method-assign]
    result = search(robot).run()
    assert (result.outcome, result.actions) == ("camera_blocked", 0)


def test_an_arm_that_stops_ends_the_search_and_what_was_done_is_kept() -> None:
    result = search(ScriptedRobot([HELD], stops_at=3)).run()
    assert (result.outcome, result.actions, result.message) == ("arm_stopped", 2, "protective stop")


def test_the_cost_of_the_last_failure_goes_by_the_rule_of_the_search() -> None:
    """With a limit of three, the third try is the last, and goes elsewhere."""
    robot = ScriptedRobot([MISSED])
    bare = search(robot, costs=ActionCosts(), looks=OVERHEAD, looks_closer=True, remembers=True)
    both = WithAStrip()
    replace(bare, segmenter=both, quality=both, rules=PileSearchRules(most_failures=3)).run()
    assert [bool(abs(action.T_world_hand[0, 3]) > 0.1) for action in robot.done] == [False, True, True]


@pytest.mark.parametrize("part", ["robot", "segmenter", "quality"])
@pytest.mark.parametrize("wrong", [None, AnyMasks, object()])
def test_a_part_that_cannot_do_its_work_is_refused_where_it_is_put_in(part: str, wrong: object) -> None:
    begun = search(ScriptedRobot([FOUND]))
    with pytest.raises(InputError, match=part):
        replace(begun, **{part: wrong})


@pytest.mark.parametrize(("part", "wrong"), [("policy", None), ("policy", AnyMasks()), ("belief", Noted())])
def test_a_method_that_cannot_do_its_work_is_refused_before_the_arm_moves(part: str, wrong: object) -> None:
    begun = search(ScriptedRobot([FOUND]))
    method = replace(begun.method, **{part: wrong})
    with pytest.raises(InputError, match=part):
        replace(begun, method=method)


class Silent:
    """Has all methods, and answers with None."""

    def segment(self, view: DepthView) -> None:
        return None

    quality = segment


class Small:
    """Answers for another image."""

    def segment(self, view: DepthView) -> InstanceMasks:
        return InstanceMasks(np.ones((3, 4), dtype=np.int64))

    def quality(self, view: DepthView) -> GraspMaps:
        return GraspMaps(*np.zeros((4, 3, 4)))


@pytest.mark.parametrize("red_from", [0, 99])
@pytest.mark.parametrize("part", ["segmenter", "quality"])
@pytest.mark.parametrize(("wrong", "what"), [(Silent(), "NoneType"), (Small(), "shape")])
def test_an_answer_that_is_none_is_named(red_from: int, part: str, wrong: object, what: str) -> None:
    with pytest.raises(InputError, match=what):
        replace(search(ScriptedRobot([HELD], red_from)), **{part: wrong}).run()


def test_a_policy_that_chooses_nothing_is_named() -> None:
    class Undecided(Noted):
        def choose(self, *told: object) -> None:  # type: ignore[override]
            return None

    with pytest.raises(InputError, match="ExtractionAction"):
        search(ScriptedRobot([HELD]), Undecided()).run()


def test_voxels_too_coarse_for_the_target_are_refused() -> None:
    begun = search(ScriptedRobot([FOUND]))
    with pytest.raises(InputError, match=r"voxels of 0\.02 m are too coarse .* an item of 0\.029 m"):
        replace(begun, target=ItemSize("target", np.array([0.06, 0.04, 0.029])))
