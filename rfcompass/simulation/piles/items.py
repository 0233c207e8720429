"""Things that piles are made of.

Item frame: origin at the centre, z along the axis of a cylinder or capsule, and across a cover. A cover stands for
cloth: five stiff panels in a row along x, joined by hinges along y. It drapes over what lies below it in one direction
only, and neither stretches nor crumples: a surrogate, and said to be one wherever results are shown.

A cushion stands for soft, thick things: gloves, beanies, plush. It is two box halves, one on the other; the upper one
slides along z on a spring, into the lower one, when something lies on it. It gives way along that one line only, and a
surrogate as well.
"""

from dataclasses import dataclass

import numpy as np

from rfcompass.arrays import FloatArray, read_only
from rfcompass.errors import PileError
from rfcompass.simulation.piles.materials import DENSITY_KG_M3, PILE_MATERIALS, UNTAGGED
from rfcompass.types.items import ItemSize
from rfcompass.types.record import Record
from rfcompass.types.shapes import Box, Cylinder

KINDS = ("box", "cylinder", "capsule", "ellipsoid", "cover", "cushion")
PANELS = 5
# Panels of each kind that has more than one: in a row along x, and on top of each other along z.
_PANELS_ALONG = {"cover": np.array([PANELS, 1.0, 1.0]), "cushion": np.array([1.0, 1.0, 2.0])}
_JOINTS = {"cover": PANELS - 1, "cushion": 1}


@dataclass(frozen=True, slots=True)
class PileItem(Record):
    """One thing in a pile.

    Attributes:
        number: Identity within a pile, at least 1; the label of its pixels in true masks.
        kind: One of `KINDS`.
        size_m: Edges of its bounding box along x, y and z when it is flat [m], shape (3,).
        material: Name in `PILE_MATERIALS`.
        rgb: Its colour, red, green, blue in 0..255, three integers.
    """

    number: int
    kind: str
    size_m: FloatArray
    material: str
    rgb: tuple[int, int, int]

    def __post_init__(self) -> None:
        """Freeze; check that such a thing can be."""
        size_m = read_only(self.size_m, "PileItem.size_m", (3,))
        object.__setattr__(self, "size_m", size_m)
        object.__setattr__(self, "rgb", tuple(int(value) for value in self.rgb))
        for fine, key, what in (
            (self.number >= 1, "number", "is not at least 1"),
            (self.kind in KINDS, "kind", f"is none of {', '.join(KINDS)}"),
            ((size_m > 0).all(), "size_m", "holds a length that is not above 0"),
            (self.material in PILE_MATERIALS, "material", f"is none of {', '.join(PILE_MATERIALS)}"),
            (len(self.rgb) == 3 and all(0 <= v <= 255 for v in self.rgb), "rgb", "is not three numbers in 0..255"),
        ):
            if not fine:
                got = getattr(self, key)
                raise PileError(f"item {self.number}: {key} {got!r} {what}", key=key, got=got, number=self.number)
        self._check_round()

    def _check_round(self) -> None:
        x, y, z = self.size_m
        if self.kind in ("cylinder", "capsule") and x != y:
            message = f"item {self.number}: a {self.kind} of {x} by {y} m is not round"
            raise PileError(message, key="size_m", got=self.size_m, number=self.number)
        if self.kind == "capsule" and z <= x:
            message = f"item {self.number}: a capsule {z} m long and {x} m wide has no straight part"
            raise PileError(message, key="size_m", got=self.size_m, number=self.number)

    @property
    def name(self) -> str:
        """Kind and number."""
        return f"{self.kind}_{self.number:02d}"

    @property
    def deformable(self) -> bool:
        """Whether it gives way."""
        return self.kind in ("cover", "cushion")

    @property
    def taggable(self) -> bool:
        """Whether a tag on it answers."""
        return self.material not in UNTAGGED

    @property
    def volume_m3(self) -> float:
        """Volume [m³]."""
        x, y, z = self.size_m
        if self.kind == "cylinder":
            return float(np.pi / 4 * x * y * z)
        if self.kind == "capsule":
            return float(np.pi / 4 * x * x * (z - x) + np.pi / 6 * x**3)
        return float(np.prod(self.size_m) * (np.pi / 6 if self.kind == "ellipsoid" else 1.0))

    @property
    def mass_kg(self) -> float:
        """Mass [kg]."""
        return self.volume_m3 * DENSITY_KG_M3[self.material]

    @property
    def joints(self) -> int:
        """Number of a cover's hinges; 1 for the slide of a cushion."""
        return _JOINTS.get(self.kind, 0)

    @property
    def panel_size_m(self) -> FloatArray:
        """Edges of a panel of a cover, of a half of a cushion; of the whole item if it is neither [m], shape (3,)."""
        if self.kind not in _PANELS_ALONG:
            return self.size_m
        return self.size_m * (1 / _PANELS_ALONG[self.kind])

    @property
    def radius_m(self) -> float:
        """Radius of a ball about the item's centre that holds it, however it lies [m]."""
        return float(np.linalg.norm(self.size_m) / 2)

    def sized(self, name: str, epc: str | None = None) -> ItemSize:
        """What a database says about it, under a name that tells nothing of its number, the label in true masks."""
        return ItemSize(name, self.size_m, self.deformable, epc)

    @property
    def radio_shape(self) -> Box | Cylinder:
        """The solid that stands for it, or for one panel or half of it, in the radio channel.

        A capsule or an ellipsoid becomes the cylinder or box of the same volume and proportions.
        """
        size_m = self.panel_size_m
        if self.kind in ("cylinder", "capsule"):
            of_box = np.pi / 4 * float(np.prod(size_m))
            shrink = (self.volume_m3 / of_box) ** (1 / 3)
            return Cylinder(float(shrink * size_m[0] / 2), float(shrink * size_m[2]), axis="z")
        return Box(size_m * ((np.pi / 6) ** (1 / 3) if self.kind == "ellipsoid" else 1.0))

    def tag_places(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Where a tag can be glued: middles of the sides of a box, of its lengthwise lines on anything round.

        Returns:
            Points and outward normals in the item frame (of a cover, that of its middle panel; of a cushion, that of
            its lower half, whose large side has the tag), and the direction that the dipole then lies along, the longer
            edge of that side; shape (P, 3) each [m].
        """
        half = self.size_m / 2
        if self.kind == "cover":
            half = np.array([half[0] / PANELS, half[1], half[2]])
        if self.kind == "cushion":
            half = half * np.array([1.0, 1.0, 0.5])
        faces = _FACES[self.kind]
        normals = np.array([np.sign(face) * np.eye(3)[abs(face) - 1] for face in faces])
        along = [_longer_edge(half, abs(face) - 1, self.kind) for face in faces]
        return normals * half, normals, np.array(along)


# Sides that a tag can be on: axis 1, 2 or 3, with the sign of the outward normal. Ends of round things are too small.
_ALL_SIDES = (1, -1, 2, -2, 3, -3)
_ROUND = (1, -1, 2, -2)
_FACES = {
    "box": _ALL_SIDES,
    "ellipsoid": _ALL_SIDES,
    "cylinder": _ROUND,
    "capsule": _ROUND,
    "cover": (3, -3),
    "cushion": (-3,),
}


def _longer_edge(half_m: FloatArray, axis: int, kind: str) -> FloatArray:
    if kind in ("cylinder", "capsule"):
        return np.eye(3)[2]
    edges = np.where(np.arange(3) == axis, -np.inf, half_m)
    return np.eye(3)[int(np.argmax(edges))]
