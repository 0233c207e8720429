"""A scan by radio: an antenna carrier drives its track while the reader takes the inventory of all tags."""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import TypeAlias

import numpy as np

from rfcompass.arrays import FloatArray, read_only
from rfcompass.errors import InputError
from rfcompass.geometry.pose2 import Pose2
from rfcompass.simulation.inventory import simulate_inventory
from rfcompass.simulation.placed_tags import PlacedTags
from rfcompass.simulation.radio_scene import RadioScene, Scatterers
from rfcompass.simulation.reader_rig import RIG_PAPER, ReaderRig
from rfcompass.simulation.room_sensing import Heard, RoomState
from rfcompass.simulation.tracks import AntennaTrack
from rfcompass.types.record import Record

# Ours: one straight leg along a wall of the 6 x 5 m room, and a second one along the next wall; 3 m each about the
# middle of the wall, 0.7 m from it, and the whip 0.3 m above the floor.
FAR_LINE_M = (((1.5, 0.7, 0.3), (4.5, 0.7, 0.3)),)
FAR_L_M = (*FAR_LINE_M, ((0.7, 1.0, 0.3), (0.7, 4.0, 0.3)))

# Ours: the metal of the robot as four small scatterers about its base, in the base frame [m], and their size [m²].
# A point stands for a body only from afar, so each keeps half a wavelength, 16 cm, from every tag of the X4 layout.
# A large convex body scatters, in the mean over all directions, as much as a quarter of its surface takes up: 0.18 m²
# for the youBot's chassis of 0.58 x 0.38 x 0.14 m.
BODY_POINTS_M = ((0.10, 0.0, 0.08), (-0.05, 0.0, 0.08), (-0.24, 0.0, 0.06), (0.20, 0.0, 0.35))
BODY_CROSS_SECTION_M2 = (0.05, 0.05, 0.05, 0.03)

# Gain of the antenna of a broken tag [dB]; ours: far too little to wake a chip.
_BROKEN_DB = -200.0

Leg: TypeAlias = tuple[tuple[float, float, float], tuple[float, float, float]]


@dataclass(frozen=True, slots=True, kw_only=True)
class Carrier(Record):
    """A second robot that drives the receiving antenna along straight legs, and how well it knows where it is.

    All values are ours; [Wang2013] prints none.

    Attributes:
        legs_m: Start and end of each straight leg in the room [m], shape (L, 2, 3).
        spacing_m: Largest distance between two positions [m].
        facing_m: Point that the boresight always points at [m], shape (3,); along the room's x if None.
        ports: Ports that are read through in turn at each position, such as the two feeds of a dual antenna.
        walk_m: Standard deviation of each step of a random walk about the track [m].
        leg_offset_m: Standard deviation of the place of every leg after the first, along x and y [m].
        leg_turn_rad: Standard deviation of its heading [rad].
    """

    legs_m: FloatArray = field(default_factory=lambda: np.array(FAR_L_M))
    spacing_m: float = 0.04
    facing_m: FloatArray | None = None
    ports: tuple[int, ...] = (1,)
    walk_m: float = 0.001
    leg_offset_m: float = 0.02
    leg_turn_rad: float = float(np.deg2rad(1.0))

    def __post_init__(self) -> None:
        """Freeze the legs; refuse errors that cannot be."""
        object.__setattr__(self, "legs_m", read_only(self.legs_m, "Carrier.legs_m", (None, 2, 3)))
        if not len(self.legs_m):
            raise InputError("Carrier.legs_m: at least one leg is needed", name="legs_m")
        for name in ("walk_m", "leg_offset_m", "leg_turn_rad"):
            if not (np.isfinite(value := getattr(self, name)) and value >= 0):
                raise InputError(f"Carrier.{name}: {value} is not a finite number >= 0", name=name)

    def track(self) -> AntennaTrack:
        """Return where the carrier believes that it goes."""
        return _joined(self._nominal_legs()).through_ports(self.ports)

    def driven(self, rng: np.random.Generator) -> AntennaTrack:
        """Return where it truly goes: every leg after the first has an error of its own."""
        driven = []
        for index, nominal in enumerate(self._nominal_legs()):
            known = 0.0 if index == 0 else 1.0
            driven.append(
                nominal.perturbed(
                    rng,
                    walk_m_per_step=self.walk_m,
                    offset_m=known * self.leg_offset_m,
                    turn_rad=known * self.leg_turn_rad,
                )
            )
        return _joined(driven).through_ports(self.ports)

    def _nominal_legs(self) -> list[AntennaTrack]:
        return [AntennaTrack.line(start, end, self.spacing_m, facing_m=self.facing_m) for start, end in self.legs_m]


