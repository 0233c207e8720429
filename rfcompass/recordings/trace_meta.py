"""What is needed to interpret the reads of a trace, and nothing about where the tags are."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from rfcompass.recordings.defects import defect

META_FILE = "meta.json"
PHASE_MODULI_RAD = {"2pi": 2.0 * np.pi, "pi": np.pi}
GEOMETRIES = ("monostatic", "bistatic")

Vector: TypeAlias = tuple[float, float, float]


@dataclass(frozen=True, slots=True)
class TraceTag:
    """One tag that belongs to a trace, and how it is mounted if it rides on a robot or a part.

    Attributes:
        epc: EPC of the tag.
        body: `"robot"`, a part id, or None.
        link: URDF link of a robot tag, or None.
        point_m: Tag centre in the link's or the part's frame [m], or None.
        dipole: Direction of the tag's electrical axis in that frame, or None.
        unknown_json: Keys that this version does not know, as JSON text, kept for rewriting.
    """

    epc: str
    body: str | None = None
    link: str | None = None
    point_m: Vector | None = None
    dipole: Vector | None = None
    unknown_json: str = "{}"


@dataclass(frozen=True, slots=True)
class TraceMeta:
    """How to interpret the reads of a trace.

    A raw phase is `phase_sign` · 2π f d / c + constant, modulo `phase_modulus`, with d the round trip
    antenna → tag → antenna.

    Attributes:
        frame: Frame of the antenna poses.
        geometry: `"monostatic"` or `"bistatic"`.
        phase_sign: +1 if the raw phase grows with distance, else -1.
        phase_modulus: `"2pi"`, or `"pi"` for readers with a half-turn ambiguity.
        dimensions: 2 if tags and antennas share one plane, else 3.
        tags: Tags that belong to the trace; other EPCs are strays. Empty: no list was made, all EPCs belong.
        source: Where the reads come from.
        license: What may be done with them.
        reader: Make and model of the reader.
        robot: Name or path of the URDF when tags ride on a robot, or None.
        tag_layout: Name of that robot's tag layout, or None.
        channel_offsets_rad: Pairs (frequency [Hz], constant of the raw phase [rad]), ascending; empty if unknown.
        unknown_json: Keys that this version does not know, as JSON text, kept for rewriting.

    Raises:
        TraceError: If a value is not possible; `column` is its key, `row` the number of the tag.
    """

    frame: str
    geometry: str = "monostatic"
    phase_sign: int = 1
    phase_modulus: str = "2pi"
    dimensions: int = 3
    tags: tuple[TraceTag, ...] = ()
    source: str = "not stated"
    license: str = "not stated"
    reader: str = "not stated"
    robot: str | None = None
    tag_layout: str | None = None
    channel_offsets_rad: tuple[tuple[float, float], ...] = ()
    unknown_json: str = "{}"

    def __post_init__(self) -> None:
        """Check every value."""
        object.__setattr__(self, "tags", tuple(self.tags))
        object.__setattr__(self, "channel_offsets_rad", tuple(sorted(self.channel_offsets_rad)))
        _check_choice("geometry", self.geometry, GEOMETRIES)
        _check_choice("phase_sign", self.phase_sign, (1, -1))
        _check_choice("phase_modulus", self.phase_modulus, tuple(PHASE_MODULI_RAD))
        _check_choice("dimensions", self.dimensions, (2, 3))
        for key in ("frame", "source", "license", "reader"):
            _check_text(key, getattr(self, key))
        for key in ("robot", "tag_layout"):
            _check_text(key, getattr(self, key), optional=True)
        object.__setattr__(self, "phase_sign", int(self.phase_sign))
        object.__setattr__(self, "dimensions", int(self.dimensions))
        _check_tags(self.tags)
        _check_offsets(self.channel_offsets_rad)

    @property
    def epcs(self) -> tuple[str, ...]:
        """EPCs of the listed tags, in the order of the list."""
        return tuple(tag.epc for tag in self.tags)

    @property
    def phase_modulus_rad(self) -> float:
        """Period of the raw phase [rad], 2π or π."""
        return float(PHASE_MODULI_RAD[self.phase_modulus])


def _check_choice(key: str, value: object, choices: tuple[object, ...]) -> None:
    if isinstance(value, bool) or value not in choices:
        raise defect(META_FILE, f"{value!r} is none of {', '.join(map(repr, choices))}", column=key, value=value)


def _check_text(key: str, value: object, *, optional: bool = False, row: int | None = None) -> None:
    if value is None and optional:
        return
    if not isinstance(value, str) or not value:
        raise defect(META_FILE, f"{value!r} is no text", column=key, row=row)


def _check_tags(tags: Sequence[TraceTag]) -> None:
    seen: dict[str, int] = {}
    for row, tag in enumerate(tags):
        _check_text("epc", tag.epc, row=row)
        _check_text("body", tag.body, optional=True, row=row)
        _check_text("link", tag.link, optional=True, row=row)
        if tag.epc in seen:
            message = f"EPC {tag.epc} stands twice (also in row {seen[tag.epc]})"
            raise defect(META_FILE, message, column="tags", row=row, epc=tag.epc)
        seen[tag.epc] = row
        if tag.point_m is not None and tag.link is None and tag.body in (None, "robot"):
            message = f"point_m of EPC {tag.epc} has no frame: neither a link nor a part is given"
            raise defect(META_FILE, message, column="point_m", row=row, epc=tag.epc)
        if tag.dipole is not None and not any(tag.dipole):
            raise defect(META_FILE, f"dipole of EPC {tag.epc} has length zero", column="dipole", row=row, epc=tag.epc)


def _check_offsets(offsets: Sequence[tuple[float, float]]) -> None:
    for freq_hz, offset_rad in offsets:
        if not (math.isfinite(freq_hz) and freq_hz > 0 and math.isfinite(offset_rad)):
            message = f"offset {offset_rad} rad at {freq_hz} Hz is not possible"
            raise defect(META_FILE, message, column="channel_offsets_rad", freq_hz=freq_hz, offset_rad=offset_rad)
    if len({freq_hz for freq_hz, _ in offsets}) < len(offsets):
        raise defect(META_FILE, "a frequency stands twice", column="channel_offsets_rad")
