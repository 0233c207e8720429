"""One tag on a table, in sight or buried in a pile, scanned from a wrist that goes round a square above it.

Scene frame: the table is the floor, z = 0; the square is about `CENTRE_M`. [Boroushaki2023] prints a level square path,
a linear wide-band antenna on the wrist and the error to the nearest point of the tag; lengths, bands and piles are
ours.
"""

from dataclasses import dataclass, replace

import numpy as np

from rfcompass.arrays import FloatArray
from rfcompass.simulation import (
    RIG_WRIST,
    SQUIGGLE,
    AntennaTrack,
    PlacedTags,
    RadioScene,
    ReaderRig,
    inventory_scan,
    load_recipe,
    simulate_inventory,
)
from rfcompass.types.reads import Scan
from rfcompass.types.scene import Material, Obstacle, Scene
from rfcompass.types.shapes import Box
from rfcompass.types.volumes import SearchVolume

EPC = "e0"
CENTRE_M = np.array([2.0, 2.0])
SIDE_M = 0.5
HEIGHTS_M = {"one": (0.45,), "two": (0.35, 0.60)}
BANDS_HZ = {  # carriers of each bandwidth in MHz, as in our pilot study
    26.0: np.linspace(902e6, 928e6, 8),
    200.0: np.linspace(800e6, 1000e6, 17),
    500.0: np.linspace(500e6, 1000e6, 41),
}
TAG_AREA_M = 0.25  # from the centre, along x and y
TAG_HEIGHT_M = (0.02, 0.15)
TAG_LENGTH_M = 0.094  # Alien Squiggle
TAG_TILT_RAD = float(np.radians(20.0))
JITTER_M = 0.001  # of each antenna position, as the arm knows it
SEARCH = SearchVolume(np.array([*(CENTRE_M - 0.35), 0.0]), np.array([*(CENTRE_M + 0.35), 0.25]))

# What lies over a buried tag: three things, one on the other, and a cloth. Permittivities are those of what is packed
# loosely, mostly air: a box of small parts, a soft toy, plastic things. Nothing wet, nothing of metal.
COVER_MATERIALS = {
    "packed": Material("packed", permittivity=1.3, loss_db_per_m=3.0),
    "plush": Material("plush", permittivity=1.2, loss_db_per_m=3.0),
    "plastics": Material("plastics", permittivity=1.8, loss_db_per_m=8.0),
    "cloth": Material("cloth", permittivity=1.6, loss_db_per_m=5.0),
}
COVER_EDGE_M = (0.10, 0.25)
COVER_THICKNESS_M = (0.02, 0.05)
COVER_OFFSET_M = 0.06
COVER_GAP_M = 0.005
CLOTH_M = (0.6, 0.6, 0.004)


@dataclass(frozen=True, slots=True)
class TagOnTable:
    """One tag and what is about it: the truth.

    Attributes:
        tags: The tag.
        in_sight: Room, table and small things.
        buried: The same with a pile over the tag.
    """

    tags: PlacedTags
    in_sight: RadioScene
    buried: RadioScene

    @property
    def point_m(self) -> FloatArray:
        """Middle of the tag [m], shape (3,)."""
        return np.asarray(self.tags.points_m[0])

    def miss_m(self, point_m: FloatArray) -> float:
        """Distance from an estimate [m], shape (3,), to the nearest point of the tag, as [Boroushaki2023] measures."""
        off_m, dipole = point_m - self.point_m, self.tags.dipoles[0]
        along_m = np.clip(off_m @ dipole, -TAG_LENGTH_M / 2, TAG_LENGTH_M / 2)
        return float(np.linalg.norm(off_m - along_m * dipole))


def draw_tag_on_table(rng: np.random.Generator, turn_rad: float) -> TagOnTable:
    """Put a tag on the table and things about and over it.

    Args:
        rng: Source of everything.
        turn_rad: Largest turn of the tag about the vertical, away from the axis of the wrist's antennas [rad].
    """
    point_m = np.array([*(CENTRE_M + rng.uniform(-TAG_AREA_M, TAG_AREA_M, 2)), rng.uniform(*TAG_HEIGHT_M)])
    turn, tilt = rng.uniform(-1.0, 1.0) * turn_rad, rng.uniform(-TAG_TILT_RAD, TAG_TILT_RAD)
    dipole = np.array([np.cos(tilt) * np.cos(turn), np.cos(tilt) * np.sin(turn), np.sin(tilt)])
    tags = PlacedTags.draw((EPC,), point_m[None], dipole[None], SQUIGGLE, rng)
    in_sight = load_recipe("tabletop").draw(rng, part_m=(float(point_m[0]), float(point_m[1])))
    return TagOnTable(tags, in_sight, replace(in_sight, scene=_covered(in_sight.scene, point_m, rng)))


def wrist_rig(band_mhz: float) -> ReaderRig:
    """FuseBot's wrist with the carriers of one bandwidth."""
    return replace(RIG_WRIST, frequencies_hz=BANDS_HZ[band_mhz])


def wrist_track(heights: str) -> AntennaTrack:
    """Once round the square at each height; the antennas look down."""
    squares = [AntennaTrack.square(CENTRE_M, SIDE_M, height_m) for height_m in HEIGHTS_M[heights]]
    track = squares[0]
    for square in squares[1:]:
        track = track.then(square)
    return track


def scan_from_wrist(
    scene: RadioScene, tags: PlacedTags, rig: ReaderRig, track: AntennaTrack, rng: np.random.Generator
) -> Scan:
    """Scan once; the arm believes in the track and is off by a millimetre at each position."""
    went = track.perturbed(rng, jitter_m=JITTER_M)
    return inventory_scan(simulate_inventory(scene, rig, went, tags, rng, nominal_track=track), tags.epcs)


def _covered(scene: Scene, point_m: FloatArray, rng: np.random.Generator) -> Scene:
    """Stack things over a tag and lay a cloth over them."""
    z_m, things = float(point_m[2]) + COVER_GAP_M, []
    for number, material in enumerate(rng.permutation(["packed", "plush", "plastics"]).tolist()):
        size_m = np.array([*rng.uniform(*COVER_EDGE_M, 2), rng.uniform(*COVER_THICKNESS_M)])
        middle_m = [*(point_m[:2] + rng.uniform(-COVER_OFFSET_M, COVER_OFFSET_M, 2)), z_m + size_m[2] / 2]
        things.append(_thing(f"thing_{number}", material, size_m, middle_m, rng.uniform(-np.pi, np.pi)))
        z_m += float(size_m[2])
    middle_m = [*point_m[:2], z_m + CLOTH_M[2] / 2]
    things.append(_thing("cloth", "cloth", np.array(CLOTH_M), middle_m, 0.0))
    return replace(scene, materials={**scene.materials, **COVER_MATERIALS}).with_obstacles(things)


def _thing(name: str, material: str, size_m: FloatArray, middle_m: list[float], yaw_rad: float) -> Obstacle:
    c, s = np.cos(yaw_rad), np.sin(yaw_rad)
    T = np.eye(4)
    T[:2, :2], T[:3, 3] = [[c, -s], [s, c]], middle_m
    return Obstacle(name, Box(size_m), T, material)
