"""Parts: what is known about a thing before anybody looks for it. Tags, size and weight, but never a place.

One record serves both papers: [Wang2013] reads the tags and their places on the part (section 3.2) and the width
to grasp; [Boroushaki2023] reads the shortest and longest dimension and whether the item yields (sections 4.3, 4.5).
"""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from rfcompass.arrays import FloatArray, read_only
from rfcompass.errors import PartError
from rfcompass.types.epc import canonical_epc
from rfcompass.types.record import Record, frozen_mapping
from rfcompass.types.shapes import Shape, positive, rigid_transform
from rfcompass.types.tags import TagLayout, check_distinct

PART_FRAME = "part"
HAND_ROLES = ("hand_left", "hand_right")

_NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9_.-]{0,63}")


def check_name(name: str, what: str) -> str:
    """Return the name of a part or an assembly.

    Raises:
        PartError: If it is not 1 to 64 letters, digits, dots, dashes and underscores, a letter or digit first.
    """
    if not isinstance(name, str) or not _NAME.fullmatch(name):
        message = f"{what} {name!r}: a name is 1 to 64 letters, digits, '_', '-' or '.', a letter or digit first"
        raise PartError(message, name=name)
    return name


@dataclass(frozen=True, slots=True)
class StablePose(Record):
    """One way to lie still on a level support.

    Attributes:
        T_support_part: Part frame over the support plane z = 0, homogeneous, shape (4, 4).
        probability: How often a part that is dropped at random comes to lie like this, between 0 and 1.
    """

    T_support_part: FloatArray
    probability: float

    def __post_init__(self) -> None:
        """Freeze the pose and check the probability."""
        T = rigid_transform(self.T_support_part, "StablePose.T_support_part")
        object.__setattr__(self, "T_support_part", T)
        if not positive(self.probability, "StablePose.probability") <= 1 + 1e-9:
            raise PartError(f"StablePose.probability: {self.probability} is above 1", name="probability")

    @property
    def height_m(self) -> float:
        """Height of the part's centre above the support [m]."""
        return float(self.T_support_part[2, 3])


@dataclass(frozen=True, slots=True)
class TagSelection(Record):
    """Which K of the tags on a part are in use.

    Attributes:
        epcs: The tags in use (K).
        spacing: Name of the placement: `"ends"` (tags at the ends, the default) or, for example, `"inset"`.
        counterparts: The tag that each hand tag should end next to, by EPC: `{"hand_left": epc, "hand_right": epc}`.
    """

    epcs: tuple[str, ...]
    spacing: str = "ends"
    counterparts: Mapping[str, str] = field(default_factory=dict)

    def __post_init__(self) -> None:
        """Bring EPCs into their one spelling; counterparts are among the tags."""
        epcs = check_distinct(map(canonical_epc, self.epcs), "TagSelection")
        counterparts = {role: canonical_epc(epc) for role, epc in self.counterparts.items()}
        if not epcs:
            raise PartError("TagSelection.epcs: at least one tag is needed", name="epcs")
        for role, epc in counterparts.items():
            if role not in HAND_ROLES or epc not in epcs:
                message = f"TagSelection.counterparts: {role}: {epc} must be a hand tag ({', '.join(HAND_ROLES)})"
                raise PartError(f"{message} and one of {', '.join(epcs)}", name="counterparts", epc=epc)
        check_name(self.spacing, "TagSelection.spacing")
        object.__setattr__(self, "epcs", epcs)
        object.__setattr__(self, "counterparts", frozen_mapping(counterparts))

    @property
    def K(self) -> int:
        """Number of tags."""
        return len(self.epcs)


def no_tags(part_id: str) -> TagLayout:
    """Return the layout of a part without tags."""
    return TagLayout(part_id, (), (), np.zeros((0, 3)), np.zeros((0, 3)), ())


