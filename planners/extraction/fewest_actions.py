r"""Our policy: the fewest actions that are still to be expected, under a map that is a probability.

With F_i(r) the probability that the target comes to light within r removals at the place of object i (`uncovering`,
`layers`), and c_i(k) what the k-th of them costs in actions, the places are searched in the order of

    max_r F_i(r) / Σ_{k=1}^{r} c_i(k)

which is the order of fewest expected actions where the target is at one place and the work at each is a chain
[Sidney1975]: of two neighbours in the order, the one with more probability for each action goes first. An action that
fails has to be made again: with P the probability of success,

    c_i(1) = (1 + travel + (1 - P_i) risk) / P_i        c_i(k) = A_i / (A P)

The risk is that of a search that ends after too many failures in a row: it is dear to fail when there were some
already. Under a wide object lie several, and one removal more clears only a part of its area A_i; A is a thing's.
"""

from dataclasses import dataclass, field

import numpy as np

from planners.extraction.layers import LayerRules, chance_in_sight
from planners.extraction.mask_policy import MaskPolicy, Scene
from planners.extraction.projection import MaskColumns, project_masks
from planners.extraction.uncovering import mass_by_depth
from rfcompass.arrays import FloatArray, read_only
from rfcompass.errors import InputError, ShapeError
from rfcompass.types import VoxelGrid
from rfcompass.types.counts import check_count
from rfcompass.types.record import Record


@dataclass(frozen=True, slots=True, kw_only=True)
class ActionCosts(Record):
    """What actions cost, and how often they succeed. All ours; to be chosen on tuning scenes.

    Attributes:
        success: Quality of a grasp and its probability of success, ascending, (quality, probability). By default the
            quality itself, which for `AntipodalQuality` is how often executed grasps held, but never below 5 %.
        usual: Probability of success of later removals.
        failures: So many failures in a row end a search [Boroushaki2023], section 7.3.
        lost: Actions that the end of a search costs.
        travel_per_m: Actions that a metre of way costs, from below the camera to the grasp.
        area_m2: A, area of a thing seen from above [m²].
    """

    success: tuple[tuple[float, float], ...] = ((0.05, 0.05), (1.0, 1.0))
    usual: float = 0.7
    failures: int = 5
    lost: float = 10.0
    travel_per_m: float = 0.02
    area_m2: float = 0.006

    def __post_init__(self) -> None:
        """Check the ranges; a probability of 0 would cost infinitely much."""
        check_count(self.failures, "ActionCosts.failures", 1)
        object.__setattr__(self, "success", tuple((float(q), float(p)) for q, p in self.success))
        qualities, chances = np.array(self.success).reshape(-1, 2).T
        rising = len(qualities) > 0 and np.isfinite(qualities).all() and (np.diff(qualities) > 0).all()
        if not (rising and (chances > 0).all() and (chances <= 1).all() and 0 < self.usual <= 1):
            raise InputError(f"{self}: no curve of probabilities above 0", got=self.success)
        numbers = [self.lost, self.travel_per_m, self.area_m2]
        if not (np.isfinite(numbers).all() and self.lost >= 0 and self.travel_per_m >= 0 and self.area_m2 > 0):
            raise InputError(f"{self}: out of range", got=numbers)

    def chances(self, quality: FloatArray) -> FloatArray:
        """Probability of success at each quality, shape (K,)."""
        qualities, chances = np.array(self.success).T
        return np.interp(quality, qualities, chances)

    def risk(self, failures: int) -> float:
        """What one more failure costs beside itself, after so many in a row [actions]."""
        further = max(self.failures - failures - 1, 0)
        return self.lost * (1.0 - self.usual) ** further


@dataclass(frozen=True, slots=True, kw_only=True)
class FewestActionsPolicy(MaskPolicy):
    """Takes the object at the place where the most probability comes to light for each action.

    It wants a map that is a probability, such as `posterior_map`; of others it takes the share of the sum.

    Attributes:
        gate: Success is part of the cost; the paper's gate can be set before it.
        target_m: Edges of the target [m], shape (3,).
        removals: R, how many removals at a place are thought of; 1 is greedy.
        enough: Share of the target that has to be seen from above to know it.
        trust: The map is taken to this power, and to a sum of 1: below 1 because maps are too sure of
            themselves.
        layers: How things lie on each other.
        costs: What actions cost.
    """

    gate: bool = False
    target_m: FloatArray
    removals: int = 2
    enough: float = 0.25
    trust: float = 0.3
    layers: LayerRules = field(default_factory=LayerRules)
    costs: ActionCosts = field(default_factory=ActionCosts)

    def __post_init__(self) -> None:
        """Freeze the edges; check the ranges."""
        MaskPolicy.__post_init__(self)
        target_m = read_only(self.target_m, "FewestActionsPolicy.target_m", (3,))
        object.__setattr__(self, "target_m", target_m)
        if not (target_m > 0).all():
            raise ShapeError(f"FewestActionsPolicy.target_m: {target_m.tolist()} m are no lengths", name="target_m")
        check_count(self.removals, "FewestActionsPolicy.removals", 1)
        if not (0 < self.enough <= 1 and 0 < self.trust < np.inf):
            given = [self.enough, self.trust]
            raise InputError(f"FewestActionsPolicy: enough and trust {given} are out of range", got=given)

    def judged(self, scene: Scene) -> FloatArray:
        """Value of each candidate after the gate, shape (K,); its chance of success already knows what failed."""
        return self.gated(scene, self.values(scene))

    def values(self, scene: Scene) -> FloatArray:
        """Probability that comes to light for each action, at the best number of removals, shape (K,)."""
        columns = project_masks(scene.grid, scene.view, scene.masks, scene.points_m)
        worth = self._found(scene, columns) / np.cumsum(self._costs(scene, columns), axis=1)
        return np.asarray(worth.max(axis=1))

    def _found(self, scene: Scene, columns: MaskColumns) -> FloatArray:
        """F_i(r) for r = 1 ... R, shape (K, R)."""
        shortest_m, middle_m, longest_m = sorted(self.target_m.tolist())
        radius_m = float(np.sqrt(longest_m * middle_m / np.pi))
        labels = scene.candidates.labels
        grid = VoxelGrid(scene.grid.origin_m, scene.grid.spacing_m, np.maximum(scene.grid.values, 0.0) ** self.trust)
        mass = mass_by_depth(grid, columns, labels, shortest_m / 2, radius_m, self.enough)
        depths_m = grid.spacing_m * np.arange(mass.shape[1], dtype=np.float64)
        return np.asarray(mass @ chance_in_sight(depths_m, self.removals, self.layers).T)

    def _costs(self, scene: Scene, columns: MaskColumns) -> FloatArray:
        """c_i(r) for r = 1 ... R [actions], shape (K, R)."""
        candidates, costs = scene.candidates, self.costs
        chance = costs.chances(candidates.quality / candidates.tried) * candidates.tried
        off_m = scene.points_m[tuple(candidates.pixels.T)][:, :2] - scene.view.T_world_camera[:2, 3]
        travel = costs.travel_per_m * np.hypot(*off_m.T)
        first = (1.0 + travel + (1.0 - chance) * costs.risk(scene.failures)) / chance
        wide = np.array([(columns.owner == label).sum() for label in candidates.labels]) * scene.grid.spacing_m**2
        later = np.maximum(wide / costs.area_m2, 1.0) / costs.usual
        return np.column_stack([first, *[later] * (self.removals - 1)])
