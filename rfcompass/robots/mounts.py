"""Where tags may be mounted on a robot: flat patches of its surface, as a JSON file."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from rfcompass.arrays import FloatArray, read_only
from rfcompass.errors import InputError, RobotModelError
from rfcompass.robots.json_files import JsonFile
from rfcompass.robots.layouts import data_folder
from rfcompass.types.record import Record
from rfcompass.types.tags import ROLES, TagLayout

SCHEMA = "rfcompass-mounts/1"
SPACING_M = 0.09  # nearer tags detune each other


@dataclass(frozen=True, slots=True)
class MountPatch(Record):
    """A parallelogram on a link; one edge may be of length zero: then it is a strip.

    Attributes:
        name: What to call it.
        link: URDF link.
        corner_m: One corner in the link's frame [m], shape (3,).
        edges_m: The two edges from there [m], shape (2, 3).
        dipole: Electrical axis of a tag on it, shape (3,).
        role: Role of a tag on it, see `TagLayout`.
    """

    name: str
    link: str
    corner_m: FloatArray
    edges_m: FloatArray
    dipole: FloatArray
    role: str

    def __post_init__(self) -> None:
        """Freeze the arrays and check the role."""
        set_ = object.__setattr__
        set_(self, "corner_m", read_only(self.corner_m, f"patch {self.name}: corner_m", (3,)))
        set_(self, "edges_m", read_only(self.edges_m, f"patch {self.name}: edges_m", (2, 3)))
        set_(self, "dipole", read_only(self.dipole, f"patch {self.name}: dipole", (3,)))
        if self.role not in ROLES:
            raise InputError(f"patch {self.name}: role {self.role!r} is none of {sorted(ROLES)}", role=self.role)

    def places_m(self, pitch_m: float) -> FloatArray:
        """Places on the patch, edges included, at most this far apart along each edge [m], shape (C, 3)."""
        counts = np.ceil(np.linalg.norm(self.edges_m, axis=1) / pitch_m - 1e-9).astype(int)
        u, v = (np.linspace(0.0, 1.0, count + 1) if count else np.zeros(1) for count in counts)
        U, V = np.meshgrid(u, v, indexing="ij")
        return self.corner_m + U.reshape(-1, 1) * self.edges_m[0] + V.reshape(-1, 1) * self.edges_m[1]


@dataclass(frozen=True, slots=True)
class Mounts(Record):
    """All patches of a robot.

    Attributes:
        patches: Where tags may be.
        spacing_m: Least distance between two tags [m].
    """

    patches: tuple[MountPatch, ...]
    spacing_m: float = SPACING_M

    def __post_init__(self) -> None:
        """Refuse a robot without a place, and a spacing that cannot be."""
        if not self.patches:
            raise InputError("no patch to mount tags on", patches=0)
        if not (np.isfinite(self.spacing_m) and self.spacing_m >= 0.0):
            raise InputError(f"spacing of {self.spacing_m} m", spacing_m=self.spacing_m)

    def candidates(self, pitch_m: float) -> TagLayout:
        """A tag on every place of every patch: not to be built, but to choose from.

        Args:
            pitch_m: Distance between places [m].
        """
        if pitch_m <= 0.0:
            raise InputError(f"a pitch of {pitch_m} m", pitch_m=pitch_m)
        places = [patch.places_m(pitch_m) for patch in self.patches]
        of = [patch for patch, found in zip(self.patches, places, strict=True) for _ in found]
        return TagLayout(
            "robot", epcs_of(len(of)), tuple(patch.link for patch in of), np.vstack(places),
            np.array([patch.dipole for patch in of]), tuple(patch.role for patch in of),
        )  # fmt: skip


def epcs_of(count: int) -> tuple[str, ...]:
    """EPCs of the tags of a new layout; ours to give."""
    return tuple(f"5246434f4d50415353{0x020001 + i:06x}" for i in range(count))


def load_mounts(robot: str | Path) -> Mounts:
    """Read where tags may be mounted.

    Args:
        robot: Name of a robot that we ship mounts for, or the path of a JSON file.

    Raises:
        RobotModelError: If there is no such file, or it breaks the format; names the key.
    """
    shipped = data_folder() / "mounts" / f"{robot}.json"
    file = JsonFile(shipped if shipped.is_file() else Path(robot), SCHEMA)
    try:
        patches = tuple(_patch(file, entry) for entry in file.objects("patches"))
        return Mounts(patches, file.number("spacing_m", SPACING_M))
    except RobotModelError:
        raise
    except InputError as error:
        raise type(error)(f"{file.path}: {error.message}", **error.numbers, file=str(file.path)) from error


def _patch(file: JsonFile, entry: dict[str, object]) -> MountPatch:
    edges = entry.get("edges_m")
    if not isinstance(edges, list) or len(edges) != 2:
        raise file.error("edges_m are no two edges", key="edges_m")
    return MountPatch(
        file.text_of(entry, "name"), file.text_of(entry, "link"), file.vector_of(entry, "corner_m"),
        np.array([file.vector_of({"edges_m": edge}, "edges_m") for edge in edges]),
        file.vector_of(entry, "dipole"), file.text_of(entry, "role"),
    )  # fmt: skip