def _joined(legs: Sequence[AntennaTrack]) -> AntennaTrack:
    whole = legs[0]
    for leg in legs[1:]:
        whole = whole.then(leg)
    return whole


def metal_body() -> Scatterers:
    """Scatterers of a youBot, in its base frame; sizes and places are ours."""
    points_m = np.array(BODY_POINTS_M)
    return Scatterers(points_m, np.array(BODY_CROSS_SECTION_M2), np.arange(len(points_m)) * np.pi / 2)


@dataclass(frozen=True, slots=True, kw_only=True)
class RadioSensor:
    """Hears the tags of a room by radio.

    Tags keep their own phase and gain from stop to stop. The robot's body scatters from wherever it stands.

    Attributes:
        scene: Room, obstacles and scatterers.
        robot_tags: Tags of the robot, in the order of its layout; where they are is told by each scan.
        part_tags: Tags of the part, likewise.
        other_tags: Tags of other parts in the room, where they lie.
        rig: The reader.
        carrier: Who moves the antenna.
        body: Scatterers of the robot in its base frame; `Scatterers.none()` for a robot of air.
    """

    scene: RadioScene
    robot_tags: PlacedTags
    part_tags: PlacedTags
    other_tags: tuple[PlacedTags, ...] = ()
    rig: ReaderRig = RIG_PAPER
    carrier: Carrier = field(default_factory=Carrier)
    body: Scatterers = field(default_factory=metal_body)

    def along(self, legs_m: FloatArray) -> "RadioSensor":
        """Return the sensor with other legs of the antenna's track [m], shape (L, 2, 3)."""
        return replace(self, carrier=replace(self.carrier, legs_m=legs_m))

    def seeking(self, epcs: Sequence[str], state: RoomState) -> "RadioSensor":
        """Return the sensor that listens to another part; the present one becomes one of the others.

        Args:
            epcs: The other part's tags in use.
            state: Where everything is now: the present part stays there.

        Raises:
            InputError: If no other part has these tags.
        """
        wanted = next((tags for tags in self.other_tags if tags.epcs == tuple(epcs)), None)
        if wanted is None:
            raise InputError(f"no other part in the room has the tags {', '.join(epcs)}", name="epcs")
        left = self.part_tags.moved(state.targets.points_m, state.target_dipoles)
        others = tuple(left if tags is wanted else tags for tags in self.other_tags)
        return replace(self, part_tags=wanted, other_tags=others)

    def silenced(self, epcs: Sequence[str]) -> "RadioSensor":
        """Return the sensor in a room where these tags are broken: no power makes them answer."""
        gone = set(epcs)
        others = tuple(_broken(tags, gone) for tags in self.other_tags)
        return replace(self, part_tags=_broken(self.part_tags, gone), other_tags=others)

    def hear(self, state: RoomState, rng: np.random.Generator) -> Heard:
        """Drive the track once and take the inventory."""
        tags = (
            self.robot_tags.moved(state.anchors.points_m, state.anchor_dipoles),
            self.part_tags.moved(state.targets.points_m, state.target_dipoles),
            *self.other_tags,
        )
        scene = self.scene.with_scatterers(_carried(self.body, state.T_room_base))
        track, nominal = self.carrier.driven(rng), self.carrier.track()
        return Heard(inventory=simulate_inventory(scene, self.rig, track, tags, rng, nominal_track=nominal))


def _broken(tags: PlacedTags, epcs: set[str]) -> PlacedTags:
    gain_db = np.where([epc in epcs for epc in tags.epcs], _BROKEN_DB, tags.gain_db)
    return replace(tags, gain_db=gain_db)


def _carried(body: Scatterers, T_room_base: Pose2) -> Scatterers:
    return Scatterers(
        T_room_base.apply(body.points_m), body.cross_section_m2, body.phase_rad,
        Pose2(0.0, 0.0, T_room_base.theta_rad).apply(np.asarray(body.axes)), body.depolarisation,
    )  # fmt: skip
