"""One search in a simulated pile, and what the truth says about it."""

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from planners.grasp_quality import AntipodalQuality
from planners.pile_search import PileSearch, PileSearchRules
from planners.search_method import SearchMethod
from rfcompass.interfaces import GraspQuality, Segmenter
from rfcompass.localization import SarSurveyor
from rfcompass.mapping import DepthSegmenter
from rfcompass.simulation.piles import PileScene, TaggedItems, tag_items
from rfcompass.studies.pile_robot import SimulatedPileRobot
from rfcompass.studies.pile_scan import PILE_SAR, workspace
from rfcompass.types import DepthView, InstanceMasks, SearchResult, SearchStep
from rfcompass.types.counts import check_count

SPACING_M = 0.01


@dataclass(eq=False)
class TrueMasks:
    """A `Segmenter` that makes no mistake: it is told by the simulator, and studies that use it say so."""

    robot: SimulatedPileRobot

    def segment(self, view: DepthView) -> InstanceMasks:
        """Which item each pixel of one of the robot's last views shows."""
        return self.robot.true_masks(view)


@dataclass(frozen=True, slots=True)
class SearchTask:
    """What is searched, and with what.

    Attributes:
        scene: The pile.
        tags: Which items are tagged.
        seed: Of all noise.
        quality: Scores grasps.
        segmenter: Tells objects apart; None for masks that the simulator tells.
        rules: When to end.
        spacing_m: Edge of a voxel [m].
        absent: Whether the target is taken away before, so that it is sought in vain.
        surveyor: Locates tags, and says which of them confidently.
    """

    scene: PileScene
    tags: TaggedItems
    seed: int
    quality: GraspQuality = field(default_factory=AntipodalQuality)
    segmenter: Segmenter | None = field(default_factory=DepthSegmenter)
    rules: PileSearchRules = field(default_factory=PileSearchRules)
    spacing_m: float = SPACING_M
    absent: bool = False
    surveyor: SarSurveyor = PILE_SAR

    def __post_init__(self) -> None:
        """Check the seed."""
        check_count(self.seed, "SearchTask.seed")

    def robot(self) -> SimulatedPileRobot:
        """Put a robot over the pile."""
        return SimulatedPileRobot(
            scene=self.scene, tags=self.tags, seed=self.seed, absent=self.absent, surveyor=self.surveyor
        )


@dataclass(eq=False)
class SearchRun:
    """A search, with the robot that did it.

    Attributes:
        task: What was searched.
        method: How.
        robot: Who; knows what was taken, and how it moved.
        search: The planner.
    """

    task: SearchTask
    method: SearchMethod
    robot: SimulatedPileRobot
    search: PileSearch = field(init=False)

    def __post_init__(self) -> None:
        """Stand ready."""
        task = self.task
        self.search = PileSearch(
            robot=self.robot,
            method=self.method,
            target=task.tags.target_size,
            sizes=task.tags.sizes,
            workspace=workspace(task.spacing_m),
            segmenter=TrueMasks(self.robot) if task.segmenter is None else task.segmenter,
            quality=task.quality,
            rules=task.rules,
        )

    @staticmethod
    def of(task: SearchTask, method: SearchMethod) -> "SearchRun":
        """Put a robot of its own over the pile."""
        return SearchRun(task, method, task.robot())

    def run(self, watch: Callable[[SearchStep], object] | None = None) -> SearchResult:
        """Search to the end; `watch` is called with each action once it is over."""
        return self.search.run(watch)


def tagged_items_of(scene: PileScene, placement: str, count: int, seed: int, *, only_soft: bool = False) -> TaggedItems:
    """Deal tags, as many as there are items for: up to `count`. The same seed deals the same to every method.

    With `only_soft` nothing rigid gets one.

    Raises:
        InputError: If the number or the seed is no whole number from 0 on.
    """
    check_count(seed, "seed")
    check_count(count, "count")
    most = sum(
        item.taggable and item.number != scene.target and (item.deformable or not only_soft) for item in scene.items
    )
    rng = np.random.default_rng([seed, 7])
    if count == 0 and placement == "any":
        placement = "none"
    return tag_items(scene, placement, min(count, most), rng, only_soft=only_soft)
