"""Recipes of rooms: what is fixed, what is placed anew for every run, and what hides the part."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from rfcompass.arrays import FloatArray, read_only
from rfcompass.errors import SceneError
from rfcompass.simulation.radio_scene import RadioScene, Scatterers
from rfcompass.types.record import Record
from rfcompass.types.scene import Obstacle, Scene

Disc = tuple[float, float, float]  # x, y and radius of a place to keep clear [m]

_TRIES = 1000  # places for one thing, before giving up
_ARRANGEMENTS = 20


@dataclass(frozen=True, slots=True)
class Furniture(Record):
    """Something that stands about, several times.

    Attributes:
        name: What it is called; copies are numbered.
        count: How many there are.
        parts: Its solid parts in its own frame: z up, origin on the floor.
    """

    name: str
    count: int
    parts: tuple[Obstacle, ...]

    @property
    def radius_m(self) -> float:
        """Radius of a disc on the floor that holds it, whatever its heading [m]."""
        corners = np.concatenate([part.bounds_m[:, :2] for part in self.parts])
        return float(np.hypot(*np.abs(corners).max(axis=0)))

    def at(self, x_m: float, y_m: float, yaw_rad: float, label: str) -> list[Obstacle]:
        """Stand one copy somewhere [m, rad]."""
        c, s = np.cos(yaw_rad), np.sin(yaw_rad)
        T = np.array([[c, -s, 0.0, x_m], [s, c, 0.0, y_m], [0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, 1.0]])
        return [
            Obstacle(f"{label}_{part.name}", part.shape, T @ part.T_scene_obstacle, part.material, part.blocks_base)
            for part in self.parts
        ]


@dataclass(frozen=True, slots=True)
class ScattererRule(Record):
    """How the small things are drawn.

    Attributes:
        count: How many there are.
        cross_section_m2: Smallest and largest cross section [m²].
        low_m: Lowest corner of the volume that they lie in [m], shape (3,).
        high_m: Its highest corner [m], shape (3,).
        part_gap_m: Least distance from the part, in the plane [m].
    """

    count: int
    cross_section_m2: tuple[float, float]
    low_m: FloatArray
    high_m: FloatArray
    part_gap_m: float = 0.0

    def __post_init__(self) -> None:
        """Freeze and check."""
        object.__setattr__(self, "low_m", read_only(self.low_m, "ScattererRule.low_m", (3,)))
        object.__setattr__(self, "high_m", read_only(self.high_m, "ScattererRule.high_m", (3,)))
        if not 0 < self.cross_section_m2[0] <= self.cross_section_m2[1]:
            message = f"scatterers.cross_section_m2 is {self.cross_section_m2}, not two ascending numbers above 0"
            raise SceneError(message, key="scatterers.cross_section_m2", got=self.cross_section_m2)
        if not (self.count >= 0 and (self.low_m <= self.high_m).all()):
            raise SceneError("scatterers: a negative count, or low_m above high_m", key="scatterers", got=self.count)

    def draw(self, part_m: Sequence[float] | None, rng: np.random.Generator) -> Scatterers:
        """Draw places and constants of all of them."""
        points = np.empty((self.count, 3))
        for i in range(self.count):
            points[i] = rng.uniform(self.low_m, self.high_m)
            tries = 0
            while part_m is not None and np.hypot(*(points[i, :2] - np.asarray(part_m))) < self.part_gap_m:
                points[i] = rng.uniform(self.low_m, self.high_m)
                if (tries := tries + 1) > _TRIES:
                    raise SceneError("scatterers: no place is far enough from the part", key="scatterers.part_gap_m")
        return Scatterers.draw(points, self.cross_section_m2, rng)


@dataclass(frozen=True, slots=True)
class SceneRecipe(Record):
    """A kind of room; `draw` makes one of them.

    Attributes:
        base: What is always the same: room, materials, fixed obstacles.
        furniture: What is placed anew; pieces that find no room stay out.
        scatterers: The small things; None for none.
        between: A board that stands half way between reader and part, across the line of sight; parts in its own
            frame, whose x points from the reader to the part.
        over_part: What stands over the part.
        clear_m: Radius about part and reader that furniture keeps out of [m].
    """

    base: Scene
    furniture: tuple[Furniture, ...] = ()
    scatterers: ScattererRule | None = None
    between: Furniture | None = None
    over_part: Furniture | None = None
    clear_m: float = 0.6

    @property
    def name(self) -> str:
        """Name of the recipe."""
        return self.base.name

    def draw(
        self,
        rng: np.random.Generator,
        *,
        part_m: Sequence[float] | None = None,
        reader_m: Sequence[float] | None = None,
        keep_clear: Sequence[Disc] = (),
    ) -> RadioScene:
        """Furnish a room.

        Args:
            rng: Source of every place.
            part_m: Where the part lies, x and y [m]; needed if something hides it.
            reader_m: Where the reader is, x and y [m]; needed if a board stands between.
            keep_clear: Discs that furniture keeps out of: x, y and radius [m], such as along the antenna's track.

        Raises:
            SceneError: If a place that is needed is missing, or no piece of furniture finds room.
        """
        hiding = self._hiding(part_m, reader_m, rng)
        taken: list[Disc] = [(*_xy(place), self.clear_m) for place in (part_m, reader_m) if place is not None]
        taken += [(float(x), float(y), float(radius)) for x, y, radius in keep_clear]
        taken += [(*_xy(ob.T_scene_obstacle[:2, 3]), _radius(ob)) for ob in (*self.base.obstacles, *hiding)]
        standing = self._arranged(taken, rng)
        scatterers = Scatterers.none() if self.scatterers is None else self.scatterers.draw(part_m, rng)
        return RadioScene(self.base.with_obstacles([*hiding, *standing]), scatterers)

    def _arranged(self, taken: Sequence[Disc], rng: np.random.Generator) -> list[Obstacle]:
        """Place all furniture; begin again a few times where what stands already leaves no room for the rest.

        If nothing helps, pieces without room stay out, as they would; a room where none of them fits is refused.
        """
        for _ in range(_ARRANGEMENTS):
            try:
                return self._one_arrangement(taken, rng)
            except SceneError as error:
                refusal = error
        standing = self._one_arrangement(taken, rng, leave_out=True)
        if self.furniture and not standing:
            raise refusal
        return standing

    def _one_arrangement(
        self, taken: Sequence[Disc], rng: np.random.Generator, *, leave_out: bool = False
    ) -> list[Obstacle]:
        used, standing = list(taken), []
        for kind in self.furniture:
            for number in range(kind.count):
                try:
                    x, y = self._spot(kind.radius_m, used, rng, kind.name)
                except SceneError:
                    if not leave_out:
                        raise
                    continue
                standing += kind.at(x, y, rng.uniform(-np.pi, np.pi), f"{kind.name}_{number + 1}")
                used.append((x, y, kind.radius_m))
        return standing

    def clear_spots(
        self, count: int, radius_m: float, taken: Sequence[Disc], rng: np.random.Generator
    ) -> list[tuple[float, float]]:
        """Find places on the floor for more things, such as other tagged parts.

        Args:
            count: How many.
            radius_m: Radius of each [m].
            taken: Discs to keep out of: x, y and radius [m].
            rng: Source of the places.

        Raises:
            SceneError: If one of them finds no room.
        """
        used, found = list(taken), []
        for _ in range(count):
            found.append(self._spot(radius_m, used, rng, "thing"))
            used.append((*found[-1], radius_m))
        return found

    def _hiding(
        self, part_m: Sequence[float] | None, reader_m: Sequence[float] | None, rng: np.random.Generator
    ) -> list[Obstacle]:
        needs = {"part_m": (self.between or self.over_part, part_m), "reader_m": (self.between, reader_m)}
        for key, (wanted, place) in needs.items():
            if wanted is not None and place is None:
                raise SceneError(f"{self.name}: {key} is needed to hide the part", key=key)
        hiding: list[Obstacle] = []
        if self.between is not None and part_m is not None and reader_m is not None:
            (x, y), (u, v) = _xy(reader_m), _xy(part_m)
            hiding += self.between.at((x + u) / 2, (y + v) / 2, np.arctan2(v - y, u - x), self.between.name)
        if self.over_part is not None and part_m is not None:
            hiding += self.over_part.at(*_xy(part_m), rng.uniform(-np.pi, np.pi), self.over_part.name)
        return hiding

    def _spot(self, radius_m: float, taken: Sequence[Disc], rng: np.random.Generator, what: str) -> tuple[float, float]:
        if self.base.room is None:
            raise SceneError(f"{self.name}: there is no room to place a {what} in", key="room")
        size_m = self.base.room.size_m[:2]
        if (size_m <= 2 * radius_m).any():
            raise SceneError(f"{self.name}: a {what} is larger than the room", key=what, radius_m=radius_m)
        discs = np.array(taken, dtype=np.float64).reshape(-1, 3)
        for _ in range(_TRIES):
            point = rng.uniform(radius_m, size_m - radius_m)
            if (np.hypot(*(discs[:, :2] - point).T) >= discs[:, 2] + radius_m).all():
                return float(point[0]), float(point[1])
        raise SceneError(f"{self.name}: no room for a {what} among {len(discs)} things", key=what, radius_m=radius_m)


def _xy(place: Sequence[float] | FloatArray) -> tuple[float, float]:
    return float(place[0]), float(place[1])


def _radius(obstacle: Obstacle) -> float:
    return float(np.hypot(*(np.diff(obstacle.bounds_m, axis=0)[0, :2] / 2)))
