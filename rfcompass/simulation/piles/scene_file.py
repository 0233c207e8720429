"""Pile scenes as files; schema `rfcompass-pile/1`.

A file holds the scene to the last bit, so that it is the same on every machine, its hash, and what made it: the same
seed gives the same bits only with the same versions of MuJoCo and numpy, on one kind of processor.
"""

import json
import platform
from collections.abc import Mapping
from dataclasses import fields
from pathlib import Path
from typing import Any

import numpy as np

from rfcompass.errors import PileChanged, PileError, ShapeError
from rfcompass.files import write_text_atomic
from rfcompass.simulation.piles.engine import PilePhysics, load_mujoco
from rfcompass.simulation.piles.families import PileFamily
from rfcompass.simulation.piles.generation import make_pile
from rfcompass.simulation.piles.items import PileItem
from rfcompass.simulation.piles.scene import PileScene

SCHEMA = "rfcompass-pile/1"


def write_pile(scene: PileScene, path: str | Path) -> None:
    """Write a scene with its hash, atomically."""
    content = {"schema": SCHEMA, "sha256": scene.fingerprint, "made_with": _versions(), **scene.contents}
    write_text_atomic(Path(path), json.dumps(content, indent=1, allow_nan=False) + "\n")


def open_pile(path: str | Path) -> PileScene:
    """Read a scene as it was written; needs no MuJoCo.

    Raises:
        PileError: If there is no such file, it breaks the schema, or its contents do not fit its hash.
    """
    content = _read(Path(path))
    try:
        scene = _scene(content)
    except (PileError, ShapeError) as error:
        raise PileError(f"{path}: {error.message}", **{**error.numbers, "file": str(path)}) from error
    except (KeyError, TypeError, ValueError, AttributeError) as cause:
        raise PileError(f"{path}: a key is missing or ill-typed: {cause}", file=str(path)) from cause
    if (stored := content.get("sha256")) != scene.fingerprint:
        message = f"{path}: its contents have the hash {scene.fingerprint[:12]}, not the {str(stored)[:12]} it states"
        raise PileError(message, file=str(path), key="sha256", got=stored, expected=scene.fingerprint)
    return scene


def remake_pile(path: str | Path, of_family: PileFamily | None = None) -> PileScene:
    """Make the scene of a file anew from its seed, and check that it is the same.

    Args:
        path: The file.
        of_family: Its family, if it is none that is shipped.

    Raises:
        PileError: If the file cannot be read, or its family is unknown.
        NoPile: If its seed gives no scene any more.
        PileChanged: If its seed gives another scene; carries both hashes and both sets of versions.
    """
    stored = open_pile(path)
    kind = stored.family if of_family is None else of_family
    made = make_pile(kind, stored.seed, stored.target_class, most_tries=stored.tries, physics=stored.physics)
    if made.fingerprint != stored.fingerprint:
        then, now = _read(Path(path)).get("made_with"), _versions()
        message = f"{path}: seed {stored.seed} gives {made.fingerprint[:12]} now, not {stored.fingerprint[:12]}"
        raise PileChanged(
            f"{message}; it was made with {then}, this is {now}",
            file=str(path),
            expected=stored.fingerprint,
            got=made.fingerprint,
            made_with=then,
            now=now,
        )
    return made


def _versions() -> dict[str, str]:
    engine = load_mujoco()
    return {"mujoco": engine.__version__, "numpy": np.__version__, "machine": platform.machine()}


def _read(path: Path) -> Mapping[str, Any]:
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
    except OSError as cause:
        raise PileError(f"no pile file {path}: {cause.strerror}", file=str(path)) from cause
    except (ValueError, RecursionError) as cause:
        raise PileError(f"{path}: is no JSON: {cause}", file=str(path)) from cause
    if not isinstance(content, dict) or content.get("schema") != SCHEMA:
        got = content.get("schema") if isinstance(content, dict) else None
        raise PileError(f"{path}: schema is {got!r}, not {SCHEMA!r}", file=str(path), key="schema", got=got)
    return content


def _scene(content: Mapping[str, Any]) -> PileScene:
    entries = content["items"]
    items = tuple(
        PileItem(int(e["number"]), e["kind"], np.array(e["size_m"]), e["material"], tuple(e["rgb"])) for e in entries
    )
    numbers = {field.name for field in fields(PilePhysics)}
    if set(content["physics"]) != numbers:
        raise PileError(f"physics has {sorted(content['physics'])}, not {sorted(numbers)}", key="physics")
    return PileScene(
        family=str(content["family"]),
        seed=int(content["seed"]),
        target_class=str(content["target_class"]),
        items=items,
        states={int(e["number"]): np.array(e["state"]) for e in entries},
        piles={int(e["number"]): int(e["pile"]) for e in entries},
        target=int(content["target"]),
        tries=int(content["tries"]),
        physics=PilePhysics(**content["physics"]),
    )
