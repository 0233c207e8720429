"""Recipes as files: those that come with the package, and one's own; schema `rfcompass-recipe/1`."""

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from rfcompass.errors import SceneError
from rfcompass.simulation.scene_recipe import Furniture, ScattererRule, SceneRecipe
from rfcompass.types.scene import Scene
from rfcompass.types.scene_json import JsonObject, materials_from_json, obstacle_from_json, room_from_json

SCHEMA = "rfcompass-recipe/1"
SCENES = ("free_space", "room_los", "room_nlos", "heavy_clutter", "tabletop")

_FOLDER = Path(__file__).parent / "scenes"
_RECIPE = {
    "schema", "name", "room", "materials", "obstacles", "furniture", "scatterers", "between", "over_part", "clear_m",
}  # fmt: skip


def load_recipe(name_or_path: str | Path) -> SceneRecipe:
    """Read a recipe.

    Args:
        name_or_path: One of `SCENES`, or the path of a JSON file.

    Raises:
        SceneError: If there is no such recipe, or the file breaks the schema; names the key and the value.
    """
    path = _FOLDER / f"{name_or_path}.json" if str(name_or_path) in SCENES else Path(name_or_path)
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
    except OSError as cause:
        message = f"no scene {name_or_path}: {cause.strerror}; shipped: {', '.join(SCENES)}"
        raise SceneError(message, file=str(path), known=list(SCENES)) from cause
    except (ValueError, RecursionError) as cause:
        raise SceneError(f"{path}: is no JSON: {cause}", file=str(path)) from cause
    try:
        return recipe_from_json(content)
    except SceneError as error:
        raise SceneError(f"{path}: {error.message}", **{**error.numbers, "file": str(path)}) from error


def recipe_from_json(content: Mapping[str, Any]) -> SceneRecipe:
    """Build a recipe from parsed JSON; see `docs/channel.md`.

    Raises:
        SceneError: If a key is missing, unknown or ill-typed, or a value cannot be.
    """
    top = JsonObject(content, "recipe", _RECIPE)
    if (schema := top.get("schema")) != SCHEMA:
        raise SceneError(f"recipe.schema is {schema!r}, not {SCHEMA!r}", key="recipe.schema", got=schema)
    base = Scene(
        top.text("name"),
        None if top.get("room") is None else room_from_json(top.get("room")),
        tuple(obstacle_from_json(item, f"obstacles[{i}]") for i, item in enumerate(top.items("obstacles"))),
        materials_from_json(top.mapping("materials")),
    )
    furniture = tuple(_furniture(item, f"furniture[{i}]") for i, item in enumerate(top.items("furniture")))
    between, over_part = (
        None if top.get(key) is None else _furniture(top.get(key), key) for key in ("between", "over_part")
    )
    rule = None if top.get("scatterers") is None else _scatterers(top.get("scatterers"))
    clear_m = top.number("clear_m", 0.6)
    recipe = SceneRecipe(base, furniture, rule, between, over_part, clear_m)
    for kind in (*furniture, *filter(None, (between, over_part))):
        base.with_obstacles(kind.parts)  # its materials must be known
    return recipe


def _furniture(content: object, where: str) -> Furniture:
    entry = JsonObject(content, where, {"name", "count", "parts"})
    parts = tuple(obstacle_from_json(item, f"{where}.parts[{i}]") for i, item in enumerate(entry.items("parts")))
    count = entry.number("count", 1.0)
    if not parts or count < 0 or count != int(count):
        raise SceneError(f"{where}: needs parts and a whole count, got {count:g}", key=where, got=count)
    return Furniture(entry.text("name"), int(count), parts)


def _scatterers(content: object) -> ScattererRule:
    entry = JsonObject(content, "scatterers", {"count", "cross_section_m2", "low_m", "high_m", "part_gap_m"})
    smallest, largest = entry.numbers("cross_section_m2", 2)
    count = entry.number("count")
    if count < 0 or count != int(count):
        raise entry.error("count", count, "a whole number >= 0")
    corners = entry.numbers("low_m", 3), entry.numbers("high_m", 3)
    return ScattererRule(int(count), (float(smallest), float(largest)), *corners, entry.number("part_gap_m", 0.0))
