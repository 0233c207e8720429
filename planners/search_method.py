"""Ways of searching a pile: what is believed, where to look, what to take, what to look at again.

A method is the sum of its parts, so that of two methods it can be said in which part they differ. `FUSEBOT` is the
paper's [Boroushaki2023]; whoever compares policies gives them the same views, updates and memory.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from rfcompass.errors import InputError, NotLocated
from rfcompass.interfaces import ExtractionPolicy
from rfcompass.mapping import (
    PosteriorRules,
    RfKernels,
    VisualMap,
    fuse_maps,
    gaussian_target,
    located_items,
    occupancy_map,
    posterior_map,
    rf_certainty_map,
    tagged_items,
    tagged_target_map,
)
from rfcompass.mapping.visual_map import LOCAL_EDGE_M
from rfcompass.types import ItemSize, TagFix, VoxelGrid
from rfcompass.types.epc import canonical_epc
from rfcompass.types.record import Record

BELIEFS = ("paper", "posterior", "none")
LOOKS = ("cluster", "overhead")
# Ours: height of the camera over the table where masks and grasps are computed, and after each grasp; and from where
# one image shows all piles [m].
NEAR_M, OVERHEAD_M = 0.60, 0.85
# Ours: edge of the part of the map that is looked at again where a method uses all that the view shows [m].
WHOLE_VIEW_M = 0.60


@dataclass(frozen=True, slots=True, kw_only=True)
class SearchMethod(Record):
    """One way of searching.

    Attributes:
        name: What tables call it.
        policy: What to take next.
        belief: `paper`: C + R convolved with the target's kernel. `posterior`: ours. `none`: no map, for policies
            that need none; where to look is then decided by what is hidden at all.
        looks: `cluster`: from near above the likeliest part of the map, as the paper does. `overhead`: from where
            one image shows all.
        update_edge_m: Edge of the cube about a grasp that is looked at again after it [m]; the paper's 10 cm, or all
            that the view shows.
        remembers: Whether the policy is told where grasps have failed.
        use_tags: Whether tags of other items count.
        kernels: How tags become kernels in the paper's map.
        rules: Numbers of the posterior.
        target_epc: EPC of the target's own tag; the map is then its kernel alone wherever it is located confidently.
        rigid: Take soft items for rigid ones, as the spherical kernel of Table 4 does.
    """

    name: str
    policy: ExtractionPolicy
    belief: str = "paper"
    looks: str = "cluster"
    update_edge_m: float = LOCAL_EDGE_M
    remembers: bool = False
    use_tags: bool = True
    kernels: RfKernels | None = None
    rules: PosteriorRules | None = None
    target_epc: str | None = None
    rigid: bool = False

    def __post_init__(self) -> None:
        """Check the names and the edge."""
        for key, known in (("belief", BELIEFS), ("looks", LOOKS)):
            if (got := getattr(self, key)) not in known:
                message = f"SearchMethod.{key}: {got!r} is none of {', '.join(known)}"
                raise InputError(message, got=got, known=list(known))
        if not self.update_edge_m > 0:
            raise InputError(f"SearchMethod.update_edge_m: {self.update_edge_m} is not above 0", got=self.update_edge_m)

    @property
    def look_height_m(self) -> float:
        """Height of the camera where the next grasp is chosen [m]."""
        return OVERHEAD_M if self.looks == "overhead" else NEAR_M

    def believe(
        self, seen: VisualMap, target: ItemSize, fixes: Mapping[str, TagFix], sizes: Sequence[ItemSize]
    ) -> VoxelGrid:
        """Say where the target may be.

        Args:
            seen: All views so far.
            target: Its edges.
            fixes: The last fix of each tag still on the table, by EPC.
            sizes: What the database says about all tagged items.

        Raises:
            NothingHidden: If no voxel is unobserved.
        """
        own = None if self.target_epc is None else canonical_epc(self.target_epc)
        if own is not None and own in fixes and (grid := self._of_own_tag(seen, target, fixes[own])) is not None:
            return grid
        known = {canonical_epc(size.epc): size for size in sizes if size.epc is not None}
        others = [fix for epc, fix in fixes.items() if self.use_tags and epc != own and epc in known]
        if self.belief == "posterior":
            return posterior_map(seen, target, tagged_items(others, sizes), rules=self.rules)
        if self.belief == "none":
            return seen.uncertainty()
        table = seen.workspace
        items = located_items(others, [_rigid(size) for size in sizes] if self.rigid else sizes)
        radio = rf_certainty_map(items, table, heights_m=seen.heights_m(), kernels=self.kernels)
        kernel = gaussian_target(target.shortest_m, target.longest_m, table.spacing_m)
        return occupancy_map(fuse_maps(seen.uncertainty(), radio.grid), kernel)

    def _of_own_tag(self, seen: VisualMap, target: ItemSize, fix: TagFix) -> VoxelGrid | None:
        """The kernel about the target's own tag; None while that is not located confidently."""
        named = ItemSize(target.name, target.size_m, target.deformable, fix.epc)
        item = located_items([fix], [named])[0]
        try:
            return tagged_target_map(item, seen.workspace, heights_m=seen.heights_m(), kernels=self.kernels)
        except NotLocated:
            return None


def _rigid(size: ItemSize) -> ItemSize:
    return ItemSize(size.name, size.size_m, False, size.epc)
