"""Which radio a simulated job uses, and the room that it sounds in."""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from rfcompass.arrays import FloatArray
from rfcompass.geometry.pose2 import Pose2
from rfcompass.simulation import (
    FAR_L_M,
    FAR_LINE_M,
    RIG_PAPER,
    SQUIGGLE,
    Carrier,
    PlacedTags,
    PlaneRoom,
    RadioScene,
    RadioSensor,
    ReaderRig,
    SceneRecipe,
    TagModel,
    load_recipe,
)
from rfcompass.simulation.radio_sensing import Leg
from rfcompass.simulation.scene_recipe import Disc
from rfcompass.types.parts import Part
from rfcompass.types.tags import TagLayout

# Ours: robot and part start clear of the antenna's tracks along two walls and of the other walls; the robot's bumper
# stops it 0.6 m from any wall, where the hand at full reach still has room.
AREA_M = ((1.3, 1.3), (5.5, 4.5))
DRIVE_AREA_M = ((0.6, 0.6), (5.4, 4.4))
ROBOT_CLEAR_M = 0.6
OTHER_CLEAR_M = 0.4  # about further parts that are to be fetched: room for a hand, and less than about the first
TRACK_CLEAR_M = 0.3
PART_CLEAR_M = 0.2  # half a leg
LYING_HEIGHT_M = 0.1


@dataclass(frozen=True, slots=True, kw_only=True)
class RadioSetup:
    """What a simulated job hears with.

    Attributes:
        scene: Recipe of the room, by name or file.
        legs_m: Start and end of each straight leg of the antenna's track in the room [m].
        rig: The reader.
        facing_m: Point that the antenna always looks at [m]; whips need none.
        ports: Ports that are read through in turn at each position.
        tag_model: Type of all tags but the part's.
        part_tag_model: Type of the part's tags.
        others: Other tagged parts in the room, all their tags on.
    """

    scene: str = "room_los"
    legs_m: Sequence[Leg] = FAR_L_M
    rig: ReaderRig = RIG_PAPER
    facing_m: tuple[float, float, float] | None = None
    ports: tuple[int, ...] = (1,)
    tag_model: TagModel = SQUIGGLE
    part_tag_model: TagModel = SQUIGGLE
    others: tuple[Part, ...] = field(default=())

    def sensor(self, room: PlaneRoom, robot: TagLayout, part: TagLayout, rng: np.random.Generator) -> RadioSensor:
        """Furnish a room for one run, and make the sensor that listens in it.

        Args:
            room: Where robot and part truly are.
            robot: The robot's tags.
            part: The part's tags in use.
            rng: Source of furniture, scatterers and tag constants.
        """
        facing_m = None if self.facing_m is None else np.array(self.facing_m)
        carrier = Carrier(legs_m=np.array(self.legs_m), facing_m=facing_m, ports=self.ports)
        recipe = load_recipe(self.scene)
        scene = self._furnished(recipe, room, carrier, rng)
        return RadioSensor(
            scene=scene,
            robot_tags=_unplaced(robot, self.tag_model, rng),
            part_tags=_unplaced(part, self.part_tag_model, rng),
            other_tags=(
                *(self._lying(one.part, one.layout, one.T_room_part, rng) for one in room.others),
                *self._others(recipe, room, [*_clear_of(carrier), *_standing(scene)], rng),
            ),
            rig=self.rig,
            carrier=carrier,
        )

    def _furnished(
        self, recipe: SceneRecipe, room: PlaneRoom, carrier: Carrier, rng: np.random.Generator
    ) -> RadioScene:
        clear = [*_clear_of(carrier), (room.T_room_base.x_m, room.T_room_base.y_m, ROBOT_CLEAR_M)]
        clear += [(one.T_room_part.x_m, one.T_room_part.y_m, OTHER_CLEAR_M) for one in room.others]
        part_m, reader_m = room.T_room_part.translation_m, carrier.track().positions_m[:, :2].mean(axis=0)
        return recipe.draw(rng, part_m=part_m.tolist(), reader_m=reader_m.tolist(), keep_clear=clear)

    def _others(
        self, recipe: SceneRecipe, room: PlaneRoom, taken: Sequence[Disc], rng: np.random.Generator
    ) -> tuple[PlacedTags, ...]:
        if not self.others:
            return ()
        poses = (room.T_room_base, room.T_room_part, *(one.T_room_part for one in room.others))
        own = [(pose.x_m, pose.y_m, ROBOT_CLEAR_M) for pose in poses]
        spots = recipe.clear_spots(len(self.others), PART_CLEAR_M, [*taken, *own], rng)
        headings = rng.uniform(-np.pi, np.pi, len(spots))
        return tuple(
            self._lying(part, part.tags, Pose2(x, y, heading), rng)
            for part, (x, y), heading in zip(self.others, spots, headings.tolist(), strict=True)
        )

    def _lying(self, part: Part, tags: TagLayout, pose: Pose2, rng: np.random.Generator) -> PlacedTags:
        lifted = tags.points_m + np.array([0.0, 0.0, part.resting_height_m])
        turned: FloatArray = Pose2(0.0, 0.0, pose.theta_rad).apply(tags.dipoles)
        return PlacedTags.draw(tags.epcs, pose.apply(lifted), turned, self.part_tag_model, rng)


def _clear_of(carrier: Carrier) -> list[Disc]:
    """Discs along the antenna's track."""
    return [(float(x), float(y), TRACK_CLEAR_M) for x, y in carrier.track().positions_m[::5, :2]]


def standing_m(scene: RadioScene) -> FloatArray:
    """Least and largest x, y of all that reaches the floor; what hangs higher is no obstacle there, shape (B, 2, 2)."""
    low = [ob.bounds_m[:, :2] for ob in scene.scene.obstacles if ob.bounds_m[0, 2] < LYING_HEIGHT_M]
    return np.array(low).reshape(-1, 2, 2)


def _standing(scene: RadioScene) -> list[Disc]:
    """Discs about what reaches the floor."""
    return [
        (float(x), float(y), float(np.hypot(*half_m)))
        for (x, y), half_m in ((b.mean(axis=0), np.diff(b, axis=0)[0] / 2) for b in standing_m(scene))
    ]


def _unplaced(layout: TagLayout, model: TagModel, rng: np.random.Generator) -> PlacedTags:
    """Draw the constants of a body's tags; each scan says where they are."""
    return PlacedTags.draw(layout.epcs, layout.points_m, layout.dipoles, model, rng)


# The paper's rig: one straight slide. Ours: an L, which also sees along the line of sight.
PAPER_RADIO = RadioSetup(legs_m=FAR_LINE_M)
BEST_RADIO = RadioSetup()
