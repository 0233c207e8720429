"""Ways of searching a pile: what is believed, where to look, what to take, what to look at again.

A method is the sum of its parts, so that of two methods it can be said in which part they differ: whoever compares
policies gives them the same belief, views, updates and memory.
"""

from dataclasses import dataclass, field

from planners.extraction import ActionCosts
from planners.extraction.clusters import THRESHOLD
from planners.search_beliefs import Belief, PaperBelief
from rfcompass.errors import InputError
from rfcompass.interfaces import ExtractionPolicy
from rfcompass.mapping.visual_map import LOCAL_EDGE_M
from rfcompass.types.record import Record

CLUSTER, PEAK, OVERHEAD = "cluster", "peak", "overhead"
LOOKS = (CLUSTER, PEAK, OVERHEAD)
# Ours: height of the camera over the table above a part of the map, the chosen object, and each place that was
# grasped; and from where one image shows all piles [m].
NEAR_M, OVERHEAD_M = 0.60, 0.85
# Ours: edge of what is looked at again by a method that uses all that the view shows [m].
WHOLE_VIEW_M = 0.60


@dataclass(frozen=True, slots=True, kw_only=True)
class SearchMethod(Record):
    """One way of searching; by default with the views and updates of [Boroushaki2023].

    Attributes:
        name: What tables call it.
        policy: What to take next.
        belief: Where the target may be; None for a policy that needs no map. What nobody saw then stands for it.
        looks: `cluster`: from near above the likeliest part of the map. `peak`: from near above its highest voxel.
            `overhead`: from where one image shows all.
        update_edge_m: Edge of the cube about a grasp that is looked at again after it [m]; 10 cm in the paper.
        remembers: Whether failed grasps count where an object and its grasp are chosen; a policy's own `remembers`, if
            it has one, must be on as well. What failed on a target in sight since the last success counts either way.
        costs: What a failed grasp costs. With them, a grasp gives way to a surer one elsewhere where that costs less
            than the end of the search after too many failures in a row would; ours. None: never. For removals only
            where the method looks closer.
        cluster_threshold: Columns of the map belong to a cluster from this share of the largest column on, in [0, 1);
            ours, see `planners.extraction.clusters`.
        looks_closer: Look at the chosen object from near above before it is grasped; ours. From afar one sees what to
            take, from near how.
        scans: Go round with camera and antennas first. Without that the image of all comes first, for a policy that
            needs neither map nor tags.
    """

    name: str
    policy: ExtractionPolicy
    belief: Belief | None = field(default_factory=PaperBelief)
    looks: str = CLUSTER
    update_edge_m: float = LOCAL_EDGE_M
    remembers: bool = False
    looks_closer: bool = False
    costs: ActionCosts | None = None
    cluster_threshold: float = THRESHOLD
    scans: bool = True

    def __post_init__(self) -> None:
        """Check the views, the edge and the threshold."""
        if not self.scans and (self.belief is not None or self.looks != OVERHEAD):
            raise InputError("SearchMethod.scans: a map, and a look at part of it, need a scan", got=self.scans)
        if self.looks not in LOOKS:
            message = f"SearchMethod.looks: {self.looks!r} is none of {', '.join(LOOKS)}"
            raise InputError(message, got=self.looks, known=list(LOOKS))
        if not self.update_edge_m > 0:
            raise InputError(f"SearchMethod.update_edge_m: {self.update_edge_m} is not above 0", got=self.update_edge_m)
        if not 0 <= self.cluster_threshold < 1:
            message = f"SearchMethod.cluster_threshold: {self.cluster_threshold} is not in [0, 1)"
            raise InputError(message, got=self.cluster_threshold)
