"""Scenes as JSON, schema `rfcompass-scene/1`; every defect is an error that names the key and the value."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from rfcompass.arrays import FloatArray
from rfcompass.errors import RfCompassError, SceneError
from rfcompass.types.scene import Material, Obstacle, ObstacleShape, Room, Scene
from rfcompass.types.shapes import Box, Cylinder

SCHEMA = "rfcompass-scene/1"

_SCENE = {"schema", "name", "room", "obstacles", "materials"}
_ROOM = {"size_m", "wall", "floor", "ceiling"}
_MATERIAL = {"permittivity", "loss_db_per_m", "surface_loss_db", "conductor"}
_OBSTACLE = {"name", "box_m", "cylinder_m", "axis", "position_m", "rotation", "yaw_rad", "material", "blocks_base"}


class JsonObject:
    """One JSON object, read key by key; every error names where it stands.

    Args:
        content: The object.
        where: What to call it, for example `"obstacles[2]"`.
        known: Keys that it may have.

    Raises:
        SceneError: If it is no object or has an unknown key.
    """

    def __init__(self, content: object, where: str, known: set[str]) -> None:
        self.where = where
        if not isinstance(content, Mapping):
            raise SceneError(f"{where} is {content!r}, no object", key=where, got=content)
        if unknown := sorted(set(map(str, content)) - known):
            raise SceneError(f"{where} has unknown keys {unknown}; known: {sorted(known)}", key=where, got=unknown)
        self._content = content

    def __contains__(self, key: str) -> bool:
        return key in self._content

    def text(self, key: str) -> str:
        """A string."""
        return str(self._of(key, str, "text"))

    def number(self, key: str, default: float | None = None) -> float:
        """A finite number; required if there is no default."""
        if key not in self._content and default is not None:
            return default
        value = self._of(key, int | float, "number")
        if isinstance(value, bool) or not abs(value) < 1e300:
            raise self.error(key, value, "a finite number")
        return float(value)

    def flag(self, key: str, default: bool) -> bool:
        """True or false."""
        return bool(self._of(key, bool, "true or false")) if key in self._content else default

    def numbers(self, key: str, size: int) -> FloatArray:
        """A list of finite numbers, shape (size,)."""
        values = self._of(key, list | tuple, "list")
        good = [
            isinstance(value, int | float) and not isinstance(value, bool) and abs(value) < 1e300 for value in values
        ]
        if len(values) != size or not all(good):
            raise self.error(key, values, f"a list of {size} finite numbers")
        return np.array(values, dtype=np.float64)

    def items(self, key: str) -> Sequence[Any]:
        """A list; empty if the key is absent."""
        return list(self._of(key, list | tuple, "list")) if key in self._content else []

    def mapping(self, key: str) -> Mapping[str, Any]:
        """An object; empty if the key is absent."""
        return dict(self._of(key, Mapping, "object")) if key in self._content else {}

    def get(self, key: str) -> Any:  # noqa: ANN401 - whatever stands there
        """The value as it stands, None if the key is absent."""
        return self._content.get(key)

    def error(self, key: str, value: object, wanted: str) -> SceneError:
        """Build the error for a value that will not do."""
        return SceneError(f"{self.where}.{key} is {value!r}, not {wanted}", key=f"{self.where}.{key}", got=value)

    def _of(self, key: str, kind: Any, wanted: str) -> Any:  # noqa: ANN401 - a type or a union of types
        if key not in self._content:
            raise SceneError(f"{self.where}.{key} is missing", key=f"{self.where}.{key}")
        value = self._content[key]
        if not isinstance(value, kind):
            raise self.error(key, value, f"a {wanted}" if wanted != "true or false" else wanted)
        return value


def scene_from_json(content: Mapping[str, Any]) -> Scene:
    """Build a scene from parsed JSON.

    Args:
        content: An object of schema `rfcompass-scene/1`, see `docs/channel.md`.

    Raises:
        SceneError: If a key is missing, unknown or ill-typed, or a value cannot be.
    """
    top = JsonObject(content, "scene", _SCENE)
    if (schema := top.get("schema")) != SCHEMA:
        raise SceneError(f"scene.schema is {schema!r}, not {SCHEMA!r}", key="scene.schema", got=schema)
    room = None if top.get("room") is None else room_from_json(top.get("room"))
    obstacles = tuple(obstacle_from_json(item, f"obstacles[{i}]") for i, item in enumerate(top.items("obstacles")))
    return Scene(top.text("name"), room, obstacles, materials_from_json(top.mapping("materials")))


def scene_to_json(scene: Scene) -> dict[str, Any]:
    """Turn a scene into an object that JSON can hold; `scene_from_json` undoes it."""
    room = scene.room and {
        "size_m": scene.room.size_m.tolist(),
        "wall": scene.room.wall_material,
        "floor": scene.room.floor_material,
        "ceiling": scene.room.ceiling_material,
    }
    return {
        "schema": SCHEMA,
        "name": scene.name,
        "room": room,
        "obstacles": [_obstacle_to_json(obstacle) for obstacle in scene.obstacles],
        "materials": {name: _material_to_json(material) for name, material in scene.materials.items()},
    }


def room_from_json(content: object) -> Room:
    """Build the walls from `{"size_m": [x, y, z], "wall": …, "floor": …, "ceiling": …}`."""
    entry = JsonObject(content, "room", _ROOM)
    return Room(entry.numbers("size_m", 3), entry.text("wall"), entry.text("floor"), entry.text("ceiling"))


def materials_from_json(content: Mapping[str, Any]) -> dict[str, Material]:
    """Build materials from `{name: {"permittivity": …, "loss_db_per_m": …, …}}`."""
    found = {}
    for name, item in content.items():
        entry = JsonObject(item, f"materials.{name}", _MATERIAL)
        losses = entry.number("loss_db_per_m", 0.0), entry.number("surface_loss_db", 0.0)
        conductor = entry.flag("conductor", default=False)
        found[name] = Material(name, entry.number("permittivity", 1.0), *losses, conductor)
    return found


def obstacle_from_json(content: object, where: str) -> Obstacle:
    """Build one obstacle; its turn is a `rotation` matrix or a `yaw_rad` about z."""
    entry = JsonObject(content, where, _OBSTACLE)
    T = np.eye(4)
    T[:3, :3] = _rotation(entry)
    T[:3, 3] = entry.numbers("position_m", 3)
    blocks_base = entry.flag("blocks_base", default=True)
    try:
        return Obstacle(entry.text("name"), _shape(entry), T, entry.text("material"), blocks_base)
    except SceneError:
        raise
    except RfCompassError as cause:
        raise SceneError(f"{where}: {cause.message}", key=where, **cause.numbers) from cause


def _rotation(entry: JsonObject) -> FloatArray:
    if "rotation" in entry and "yaw_rad" in entry:
        raise entry.error("yaw_rad", entry.get("yaw_rad"), "to be given beside rotation")
    if "rotation" in entry:
        rows = entry.items("rotation")
        if len(rows) != 3:
            raise entry.error("rotation", rows, "three rows")
        named = [JsonObject({"row": row}, f"{entry.where}.rotation", {"row"}) for row in rows]
        return np.stack([row.numbers("row", 3) for row in named])
    yaw = entry.number("yaw_rad", 0.0)
    return np.array([[np.cos(yaw), -np.sin(yaw), 0.0], [np.sin(yaw), np.cos(yaw), 0.0], [0.0, 0.0, 1.0]])


def _shape(entry: JsonObject) -> ObstacleShape:
    if ("box_m" in entry) == ("cylinder_m" in entry):
        raise SceneError(f"{entry.where} needs either box_m or cylinder_m", key=f"{entry.where}.box_m")
    if "box_m" in entry:
        return Box(entry.numbers("box_m", 3))
    radius_m, length_m = entry.numbers("cylinder_m", 2)
    return Cylinder(float(radius_m), float(length_m), entry.text("axis") if "axis" in entry else "z")


def _obstacle_to_json(obstacle: Obstacle) -> dict[str, Any]:
    shape = obstacle.shape
    if isinstance(shape, Box):
        size: dict[str, Any] = {"box_m": shape.size_m.tolist()}
    else:
        size = {"cylinder_m": [shape.radius_m, shape.length_m], "axis": shape.axis}
    return {
        "name": obstacle.name,
        **size,
        "position_m": obstacle.T_scene_obstacle[:3, 3].tolist(),
        "rotation": obstacle.T_scene_obstacle[:3, :3].tolist(),
        "material": obstacle.material,
        "blocks_base": obstacle.blocks_base,
    }


def _material_to_json(material: Material) -> dict[str, Any]:
    return {key: getattr(material, key) for key in sorted(_MATERIAL)}
