"""Tags on a body: where they are mounted, and where they are now."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field

import numpy as np

from rfcompass.arrays import FloatArray, read_only
from rfcompass.errors import DuplicateEpc, InputError, ShapeError
from rfcompass.types.record import Record, frozen_mapping

ROLES = frozenset({"hand_left", "hand_right", "hand", "base_front", "base_side", "base_end", "part_end", "part"})


def check_distinct(epcs: Iterable[str], where: str) -> tuple[str, ...]:
    """Return the EPCs as a tuple.

    Raises:
        DuplicateEpc: If one of them stands twice.
    """
    seen: set[str] = set()
    for epc in (listed := tuple(epcs)):
        if epc in seen:
            raise DuplicateEpc(f"{where}: EPC {epc} stands twice", epc=epc)
        seen.add(epc)
    return listed


@dataclass(frozen=True, slots=True)
class TagLayout(Record):
    """How tags are mounted on a robot or a part. Says nothing about where the body is.

    Attributes:
        body: `"robot"` or a part id.
        epcs: EPC of each tag (N).
        frames: URDF link of each tag, or `"part"` (N).
        points_m: Tag centres in those frames [m], shape (N, 3).
        dipoles: Direction of each tag's electrical axis in those frames, unit vectors, shape (N, 3).
        roles: One of `ROLES` for each tag (N); the reach and stop rules of [Wang2013] read them.
        counterparts: For K tags on a part, the index of the part tag that each hand tag should end next to:
            `{K: {"hand_left": index, "hand_right": index}}` [Wang2013], section 3.2.
    """

    body: str
    epcs: tuple[str, ...]
    frames: tuple[str, ...]
    points_m: FloatArray
    dipoles: FloatArray
    roles: tuple[str, ...]
    counterparts: Mapping[int, Mapping[str, int]] = field(default_factory=dict)

    def __post_init__(self) -> None:
        """Freeze, normalise the dipoles and check sizes, roles and EPCs."""
        N, name, set_ = len(self.epcs), f"TagLayout[{self.body}]", object.__setattr__
        set_(self, "epcs", check_distinct(self.epcs, name))
        set_(self, "frames", tuple(self.frames))
        set_(self, "roles", tuple(self.roles))
        if not len(self.frames) == len(self.roles) == N:
            raise ShapeError(f"{name}: {N} EPCs, {len(self.frames)} frames, {len(self.roles)} roles", name=name)
        if unknown := sorted(set(self.roles) - ROLES):
            raise InputError(f"{name}: unknown roles {unknown}; known: {sorted(ROLES)}", roles=unknown)
        set_(self, "points_m", read_only(self.points_m, f"{name}.points_m", (N, 3)))
        set_(self, "dipoles", read_only(_unit(self.dipoles, f"{name}.dipoles"), f"{name}.dipoles", (N, 3)))
        frozen = {int(K): frozen_mapping(pairs) for K, pairs in self.counterparts.items()}
        set_(self, "counterparts", frozen_mapping(frozen))

    def with_role(self, role: str) -> tuple[int, ...]:
        """Indices of the tags that play `role`."""
        return tuple(i for i, own in enumerate(self.roles) if own == role)


def _unit(directions: FloatArray, name: str) -> FloatArray:
    vectors = read_only(directions, name, (None, 3))
    lengths = np.linalg.norm(vectors, axis=1, keepdims=True)
    if (lengths == 0).any():
        raise ShapeError(f"{name}: a direction has length zero", name=name)
    # A vector of unit length stays as it is to the last bit, so that a layout survives copying unchanged.
    return np.asarray(np.where(np.abs(lengths - 1.0) < 1e-12, vectors, vectors / lengths))


@dataclass(frozen=True, slots=True)
class TagPositions(Record):
    """Where tags are in one frame. Holding one means that forward kinematics has been run.

    Attributes:
        frame: Frame of the points, for example `"base"`.
        epcs: EPC of each tag (N).
        points_m: Tag centres in `frame` [m], shape (N, 3).
    """

    frame: str
    epcs: tuple[str, ...]
    points_m: FloatArray

    def __post_init__(self) -> None:
        """Freeze the points and check that no EPC stands twice."""
        object.__setattr__(self, "epcs", check_distinct(self.epcs, "TagPositions"))
        points_m = read_only(self.points_m, "TagPositions.points_m", (len(self.epcs), 3))
        object.__setattr__(self, "points_m", points_m)

    def point_m(self, epc: str) -> FloatArray:
        """Position of one tag in `frame` [m], shape (3,).

        Raises:
            InputError: If the tag is not among them; lists those that are.
        """
        if epc not in self.epcs:
            raise InputError(f"no tag {epc} here (tags: {', '.join(self.epcs)})", epc=epc, epcs=list(self.epcs))
        return np.asarray(self.points_m[self.epcs.index(epc)])
