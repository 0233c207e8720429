"""A scan of a pile with camera and antennas on one arm, on one motion [Boroushaki2023], section 3.

The pile stands on the table top of the recipe `tabletop`: walls, the reflecting table and small things about it are
the clutter. What lies over a tag costs power and delays the wave by its material, every panel of a cover for itself.
"""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numba
import numpy as np

from rfcompass.arrays import FloatArray, IntArray, read_only
from rfcompass.errors import PileError
from rfcompass.simulation.inventory import Inventory, simulate_inventory
from rfcompass.simulation.inventory_averages import inventory_scan
from rfcompass.simulation.occlusion import obstacle_table, pass_obstacles
from rfcompass.simulation.piles.camera import PileCamera
from rfcompass.simulation.piles.pile_shapes import radio_scene
from rfcompass.simulation.piles.tagging import TaggedItems
from rfcompass.simulation.piles.world import PileWorld
from rfcompass.simulation.placed_tags import SQUIGGLE, PlacedTags, TagModel
from rfcompass.simulation.radio_scene import RadioScene
from rfcompass.simulation.reader_rig import RIG_WRIST, ReaderRig
from rfcompass.simulation.recipes import load_recipe
from rfcompass.simulation.tracks import AntennaTrack
from rfcompass.types.piles import DepthView
from rfcompass.types.reads import Scan
from rfcompass.types.record import Record

FRAME = "table"  # of traces of such scans: z up, the table top is z = 0
# The table's middle in the room of the recipe [m].
_MIDDLE_M = (2.0, 2.0, 0.0)
# Half the table's edges; what is further from its middle has rolled off [m]. Ours.
_TABLE_M = 1.0
# A tag under a thing that lies on the table is this high [m]; ours.
_LEAST_M = 0.001


@dataclass(frozen=True, slots=True, kw_only=True)
class PileRig(Record):
    """What the arm carries, and how well it knows where.

    Attributes:
        rig: Reader and antennas.
        tags: Type of all tags.
        jitter_m: Standard deviation of each antenna position along each axis, as the arm knows it [m]; ours.
    """

    rig: ReaderRig = field(default_factory=lambda: RIG_WRIST)
    tags: TagModel = SQUIGGLE
    jitter_m: float = 0.001


@dataclass(frozen=True, slots=True)
class PileScan(Record):
    """What camera and reader handed out; no truth.

    Attributes:
        views: Depth images, in the order of the poses.
        inventory: What the reader reported, with antenna positions in the table's frame.
    """

    views: tuple[DepthView, ...]
    inventory: Inventory

    def scan(self, epcs: Collection[str]) -> Scan:
        """Reads of some tags as estimators take them."""
        return inventory_scan(self.inventory, epcs, FRAME)


@dataclass(frozen=True, slots=True)
class TagCover(Record):
    """What lies between the antenna and each of T tags, over M antenna positions: truth.

    Attributes:
        things: Items that the straight line goes through, its own among them where it is turned away, shape (M, T).
        loss_db: What they cost on the way [dB], shape (M, T).
        material: What most of the things on the lines are made of, `""` where all lines are free, T names.
    """

    things: IntArray
    loss_db: FloatArray
    material: tuple[str, ...]

    def __post_init__(self) -> None:
        """Freeze the arrays."""
        shape = np.shape(self.things)
        object.__setattr__(self, "things", read_only(self.things, "TagCover.things", shape, np.int64))
        object.__setattr__(self, "loss_db", read_only(self.loss_db, "TagCover.loss_db", shape))

    @property
    def hidden_share(self) -> FloatArray:
        """Share of the antenna positions from which something lies before each tag, shape (T,)."""
        return np.asarray((self.things > 0).mean(axis=0))


@dataclass(frozen=True, slots=True)
class RadioSetting(Record):
    """What stays as it is from one scan of a pile to the next: truth.

    Attributes:
        around: The room with the small things about the table.
        phase_rad: Constant that each tag adds to the phase of its echo [rad], by EPC.
        gain_db: How much better each tag's antenna is than its model's [dB], by EPC.
    """

    around: RadioScene
    phase_rad: Mapping[str, float]
    gain_db: Mapping[str, float]

    @classmethod
    def draw(cls, epcs: Sequence[str], rng: np.random.Generator, rig: PileRig | None = None) -> "RadioSetting":
        """Draw the small things, and the constants of some tags."""
        spread_db = (PileRig() if rig is None else rig).tags.gain_spread_db
        phase_rad, gain_db = rng.uniform(0.0, 2.0 * np.pi, len(epcs)), rng.normal(0.0, spread_db, len(epcs))
        pairs = (dict(zip(epcs, values.tolist(), strict=True)) for values in (phase_rad, gain_db))
        return cls(_small_things(rng), *pairs)

    def placed(self, epcs: Sequence[str], points_m: FloatArray, dipoles: FloatArray, model: TagModel) -> PlacedTags:
        """Some of its tags where they are now; as for `PlacedTags.draw`."""
        phase_rad, gain_db = (np.array([of[epc] for epc in epcs]) for of in (self.phase_rad, self.gain_db))
        return PlacedTags(tuple(epcs), points_m, dipoles, model, phase_rad, gain_db)


