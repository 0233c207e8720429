"""What a search believes about the place of its target, given all views so far and the tags that were located.

`PaperBelief` is [Boroushaki2023], section 4: C + R, convolved with the target's kernel. `PosteriorBelief` is ours, and
so is `XRayBelief`, the stronger variant of that baseline. `OwnTag` puts the target's own tag before another (4.5.1).
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Protocol, runtime_checkable

from rfcompass.errors import NotLocated
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
    xray_map,
)
from rfcompass.types import ItemSize, TagFix, VoxelGrid
from rfcompass.types.epc import canonical_epc
from rfcompass.types.record import Record

Fixes = Mapping[str, TagFix]


@runtime_checkable
class Belief(Protocol):
    """Says where the target may be."""

    def believe(self, seen: VisualMap, target: ItemSize, fixes: Fixes, sizes: Sequence[ItemSize]) -> VoxelGrid:
        """Map the place of the target's middle; larger is likelier.

        Args:
            seen: All views so far.
            target: Its edges.
            fixes: Where each tag is that is still on the table, by EPC; not confident where it was never located so, or
                has gone further than it is followed.
            sizes: What the database says about tagged items.

        Returns:
            The voxels of what is mapped, or one layer of them on the table; finite and not negative. Zeros everywhere
            say that no place is left.

        Raises:
            NothingHidden: If no voxel is unobserved, from those who do not answer with zeros.
        """
        ...


@dataclass(frozen=True, slots=True, kw_only=True)
class PaperBelief(Record):
    """The paper's map.

    Attributes:
        kernels: How tags become kernels.
        rigid: Take soft items for rigid ones: the spherical kernel of Table 4.
    """

    kernels: RfKernels = field(default_factory=RfKernels)
    rigid: bool = False

    def believe(self, seen: VisualMap, target: ItemSize, fixes: Fixes, sizes: Sequence[ItemSize]) -> VoxelGrid:
        """(C + R) * k."""
        table, known = seen.workspace, [_as_rigid(size) for size in sizes] if self.rigid else sizes
        items = located_items(_of_known(fixes, sizes), known)
        radio = rf_certainty_map(items, table, heights_m=seen.heights_m(), kernels=self.kernels)
        kernel = gaussian_target(target.shortest_m, target.longest_m, table.spacing_m)
        return occupancy_map(fuse_maps(seen.uncertainty(), radio.grid), kernel)


@dataclass(frozen=True, slots=True, kw_only=True)
class PosteriorBelief(Record):
    """Our posterior.

    Attributes:
        rules: Its numbers.
    """

    rules: PosteriorRules = field(default_factory=PosteriorRules)

    def believe(self, seen: VisualMap, target: ItemSize, fixes: Fixes, sizes: Sequence[ItemSize]) -> VoxelGrid:
        """P(the target's middle is here | views, tags)."""
        return posterior_map(seen, target, tagged_items(_of_known(fixes, sizes), sizes), rules=self.rules)


@dataclass(frozen=True, slots=True, kw_only=True)
class XRayBelief(Record):
    """X-Ray's distribution from above, over the heights of all views; ours, stronger than its single image."""

    def believe(self, seen: VisualMap, target: ItemSize, fixes: Fixes, sizes: Sequence[ItemSize]) -> VoxelGrid:  # noqa: ARG002
        """One layer of voxels; it knows no tags."""
        return xray_map(seen, target.size_m)


@dataclass(frozen=True, slots=True, kw_only=True)
class OwnTag(Record):
    """The kernel about the target's own tag; another belief while that tag is not located confidently.

    Attributes:
        epc: EPC of the target's tag.
        otherwise: What is believed without it.
        kernels: How the tag becomes a kernel.
    """

    epc: str
    otherwise: Belief = field(default_factory=PaperBelief)
    kernels: RfKernels = field(default_factory=RfKernels)

    def believe(self, seen: VisualMap, target: ItemSize, fixes: Fixes, sizes: Sequence[ItemSize]) -> VoxelGrid:
        """Its kernel, positive; what cameras saw does not matter."""
        own = canonical_epc(self.epc)
        others = {epc: fix for epc, fix in fixes.items() if epc != own}
        if own in fixes:
            named = ItemSize(target.name, target.size_m, target.deformable, own)
            item = located_items([fixes[own]], [named])[0]
            try:
                return tagged_target_map(item, seen.workspace, heights_m=seen.heights_m(), kernels=self.kernels)
            except NotLocated:
                pass
        return self.otherwise.believe(seen, target, others, sizes)


def _of_known(fixes: Fixes, sizes: Sequence[ItemSize]) -> list[TagFix]:
    """Fixes of tags that the database knows; strays say nothing about any item."""
    known = {canonical_epc(size.epc) for size in sizes if size.epc is not None}
    return [fix for epc, fix in fixes.items() if epc in known]


def _as_rigid(size: ItemSize) -> ItemSize:
    return ItemSize(size.name, size.size_m, False, size.epc)
