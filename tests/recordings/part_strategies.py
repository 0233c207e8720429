"""Random parts for the tests of the part database, and how two of them are compared."""

import numpy as np
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from rfcompass.recordings.parts.part_json import part_content
from rfcompass.types.parts import Part, StablePose, TagSelection
from rfcompass.types.shapes import Box, Cylinder, Mesh, Sphere
from rfcompass.types.tags import ROLES, TagLayout

NAMES = st.from_regex(r"[a-z][a-z0-9_]{0,11}", fullmatch=True)
LENGTHS = st.floats(0.001, 2.0)
CODES = st.integers(0, 2**96 - 1).map(lambda code: f"{code:024x}")
PLACES = st.floats(-2.0, 2.0, allow_subnormal=False)


def points(count):
    return arrays(float, (count, 3), elements=PLACES)


SOLIDS = st.one_of(
    arrays(float, 3, elements=LENGTHS).map(Box),
    st.builds(Cylinder, LENGTHS, LENGTHS, st.sampled_from("xz")),
    st.builds(Sphere, LENGTHS),
)
MESHES = st.builds(
    lambda corners, turn: Mesh(corners, [[0, 1, 2], [2, 3, 4]], (corners[:4], corners), "vhacd", turned(turn)),
    points(5),
    st.floats(-3.0, 3.0),
)


def turned(angle):
    T = np.eye(4)
    T[:2, :2] = [[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]]
    T[:3, 3] = (angle, 0, 1)
    return T


@st.composite
def parts(draw, names=NAMES, codes=CODES):
    part_id, epcs = draw(names), tuple(draw(st.lists(codes, max_size=5, unique=True)))
    N = len(epcs)
    dipoles = draw(arrays(float, (N, 3), elements=st.floats(0.1, 1.0)))
    roles = tuple(draw(st.sampled_from(sorted(ROLES))) for _ in epcs)
    chosen = [TagSelection(epcs[:K], spacing) for K in range(1, N + 1) for spacing in ("ends", "inset")]
    if N:
        chosen[0] = TagSelection(epcs[:1], counterparts={"hand_left": epcs[0], "hand_right": epcs[0]})
    solid, mass_kg = draw(SOLIDS), draw(st.floats(0.001, 50.0))
    return Part(
        part_id=part_id,
        shape=draw(st.one_of(st.just(solid), MESHES)),
        mass_kg=mass_kg,
        inertia_kg_m2=mass_kg * solid.inertia_per_mass_m2,
        grasp_width_m=draw(LENGTHS),
        tags=TagLayout(part_id, epcs, ("part",) * N, draw(points(N)), dipoles, roles),
        selections=tuple(chosen[: draw(st.integers(0, len(chosen)))]),
        material=draw(st.text(min_size=1, max_size=20).filter(lambda text: text.isprintable())),
        rigid=draw(st.booleans()),
        stable_poses=tuple(StablePose(turned(draw(PLACES)), draw(st.floats(0.1, 1.0))) for _ in range(2)),
    )


def some_parts(most=3):
    """Up to `most` parts; no name and no EPC stands twice."""

    def one(place):
        codes = st.integers(0, 2**92 - 1).map(lambda code: f"{place:x}{code:023x}")
        return parts(NAMES.map(lambda name: f"{name}_{place}"), codes)

    return st.integers(0, most).flatmap(lambda count: st.tuples(*(one(place) for place in range(count))))


def same(a: Part, b: Part) -> bool:
    """True if two parts agree in every bit; the length of a dipole is rounded anew by each copy."""
    dipoles_agree = a.tags.epcs == b.tags.epcs and np.allclose(a.tags.dipoles, b.tags.dipoles, rtol=0, atol=1e-15)
    return bool(dipoles_agree) and _without_dipoles(a) == _without_dipoles(b)


def _without_dipoles(part: Part):
    content = part_content(part)
    for tag in content["tags"]:
        del tag["dipole"]
    return content