@dataclass(frozen=True, slots=True)
class Part(Record):
    """A part: shape, weight, tags. The part frame is described in `rfcompass.types.shapes`.

    Attributes:
        part_id: Its name, for example `"table_leg_3"`.
        shape: A primitive or a mesh in the part frame.
        mass_kg: Mass [kg].
        inertia_kg_m2: Inertia about the centre of mass, in the part frame [kg m²], shape (3, 3).
        grasp_width_m: What the jaws close on [m].
        tags: Every tag on the part, in the part frame (N ≥ 0). Each EPC is one tag in one place.
        selections: Which of the tags are in use for each K and spacing.
        material: In words.
        rigid: False for an item that yields under load; its kernel is then the deformable one [Boroushaki2023].
        stable_poses: Ways to lie still, likeliest first; empty where they were not computed.
    """

    part_id: str
    shape: Shape
    mass_kg: float
    inertia_kg_m2: FloatArray
    grasp_width_m: float
    tags: TagLayout
    selections: tuple[TagSelection, ...] = ()
    material: str = "not stated"
    rigid: bool = True
    stable_poses: tuple[StablePose, ...] = ()

    def __post_init__(self) -> None:
        """Freeze and check everything."""
        set_ = object.__setattr__
        check_name(self.part_id, "part")
        set_(self, "mass_kg", positive(self.mass_kg, f"{self.part_id}.mass_kg"))
        set_(self, "inertia_kg_m2", _inertia(self.inertia_kg_m2, f"{self.part_id}.inertia_kg_m2"))
        set_(self, "grasp_width_m", positive(self.grasp_width_m, f"{self.part_id}.grasp_width_m"))
        set_(self, "tags", _part_tags(self.tags, self.part_id))
        set_(self, "selections", tuple(self.selections))
        set_(self, "stable_poses", tuple(self.stable_poses))
        if not isinstance(self.material, str) or not self.material:
            raise PartError(f"{self.part_id}.material: {self.material!r} is no text", part=self.part_id)
        if not isinstance(self.rigid, bool):
            raise PartError(f"{self.part_id}.rigid: {self.rigid!r} is neither True nor False", part=self.part_id)
        self._check_selections()

    def _check_selections(self) -> None:
        seen: set[tuple[int, str]] = set()
        for selection in self.selections:
            key = (selection.K, selection.spacing)
            if key in seen:
                message = f"{self.part_id}: K = {key[0]} with spacing {key[1]!r} is given twice"
                raise PartError(message, part=self.part_id, K=key[0], spacing=key[1])
            seen.add(key)
            self.tagged(selection.epcs)

    @property
    def size_m(self) -> FloatArray:
        """Edges of the bounding box in the part frame [m], shape (3,)."""
        return np.asarray(self.shape.upper_m - self.shape.lower_m)

    @property
    def shortest_m(self) -> float:
        """Shortest dimension [m], d_s of [Boroushaki2023]."""
        return float(self.size_m.min())

    @property
    def longest_m(self) -> float:
        """Longest dimension [m], d_l of [Boroushaki2023]."""
        return float(self.size_m.max())

    @property
    def resting_height_m(self) -> float:
        """Height of the centre over the floor as the part lies, z of the part frame up [m].

        A tag at z in the part frame is then `resting_height_m + z` over the floor.
        """
        return float(-self.shape.lower_m[2])

    def layout(self, K: int, spacing: str = "ends") -> TagLayout:
        """Return the layout with K tags in use.

        Raises:
            PartError: If the part has no such layout; lists those it has.
        """
        for selection in self.selections:
            if (selection.K, selection.spacing) == (K, spacing):
                return self.tagged(selection.epcs, selection.counterparts)
        offered = ", ".join(f"{selection.K} {selection.spacing}" for selection in self.selections) or "none"
        message = f"part {self.part_id} has no layout of {K} tags with spacing {spacing!r} (it has: {offered})"
        raise PartError(message, part=self.part_id, K=K, spacing=spacing)

    def tagged(self, epcs: Sequence[str], counterparts: Mapping[str, str] | None = None) -> TagLayout:
        """Return the layout of some of the part's tags, in the order given.

        Args:
            epcs: Tags in use (K).
            counterparts: EPC of the part tag that each hand tag should end next to.

        Raises:
            PartError: If a tag is not on this part.
        """
        wanted = tuple(map(canonical_epc, epcs))
        for epc in wanted:
            if epc not in self.tags.epcs:
                raise PartError(f"part {self.part_id} has no tag {epc}", part=self.part_id, epc=epc)
        rows = [self.tags.epcs.index(epc) for epc in wanted]
        indices = {role: wanted.index(canonical_epc(epc)) for role, epc in (counterparts or {}).items()}
        return TagLayout(
            self.part_id, wanted, (PART_FRAME,) * len(rows), self.tags.points_m[rows], self.tags.dipoles[rows],
            tuple(self.tags.roles[row] for row in rows), {len(rows): indices} if indices else {},
        )  # fmt: skip


def _inertia(value: FloatArray, name: str) -> FloatArray:
    inertia = read_only(value, name, (3, 3))
    if np.abs(inertia - inertia.T).max() > 1e-9 * np.trace(inertia):
        raise PartError(f"{name}: is not symmetric", name=name)
    moments = np.linalg.eigvalsh(inertia)
    if moments[0] <= 0 or moments[2] > (moments[0] + moments[1]) * (1 + 1e-6):
        shown = ", ".join(f"{moment:.3g}" for moment in moments)
        raise PartError(f"{name}: no body has the principal moments {shown} kg m²", name=name)
    return inertia


def _part_tags(tags: TagLayout, part_id: str) -> TagLayout:
    if tags.body != part_id or set(tags.frames) - {PART_FRAME}:
        message = f"{part_id}.tags: body is {tags.body!r}, frames are {sorted(set(tags.frames))}"
        raise PartError(f"{message}; expected {part_id!r} and {PART_FRAME!r}", part=part_id)
    epcs = check_distinct(map(canonical_epc, tags.epcs), f"{part_id}.tags")
    if tags.counterparts:
        raise PartError(f"{part_id}.tags: counterparts belong to a selection", part=part_id)
    if epcs == tags.epcs:
        return tags
    return TagLayout(part_id, epcs, tags.frames, tags.points_m, tags.dipoles, tags.roles)


@dataclass(frozen=True, slots=True)
class Assembly(Record):
    """A product and the parts it is made of, so that a task can ask for all legs of a table.

    Attributes:
        name: Name of the product, for example `"LACK"`.
        part_ids: Its parts, in the order they are fetched.
    """

    name: str
    part_ids: tuple[str, ...]

    def __post_init__(self) -> None:
        """Check the names; a part is one thing and stands once."""
        check_name(self.name, "assembly")
        part_ids = tuple(check_name(part_id, f"part of {self.name}") for part_id in self.part_ids)
        object.__setattr__(self, "part_ids", part_ids)
        if not part_ids or len(set(part_ids)) < len(part_ids):
            raise PartError(f"assembly {self.name}: needs at least one part, each once", name=self.name)
