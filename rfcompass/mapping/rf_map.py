"""The RF certainty map R: where tagged items lie, so that the target does not [Boroushaki2023], section 4.3."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from rfcompass.arrays import FloatArray
from rfcompass.errors import InputError, NotLocated, ShapeError, UnknownPart
from rfcompass.mapping.rf_kernels import TagKernel, add_kernel, deformable_kernel, rigid_kernel
from rfcompass.types.epc import canonical_epc
from rfcompass.types.fixes import TagFix
from rfcompass.types.located_items import LocatedItem
from rfcompass.types.parts import Part
from rfcompass.types.piles import VoxelGrid
from rfcompass.types.record import Record, frozen_mapping
from rfcompass.types.tags import check_distinct
from rfcompass.types.workspace import Workspace

LEAST_ALPHA = 0.2  # ours: α = 0 would be an item without height
NOT_CONFIDENT, OUT_OF_REACH = "not located confidently", "its kernel does not reach into the workspace"


@dataclass(frozen=True, slots=True)
class RfMap(Record):
    """The map R, and which tags are in it.

    Attributes:
        grid: Sum of the kernels, zero or negative (positive only in the readings `printed_*`).
        alphas: Deformation factor α of each tag that counts, by EPC; 1 for rigid items.
        left_out: Why a tag does not count, by EPC.
    """

    grid: VoxelGrid
    alphas: Mapping[str, float]
    left_out: Mapping[str, str]

    def __post_init__(self) -> None:
        """Freeze the mappings."""
        object.__setattr__(self, "alphas", frozen_mapping(self.alphas))
        object.__setattr__(self, "left_out", frozen_mapping(self.left_out))


@dataclass(frozen=True, kw_only=True)
class RfKernels:
    """How tags become kernels.

    Attributes:
        reading: See `rfcompass.mapping.readings`.
        amplitude: Peak of each kernel in the reading `consistent`, in (0, 1].
        least_alpha: Lower bound of α, in (0, 1].
    """

    reading: str = "consistent"
    amplitude: float = 1.0
    least_alpha: float = LEAST_ALPHA

    def kernel(self, item: LocatedItem, alpha: float) -> TagKernel:
        """Kernel of one item; α is only looked at if it is deformable."""
        d_s, d_l = item.shortest_m, item.longest_m
        if item.deformable:
            return deformable_kernel(d_s, d_l, alpha, reading=self.reading, amplitude=self.amplitude)
        return rigid_kernel(d_s, d_l, reading=self.reading, amplitude=self.amplitude)

    def alpha(self, item: LocatedItem, workspace: Workspace, heights_m: FloatArray | None) -> float:
        """Deformation factor: height of the tag by the height of the pile above it, both over the table.

        Where nothing lies above the tag, 1: nothing presses.

        Raises:
            InputError: If the item is deformable and nobody says how high the pile is.
            ShapeError: If there is not one height for each column.
        """
        if not item.deformable:
            return 1.0
        if heights_m is None:
            message = f"{item.item} is deformable: its kernel needs the heights of the pile"
            raise InputError(message, epc=item.epc, item=item.item)
        if heights_m.shape != workspace.shape[:2]:
            message = f"heights_m: {heights_m.shape} values for {workspace.shape[:2]} columns"
            raise ShapeError(message, name="heights_m", expected=workspace.shape[:2], got=heights_m.shape)
        x, y = np.clip(workspace.indices(item.point_m[None])[0, :2], 0, np.array(workspace.shape[:2]) - 1)
        if not (top_m := float(heights_m[x, y])) > 0:
            return 1.0
        return float(np.clip((item.point_m[2] - workspace.table_m) / top_m, self.least_alpha, 1.0))


def known_items(fixes: Iterable[TagFix], parts: Iterable[Part]) -> tuple[LocatedItem, ...]:
    """Look up what each tag hangs on. Of several tags on one item the one with the smallest box stands for it.

    Args:
        fixes: Located tags, in the world frame.
        parts: Items of the database that may be in the pile.

    Raises:
        UnknownPart: If a tag is on none of the parts.
    """
    owners = {epc: part for part in parts for epc in part.tags.epcs}
    best: dict[str, tuple[TagFix, Part]] = {}
    for fix in fixes:
        if (part := owners.get(canonical_epc(fix.epc))) is None:
            message = f"tag {fix.epc} is on none of {len({id(owner) for owner in owners.values()})} known items"
            raise UnknownPart(message, epc=fix.epc, near=[])
        rival = best.get(part.part_id)
        if rival is None or _worth(fix) > _worth(rival[0]):
            best[part.part_id] = fix, part
    return tuple(
        LocatedItem(fix, part.part_id, part.shortest_m, part.longest_m, not part.rigid) for fix, part in best.values()
    )


def rf_certainty_map(
    items: Sequence[LocatedItem],
    workspace: Workspace,
    *,
    heights_m: FloatArray | None = None,
    kernels: RfKernels | None = None,
) -> RfMap:
    """Sum the kernels of all tags that are located confidently: R(p) = Σ_{i=1..N} m(p, p_i).

    Deviations: the paper prints R = -Σ m with m already negative, and N + 1 terms; see `docs/mapping.md`.

    Args:
        items: Tagged items, each with the place of its tag.
        workspace: What is mapped.
        heights_m: Height of the pile over the table in each column [m], shape (X, Y), as `VisualMap.heights_m`
            gives it; only needed for deformable items.
        kernels: How tags become kernels.

    Raises:
        DuplicateEpc: If a tag stands twice.
        InputError: If a deformable item comes without heights, or a parameter is out of range.
    """
    kernels = kernels or RfKernels()
    check_distinct((item.epc for item in items), "rf_certainty_map")
    values, alphas, left_out = np.zeros(workspace.shape), {}, {}
    for item in items:
        if not item.fix.confident:
            left_out[item.epc] = NOT_CONFIDENT
            continue
        alpha = kernels.alpha(item, workspace, heights_m)
        kernel = kernels.kernel(item, alpha)
        if not _reaches(kernel, item.point_m, workspace):
            left_out[item.epc] = OUT_OF_REACH
            continue
        add_kernel(values, kernel, item.point_m, workspace)
        alphas[item.epc] = alpha
    return RfMap(workspace.grid(values), alphas, left_out)


def tagged_target_map(
    target: LocatedItem,
    workspace: Workspace,
    *,
    heights_m: FloatArray | None = None,
    kernels: RfKernels | None = None,
) -> VoxelGrid:
    """Map of a target that carries a tag itself: its kernel, positive; what cameras saw does not matter (4.5.1).

    Args:
        target: The target and its tag.
        workspace: What is mapped.
        heights_m: As for `rf_certainty_map`.
        kernels: How tags become kernels.

    Raises:
        NotLocated: If the tag is not located confidently, or outside the workspace.
        InputError: As for `rf_certainty_map`.
    """
    found = rf_certainty_map([target], workspace, heights_m=heights_m, kernels=kernels)
    if reason := found.left_out.get(target.epc):
        raise NotLocated(f"tag {target.epc} of the target: {reason}", epc=target.epc, point_m=target.point_m.tolist())
    return workspace.grid(np.abs(found.grid.values))


def _worth(fix: TagFix) -> tuple[bool, float]:
    return fix.confident, -float(np.prod(fix.box_m))


def _reaches(kernel: TagKernel, point_m: FloatArray, workspace: Workspace) -> bool:
    nearest_m = np.clip(point_m, workspace.lower_m, workspace.upper_m)
    return bool(np.linalg.norm(nearest_m - point_m) < kernel.reach_m)
