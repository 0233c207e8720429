"""The whole search in a pile: look, believe, take, look again, until the target is in the drop zone [Boroushaki2023].

Our text of the paper lacks its Algorithm 1; this is rebuilt from its section 5:

1. Go round the table with camera and antennas; map what no view looked into; locate the tags (X-Ray and whatever else
   has no map: take one image of all instead).
2. If the target is in sight, grasp it; else
3. compute where it may be, and move above the cluster with the highest mean (the naive policy: the highest voxel);
4. find the objects there and the grasps, let the policy choose, grasp, and carry away what is held;
5. look again at 10 cm about the grasp, and listen again to the tags that are near it.
6. Go on at 2, until the target is in the drop zone, after 15 actions, or after 5 failed grasps in a row.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from planners.extraction import best_cluster, highest_voxel_m
from planners.failed_grasps import MOVED_M, FailedGrasps
from planners.reachable_choice import Offer, choose_within_reach
from planners.search_method import NEAR_M, OVERHEAD, OVERHEAD_M, PEAK, SearchMethod
from planners.search_parts import check_parts
from planners.target_grasp import ChosenGrasp, grasp_again, grasp_target, surest_grasp
from rfcompass.arrays import FloatArray
from rfcompass.errors import ArmStopped, CameraBlocked, InputError, NothingHidden, NothingToGrasp, OutOfReach
from rfcompass.interfaces import GraspQuality, PileRobot, Segmenter
from rfcompass.mapping import RED, ColourRule, VisualMap, find_visible_target, map_views
from rfcompass.mapping.visual_map import check_spacing
from rfcompass.types import (
    DepthView,
    InstanceMasks,
    ItemSize,
    PileLook,
    SearchResult,
    SearchStep,
    TagFix,
    VoxelGrid,
    Workspace,
)
from rfcompass.types.epc import canonical_epc
from rfcompass.types.record import Record
from rfcompass.types.search import (
    ARM_STOPPED,
    CAMERA_BLOCKED,
    FOUND,
    NOTHING_HIDDEN,
    NOTHING_TO_GRASP,
    OUT_OF_REACH,
    TOO_MANY_ACTIONS,
    TOO_MANY_FAILURES,
    UNREACHABLE,
)

_ENDS = {
    NothingHidden: NOTHING_HIDDEN,
    NothingToGrasp: NOTHING_TO_GRASP,
    OutOfReach: OUT_OF_REACH,
    CameraBlocked: CAMERA_BLOCKED,
    ArmStopped: ARM_STOPPED,
}


@dataclass(frozen=True, slots=True, kw_only=True)
class PileSearchRules(Record):
    """When a search ends.

    Attributes:
        most_actions: Actions, the paper's.
        most_failures: Failed grasps in a row, the paper's.
        extra_rounds: Rounds on another way on which the arm listens alone, while a tag that is known of is not located
            confidently; ours.
        target_colour: Which pixels are the target's.
    """

    most_actions: int = 15
    most_failures: int = 5
    extra_rounds: int = 1
    target_colour: ColourRule = RED

    def __post_init__(self) -> None:
        """Check that a search can begin."""
        if self.most_actions < 1 or self.most_failures < 1 or self.extra_rounds < 0:
            raise InputError(f"{self}: out of range", got=[self.most_actions, self.most_failures, self.extra_rounds])


@dataclass(eq=False, kw_only=True)
class PileSearch:
    """One search. It has a memory: begin another for another pile.

    Args:
        robot: The arm.
        method: How to search.
        target: What is sought: its edges.
        sizes: What the database says about tagged items.
        workspace: What is mapped, and how high the table is.
        segmenter: Tells objects apart.
        quality: Scores grasps.
        rules: When to end.

    Raises:
        InputError: If segmenter or quality have a `table_m` that is not the workspace's, if a part lacks what its role
            needs, or if the voxels are too coarse for the target.
    """

    robot: PileRobot
    method: SearchMethod
    target: ItemSize
    workspace: Workspace
    segmenter: Segmenter
    quality: GraspQuality
    sizes: Sequence[ItemSize] = ()
    rules: PileSearchRules = field(default_factory=PileSearchRules)
    _seen: VisualMap = field(init=False, repr=False)
    _fixes: dict[str, TagFix] = field(init=False, repr=False, default_factory=dict)
    _failed: FailedGrasps = field(init=False, repr=False)
    _done: list[SearchStep] = field(init=False, repr=False, default_factory=list)
    _located: int = field(init=False, repr=False, default=0)
    _in_sight: PileLook | None = field(init=False, repr=False, default=None)

    def __post_init__(self) -> None:
        """Begin with nothing seen; check that the parts fit together."""
        check_parts(self.robot, self.method, self.segmenter, self.quality, self.workspace.table_m)
        check_spacing(self.workspace.spacing_m, self.target.shortest_m)
        self._seen = VisualMap.empty(self.workspace)
        self._failed = FailedGrasps(self.method.remembers)

    def run(self, watch: Callable[[SearchStep], object] | None = None) -> SearchResult:
        """Search to the end, whatever that is.

        Args:
            watch: Called with each action once it is over.
        """
        told = 0
        try:
            for step in self.steps():
                if watch is not None:
                    watch(step)
                told += 1
                if step.attempt.shows_target:
                    return self._ended(FOUND, f"the target is in the drop zone after {len(self._done)} actions")
        except tuple(_ENDS) as why:
            if watch is not None:
                for step in self._done[told:]:  # over, though what comes after it failed
                    watch(step)
            return self._ended(next(end for kind, end in _ENDS.items() if isinstance(why, kind)), str(why))
        return self._at_the_limit()

    def _at_the_limit(self) -> SearchResult:
        """How a search ends that was stopped by its rules."""
        if self._failed.in_a_row < self.rules.most_failures:
            return self._ended(TOO_MANY_ACTIONS, f"the target was not found in {len(self._done)} actions")
        last = [step.attempt for step in self._done[-self._failed.in_a_row :]]
        if all(attempt.outcome == UNREACHABLE for attempt in last):
            return self._ended(OUT_OF_REACH, f"the arm reaches nothing that is to be taken: {last[-1].message}")
        return self._ended(TOO_MANY_FAILURES, f"{self._failed.in_a_row} grasps failed one after the other")

    def steps(self) -> Iterator[SearchStep]:
        """Scan, then act until a stop rule; yields each action once it is over, for whoever watches.

        Raises:
            NothingHidden: If nothing is hidden and no target in sight, for a method with a map.
            NothingToGrasp: If there is nothing left that could be taken.
            OutOfReach: If the arm cannot look where it should.
            CameraBlocked: If an image that goes into the map shows nothing.
            ArmStopped: If the arm stopped in the middle of a grasp.
        """
        self._scan()
        while len(self._done) < self.rules.most_actions and self._failed.in_a_row < self.rules.most_failures:
            step = self._step()
            self._done.append(step)
            self._after(step)
            yield step
            if step.attempt.shows_target:
                return

    def _scan(self) -> None:
        look = self.robot.scan() if self.method.scans else self._look_at_all()
        self._seen = map_views(self.workspace, look.views)
        self._in_sight = look
        self._hear(look.fixes)
        if self.method.scans and self._target_in_sight() is None:
            self._listen_again()
        self._located = sum(fix.confident for fix in self._fixes.values())

    def _listen_again(self) -> None:
        """Listen on another way while a tag that is known of is not located confidently."""
        known = {canonical_epc(size.epc) for size in (*self.sizes, self.target) if size.epc is not None}
        for _ in range(self.rules.extra_rounds):
            if all(epc in self._fixes and self._fixes[epc].confident for epc in known):
                return
            try:
                self._hear(self.robot.listen_again())
            except OutOfReach:
                return

    def _hear(self, fixes: Sequence[TagFix]) -> None:
        """Keep the last confident fix of each tag; of one that never had any, the first."""
        for fix in fixes:
            epc = canonical_epc(fix.epc)
            if fix.confident or epc not in self._fixes:
                self._fixes[epc] = fix

    def _step(self) -> SearchStep:
        """Grasp the target if it is in sight; else take off what the policy chooses."""
        if (middle_m := self._target_in_sight()) is not None:
            step = self._target_step(self._near_or_overhead(middle_m))
            if step is not None:
                return step
        grid = self._believed()
        view = self._view_of(grid)
        return self._target_step(view) or self._removal_step(view, grid)

    def _target_step(self, view: DepthView) -> SearchStep | None:
        """Grasp the target if this view shows it, or first a neighbour or something surer; else None."""
        found = find_visible_target(view, self.rules.target_colour)
        if found is None or not len(found.points_m):
            return None
        offer, table_m = self._offer(view, self._failed.tried_m), self.workspace.table_m
        chosen = choose_within_reach(
            offer,
            lambda left: grasp_target(view, found.pixels, left.masks, left.grasps, left.failed_m, table_m),
            self.robot.reaches,
        )
        return self._act(view, offer.masks, None, self._surer(chosen, offer) or chosen)

    def _removal_step(self, view: DepthView, grid: VoxelGrid) -> SearchStep:
        """Take off what the policy chooses."""
        if self.method.looks == OVERHEAD:
            return self._taking(view, grid, *self._choose(view, grid))
        above = self._chosen_from_near(view, grid)
        if above is not None:
            return self._taking(view, grid, *above)
        # What is seen there is flat, gone, or out of reach: the rest of the table may still hold something.
        view = self._overhead()
        return self._target_step(view) or self._taking(view, grid, *self._choose(view, grid))

    def _chosen_from_near(self, view: DepthView, grid: VoxelGrid) -> tuple[InstanceMasks, ChosenGrasp] | None:
        """The choice from an image of a part of the map; None if there is none, or none within reach."""
        try:
            masks, chosen = self._choose(view, grid)
        except NothingToGrasp:
            return None
        return (masks, chosen) if chosen.reached else None

    def _taking(self, view: DepthView, grid: VoxelGrid, masks: InstanceMasks, chosen: ChosenGrasp) -> SearchStep:
        """Grasp what was chosen, after a closer look if the method has one."""
        if not self.method.looks_closer:
            return self._act(view, masks, grid, chosen)
        return self._closer_step(view, masks, grid, chosen)

    def _choose(self, view: DepthView, grid: VoxelGrid) -> tuple[InstanceMasks, ChosenGrasp]:
        """Objects in a view, and the removal that the policy chooses."""
        offer = self._offer(view, tuple(self._failed.recent_m) if self.method.remembers else ())

        def choose(left: Offer) -> ChosenGrasp:
            action = self.method.policy.choose(grid, view, left.masks, left.grasps, left.failed_m)
            return ChosenGrasp(action, left.chance_of(action))

        return offer.masks, choose_within_reach(offer, choose, self.robot.reaches)

    def _offer(self, view: DepthView, failed_m: Sequence[FloatArray]) -> Offer:
        """Objects in a view, and the grasps on them."""
        return Offer(view, self.segmenter.segment(view), self.quality.quality(view), failed_m)

    def _closer_step(self, view: DepthView, masks: InstanceMasks, grid: VoxelGrid, first: ChosenGrasp) -> SearchStep:
        """Grasp the same object as an image from near above shows it; as before if that shows no grasp in reach.

        Labels are those of the first image, but for a surer grasp elsewhere, which only the second one shows.
        """
        action = first.action
        try:
            near = self.robot.look(action.T_world_hand[:3, 3], NEAR_M).views[0]
        except OutOfReach:
            return self._act(view, masks, grid, first)
        if (step := self._target_step(near)) is not None:
            return step
        offer = self._offer(near, self._failed.tried_m if self.method.remembers else ())
        again = choose_within_reach(
            offer,
            lambda left: grasp_again(action, near, offer.masks, left.grasps, left.failed_m),
            self.robot.reaches,
            objects=False,
        )
        chosen = again if again is not None and again.reached else first
        surer = self._surer(chosen, offer)
        if surer is not None:
            return self._act(near, offer.masks, grid, surer)
        return self._act(view, masks, grid, chosen)

    def _surer(self, chosen: ChosenGrasp, offer: Offer) -> ChosenGrasp | None:
        """A surer grasp elsewhere, where it costs less than what one more failure would put at risk; else None.

        It costs one action, and spares the difference of the chances of failing, times the risk.
        """
        if (costs := self.method.costs) is None:
            return None
        risk = replace(costs, failures=self.rules.most_failures).risk(self._failed.in_a_row)
        if not risk > 1.0:
            return None
        surer = choose_within_reach(
            replace(offer, failed_m=self._failed.tried_m),
            lambda left: surest_grasp(left.view, left.masks, left.grasps, left.failed_m),
            self.robot.reaches,
        )
        better = surer is not None and surer.reached and (surer.chance - chosen.chance) * risk > 1.0
        return surer if better else None

    def _believed(self) -> VoxelGrid:
        belief = self.method.belief
        if belief is None:
            return self._seen.uncertainty()
        grid = belief.believe(self._seen, self.target, self._fixes, self.sizes)
        if not grid.values.max() > 0:
            voxels = int(self._seen.covered.sum())
            raise NothingHidden("no place is left where the target could be", voxels=voxels)
        return grid

    def _view_of(self, grid: VoxelGrid) -> DepthView:
        """The image in which the next grasp is chosen."""
        if self.method.looks == OVERHEAD:
            return self._overhead()
        if self.method.looks == PEAK:
            return self._near_or_overhead(highest_voxel_m(grid))
        return self._near_or_overhead(best_cluster(grid, self.method.cluster_threshold).point_m)

    def _near_or_overhead(self, point_m: FloatArray) -> DepthView:
        """The image from near above a place; that of all if the arm cannot look from there."""
        try:
            return self.robot.look(point_m, NEAR_M).views[0]
        except OutOfReach:
            return self._overhead()

    def _overhead(self) -> DepthView:
        """The image that shows all piles."""
        return self._look_at_all().views[0]

    def _look_at_all(self) -> PileLook:
        return self.robot.look((self.workspace.lower_m + self.workspace.upper_m) / 2, OVERHEAD_M)

    def _act(
        self,
        view: DepthView,
        masks: InstanceMasks,
        grid: VoxelGrid | None,
        chosen: ChosenGrasp,
    ) -> SearchStep:
        hidden_m3, action = self._seen.unobserved_m3, chosen.action
        attempt = self.robot.grasp(action)
        at_s, promised = self.robot.elapsed_s, chosen.chance
        return SearchStep(view, masks, grid, action, chosen.on_target, attempt, hidden_m3, at_s, promised)

    def _after(self, step: SearchStep) -> None:
        """Remember what failed, forget tags that are gone, look again at where the hand was."""
        point_m = step.action.T_world_hand[:3, 3]
        if step.attempt.success:
            self._failed.succeeded(point_m)
            for epc in step.attempt.epcs:
                self._fixes.pop(canonical_epc(epc), None)
        else:
            self._failed.failed(point_m)
        if step.attempt.shows_target:
            return
        if step.attempt.outcome == UNREACHABLE:  # nothing was touched, and what was seen is still so
            return
        near = [
            fix for fix in self._fixes.values() if fix.confident and np.linalg.norm(fix.point_m - point_m) < MOVED_M
        ]
        try:
            look = self.robot.look(point_m, NEAR_M, near)
        except OutOfReach:  # the map stays as it was; the next image is taken before the next action
            self._in_sight = None
            return
        self._seen = _refreshed(self._seen, look.views, point_m, self.method.update_edge_m)
        self._in_sight = look
        self._fixes |= {canonical_epc(fix.epc): fix for fix in look.fixes}

    def _target_in_sight(self) -> FloatArray | None:
        """Middle of the target's pixels in the last look that shows it, in the world [m], shape (3,)."""
        for view in () if self._in_sight is None else self._in_sight.views:
            found = find_visible_target(view, self.rules.target_colour)
            if found is not None and len(found.points_m):
                return np.asarray(np.median(found.points_m, axis=0))
        return None

    def _ended(self, outcome: str, message: str) -> SearchResult:
        return SearchResult(
            outcome,
            message,
            tuple(self._done),
            self.robot.elapsed_s,
            self._seen.unobserved_m3,
            self._located,
            self._seen.room_m3(float(self.target.size_m.min())) if self._seen.covered.any() else None,
        )


def _refreshed(seen: VisualMap, views: Sequence[DepthView], point_m: FloatArray, edge_m: float) -> VisualMap:
    """The map with a cube looked at again; as it was if the hand was beside all that is mapped."""
    return seen.refreshed(views, point_m, edge_m) if seen.meets_cube(point_m, edge_m) else seen