def scan_pile(
    world: PileWorld,
    tags: TaggedItems,
    camera_poses: FloatArray,
    track: AntennaTrack,
    rng: np.random.Generator,
    rig: PileRig | None = None,
) -> PileScan:
    """Go round once: an image at each camera pose, an inventory along the antenna's track.

    Args:
        world: The pile.
        tags: Which items carry tags.
        camera_poses: Where the arm believes the camera, in the world, shape (V, 4, 4).
        track: Where it believes the receiving antenna, in the world.
        rng: Source of clutter, noise and errors.
        rig: What the arm carries.

    Raises:
        PileError: If no item on the table carries a tag.
        InputError: If the antenna goes through the table or the walls of the room.
    """
    camera, views = PileCamera(world, rng), []
    for T in camera_poses:
        camera.move_to(T)
        views.append(camera.view())
    return PileScan(tuple(views), hear_tags(world, tags, track, rng, rig))


def hear_tags(
    world: PileWorld,
    tags: TaggedItems,
    track: AntennaTrack,
    rng: np.random.Generator,
    rig: PileRig | None = None,
    setting: RadioSetting | None = None,
) -> Inventory:
    """Take one inventory along a track of the receiving antenna; arguments and errors as for `scan_pile`.

    What has rolled off the table is not heard. Who listens to one pile more than once gives the same setting each time.
    """
    rig = PileRig() if rig is None else rig
    placed_epcs, points_m, dipoles = tags.placed(world)
    near = np.abs(points_m[:, :2]).max(axis=1, initial=0.0) < _TABLE_M
    epcs = [placed_epcs[t] for t in np.flatnonzero(near)]
    if not epcs:
        raise PileError("nothing on the table carries a tag", key="tags", got=0)
    points_m, dipoles = points_m[near], dipoles[near]
    points_m = np.maximum(points_m, [-np.inf, -np.inf, _LEAST_M]) + _MIDDLE_M
    if setting is None:
        placed = PlacedTags.draw(epcs, points_m, dipoles, rig.tags, rng)
    else:
        placed = setting.placed(epcs, points_m, dipoles, rig.tags)
    went = track.perturbed(rng, jitter_m=rig.jitter_m)
    went = replace(went, positions_m=went.positions_m + _MIDDLE_M)
    around = _small_things(rng) if setting is None else setting.around
    return simulate_inventory(_with_pile(around, world), rig.rig, went, placed, rng, nominal_track=track)


def _small_things(rng: np.random.Generator) -> RadioScene:
    """The room of the recipe, with its small things about the table."""
    return load_recipe("tabletop").draw(rng, part_m=_MIDDLE_M[:2])


def _with_pile(around: RadioScene, world: PileWorld) -> RadioScene:
    """The same room with the pile in it."""
    T_room_world = np.eye(4)
    T_room_world[:3, 3] = _MIDDLE_M
    pile = radio_scene(world, T_room_world)
    scene = replace(around.scene, materials={**around.scene.materials, **pile.materials})
    return replace(around, scene=scene.with_obstacles(pile.obstacles))


def tag_cover(world: PileWorld, tags: TaggedItems, positions_m: FloatArray) -> TagCover:
    """Say what lies on the straight lines from antenna positions to the tags.

    Args:
        world: The pile.
        tags: Which items carry tags.
        positions_m: Antenna positions in the world [m], shape (M, 3).
    """
    _, points_m, _ = tags.placed(world)
    points_m = np.maximum(points_m, [-np.inf, -np.inf, _LEAST_M])
    things = np.zeros((len(positions_m), len(points_m)), dtype=np.int64)
    loss_db, lines = np.zeros(things.shape), dict.fromkeys(sorted({item.material for item in world.items}), 0)
    scene = radio_scene(world)
    panels = np.repeat([item.number for item in world.items], [len(world.panel_poses(i.number)) for i in world.items])
    for item in world.items:
        own = tuple(obstacle for obstacle, n in zip(scene.obstacles, panels, strict=True) if n == item.number)
        here_db = _loss_db(obstacle_table(replace(scene, obstacles=own)), positions_m, points_m)
        things += here_db > 0
        loss_db += here_db
        lines[item.material] += (here_db > 0).sum(axis=0)
    names, counts = list(lines), np.array([np.broadcast_to(count, len(points_m)) for count in lines.values()])
    material = tuple(names[k] if counts[k, t] else "" for t, k in enumerate(counts.argmax(axis=0)))
    return TagCover(things, loss_db, material)


@numba.njit(cache=True)
def _loss_db(table: FloatArray, positions_m: FloatArray, points_m: FloatArray) -> FloatArray:
    """Loss of every straight line through a table of obstacles [dB], shape (M, T)."""
    loss_db = np.zeros((len(positions_m), len(points_m)))
    for m in range(len(positions_m)):
        start = (positions_m[m, 0], positions_m[m, 1], positions_m[m, 2])
        for t in range(len(points_m)):
            x, y, z = points_m[t, 0] - start[0], points_m[t, 1] - start[1], points_m[t, 2] - start[2]
            length_m = np.sqrt(x * x + y * y + z * z)
            way = (x / length_m, y / length_m, z / length_m)
            loss_db[m, t] = pass_obstacles(start, way, length_m, table)[0]
    return loss_db
