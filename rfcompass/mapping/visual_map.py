"""The visual uncertainty map C: which voxels no camera has looked into [Boroushaki2023], section 4.1."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy import ndimage

from rfcompass.arrays import BoolArray, FloatArray, read_only
from rfcompass.errors import InputError, ShapeError
from rfcompass.mapping.camera import NEAREST_M, check_view, half_extent_m, voxel_projection
from rfcompass.mapping.view_kernels import (
    FREE,
    OUTSIDE,
    SURFACE,
    UNOBSERVED,
    Float32Array,
    StateArray,
    add_log_odds,
    mark_view,
)
from rfcompass.types.piles import DepthView, VoxelGrid
from rfcompass.types.record import Record
from rfcompass.types.workspace import Workspace

LOCAL_EDGE_M = 0.10  # [Boroushaki2023], section 5
# Ours: the coarsest voxel in which a hidden item is not overlooked, of the item's shortest edge; see `check_spacing`.
COARSEST = 2 / 3


@dataclass(frozen=True, slots=True)
class LogOdds(Record):
    """How much each view counts where views contradict each other, as in OctoMap [Hornung2013]; their numbers.

    Log-odds decide whether a voxel that was looked into is free or a surface. What no view looked into they cannot
    know, so the map C is the same with and without them.

    Attributes:
        surface: Added where a view sees a surface.
        free: Added where a view sees through, negative.
        least: Lower bound.
        most: Upper bound.
    """

    surface: float = 0.85
    free: float = -0.4
    least: float = -2.0
    most: float = 3.5

    def __post_init__(self) -> None:
        """Check signs and order."""
        if not self.least <= self.free < 0 < self.surface <= self.most:
            raise InputError(f"{self}: signs or order are wrong", got=[self.surface, self.free, self.least, self.most])


@dataclass(frozen=True, slots=True)
class VisualMap(Record):
    """What cameras have seen of each voxel of a workspace.

    A voxel is `FREE` or `SURFACE` if any view says so, `UNOBSERVED` if it was inside the image of at least one view
    but behind what every one of them saw (or where they had no depth), `OUTSIDE` if no view reached it. Only
    `UNOBSERVED` voxels are uncertain: the paper's "unexplored" space counts as soon as a camera was turned to it.
    For C the order of the views does not matter.

    Attributes:
        workspace: What is mapped.
        state: One of `OUTSIDE`, `UNOBSERVED`, `FREE`, `SURFACE` for each voxel, shape (X, Y, Z).
        log_odds: Log-odds that a voxel is filled, shape (X, Y, Z); None where any view that sees a surface is believed.
        rule: How log-odds add up; None without them.
        nearest_m: A view of which half is nearer than this is refused [m].
    """

    workspace: Workspace
    state: StateArray
    log_odds: Float32Array | None = None
    rule: LogOdds | None = None
    nearest_m: float = NEAREST_M

    def __post_init__(self) -> None:
        """Freeze the arrays; log-odds and their rule come together."""
        shape = self.workspace.shape
        object.__setattr__(self, "state", read_only(self.state, "VisualMap.state", shape, np.uint8))
        if (self.log_odds is None) != (self.rule is None):
            raise ShapeError("VisualMap: log_odds and rule come together", name="log_odds")
        if self.log_odds is not None:
            log_odds = read_only(self.log_odds, "VisualMap.log_odds", shape, np.float32)
            object.__setattr__(self, "log_odds", log_odds)

    @classmethod
    def empty(cls, workspace: Workspace, rule: LogOdds | None = None, nearest_m: float = NEAREST_M) -> "VisualMap":
        """Start with nothing seen; `rule` asks for log-odds."""
        state = np.full(workspace.shape, OUTSIDE, dtype=np.uint8)
        log_odds = None if rule is None else np.zeros(workspace.shape, dtype=np.float32)
        return cls(workspace, state, log_odds, rule, nearest_m)

    @property
    def states(self) -> StateArray:
        """State of each voxel, with log-odds already judged, shape (X, Y, Z)."""
        if self.log_odds is None:
            return self.state
        judged = np.where(self.log_odds > 0, SURFACE, FREE)
        return np.where(self.state >= FREE, judged, self.state).astype(np.uint8)

    @property
    def covered(self) -> BoolArray:
        """True for each voxel inside the image of at least one view, shape (X, Y, Z)."""
        return np.asarray(self.state != OUTSIDE)

    @property
    def unobserved(self) -> BoolArray:
        """True for each voxel that a view reached and none looked into, shape (X, Y, Z)."""
        return np.asarray(self.state == UNOBSERVED)

    @property
    def unobserved_m3(self) -> float:
        """Volume where something can be hidden [m³]."""
        return float(self.unobserved.sum()) * self.workspace.spacing_m**3

    def room_m3(self, edge_m: float) -> float:
        """Volume that no view looked into, as far as a ball of some diameter has room there [m³].

        Slivers behind edges are no place for an item: whoever looks for one asks with its shortest edge, for a box, a
        cylinder or an ellipsoid holds such a ball. The ball may reach into surfaces, and is taken smaller by half a
        voxel's diagonal, since its middle need not be on the grid. Where this is 0, no such item is where views from
        straight above reached, but for noise and half a pixel; for slanted views, see `check_spacing`.

        Args:
            edge_m: Diameter of the ball [m].

        Raises:
            InputError: If the voxels are too coarse to tell.
        """
        check_spacing(self.workspace.spacing_m, edge_m)
        voxels = (edge_m / 2 / self.workspace.spacing_m) - np.sqrt(3) / 2
        reach = max(int(voxels), 0)
        steps = np.indices((2 * reach + 1,) * 3) - reach
        ball = (steps**2).sum(axis=0) <= max(voxels, 0.0) ** 2
        not_free = self.unobserved | (self.states == SURFACE)
        fits = ndimage.binary_opening(not_free, structure=ball)
        return float((fits & self.unobserved).sum()) * self.workspace.spacing_m**3

    def uncertainty(self) -> VoxelGrid:
        """The map C: 1 where nothing is known, 0 elsewhere."""
        return self.workspace.grid(self.unobserved.astype(np.float64))

    def heights_m(self) -> FloatArray:
        """Height of the pile over the table in each column, to one voxel [m], shape (X, Y).

        The upper side of the highest voxel that is a surface or unobserved, 0 where there is none.
        """
        filled = (self.states == SURFACE) | self.unobserved
        top = self.workspace.shape[2] - np.argmax(filled[:, :, ::-1], axis=2)
        return np.where(filled.any(axis=2), top, 0) * self.workspace.spacing_m

    def with_views(self, views: Iterable[DepthView]) -> "VisualMap":
        """Return the map with more views.

        Raises:
            InputError: If a camera stands below the table top.
            CameraBlocked: If a camera sees nothing, or only what stands right before it.
        """
        state, log_odds = self.state.copy(), None if self.log_odds is None else self.log_odds.copy()
        for view in views:
            self._add(view, state, log_odds)
        return replace(self, state=state, log_odds=log_odds)

    def refreshed(self, views: Sequence[DepthView], point_m: FloatArray, edge_m: float = LOCAL_EDGE_M) -> "VisualMap":
        """Look again at a cube, as after each grasp [Boroushaki2023], section 5, and change nothing outside it.

        What was known of the cube is forgotten where a new view reaches: what was free may be hidden now. Where none
        reaches, the old knowledge stays.

        Args:
            views: New views, taken after the grasp.
            point_m: Middle of the cube, in the world frame [m], shape (3,).
            edge_m: Edge of the cube [m].

        Raises:
            InputError: If no voxel has its centre in the cube, or a camera stands below the table top.
            CameraBlocked: If a camera sees nothing, or only what stands right before it.
        """
        if not self.meets_cube(point_m, edge_m):
            message = f"no voxel of the workspace lies in the cube of {edge_m} m about {list(point_m)} m"
            raise InputError(message, point_m=np.asarray(point_m).tolist(), edge_m=edge_m)
        cube = self._cube(point_m, edge_m)
        first = (cube[0].start, cube[1].start, cube[2].start)
        state, log_odds = self.state.copy(), None if self.log_odds is None else self.log_odds.copy()
        fresh = np.full(state[cube].shape, OUTSIDE, dtype=np.uint8)
        fresh_odds = None if log_odds is None else np.zeros(fresh.shape, dtype=np.float32)
        for view in views:
            self._add(view, fresh, fresh_odds, first)
        again = fresh != OUTSIDE
        state[cube][again] = fresh[again]
        if log_odds is not None and fresh_odds is not None:
            log_odds[cube][again] = fresh_odds[again]
        return replace(self, state=state, log_odds=log_odds)

    def _add(
        self,
        view: DepthView,
        state: StateArray,
        log_odds: Float32Array | None,
        first: tuple[int, int, int] = (0, 0, 0),
    ) -> None:
        """Add a view to a block of voxels that begins at a first one."""
        check_view(view, self.workspace, self.nearest_m)
        P, half_m = voxel_projection(view, self.workspace, first), half_extent_m(view, self.workspace.spacing_m)
        depth_m = view.depth_m.astype(np.float32)
        if log_odds is None or self.rule is None:
            mark_view(state, P, depth_m, half_m)
            return
        steps = np.array([self.rule.surface, self.rule.free, self.rule.least, self.rule.most])
        add_log_odds(state, log_odds, P, depth_m, half_m, steps)

    def meets_cube(self, point_m: FloatArray, edge_m: float) -> bool:
        """Tell whether any voxel has its centre in a cube.

        Args:
            point_m: Middle of the cube, in the world frame [m], shape (3,).
            edge_m: Edge of the cube [m].
        """
        return all(side.stop > side.start for side in self._cube(point_m, edge_m))

    def _cube(self, point_m: FloatArray, edge_m: float) -> tuple[slice, slice, slice]:
        """Voxels with their centres in a cube; none where they do not meet."""
        place, reach = (
            (np.asarray(point_m, dtype=np.float64) - self.workspace.origin_m) / self.workspace.spacing_m,
            edge_m / 2 / self.workspace.spacing_m,
        )
        low = np.clip(np.ceil(place - reach - 1e-9), 0, self.workspace.shape).astype(np.int64)
        high = np.clip(np.floor(place + reach + 1e-9) + 1, 0, self.workspace.shape).astype(np.int64)
        x, y, z = (slice(int(a), int(b)) for a, b in zip(low, high, strict=True))
        return x, y, z


def check_spacing(spacing_m: float, edge_m: float) -> None:
    """Check that voxels are fine enough to tell that an item is not there.

    Something can be hidden in a voxel only if its middle lies half a voxel or more under what is seen. In coarse voxels
    a hidden item may have no such voxel: all of it counts as the surface, and the map "proves" that nothing is there.
    Let d be the item's shortest edge, h that of a voxel, and the view from straight above. The middle of the nearest
    column of voxels is no further than h / √2 from that of a ball on the table, which is there

        d/2 + √(d²/4 - h²/2)

    high. That is at least h, so that the lowest voxel is h / 2 under it, exactly if h ≤ 2/3 d. Other items on the ball
    only add to that.

    Rays that are slanted by φ may miss what covers a voxel. Then the voxel nearest to the ball's middle is hidden for
    certain if (√3 + 1 / cos φ) h ≤ d: for an upright camera of 65 by 40 degrees, about h ≤ d / 3.

    Args:
        spacing_m: Edge of a voxel [m].
        edge_m: Shortest edge of the item [m].

    Raises:
        InputError: If the voxels are coarser than 2/3 of the edge.
    """
    if not spacing_m <= COARSEST * edge_m * (1 + 1e-9):
        message = (
            f"voxels of {spacing_m:g} m are too coarse to tell where an item of {edge_m:g} m is not; "
            f"at most {COARSEST * edge_m:.3g} m"
        )
        raise InputError(message, spacing_m=spacing_m, edge_m=edge_m, most_m=COARSEST * edge_m)


def map_views(workspace: Workspace, views: Iterable[DepthView], *, rule: LogOdds | None = None) -> VisualMap:
    """Map a workspace from the views of a scan; errors as for `VisualMap.with_views`."""
    return VisualMap.empty(workspace, rule).with_views(views)
