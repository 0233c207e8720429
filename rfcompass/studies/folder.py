"""The folder of a run: `study.json` says whose rows lie in `rows/`."""

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import pyarrow as pa

from rfcompass.errors import StudyError
from rfcompass.files import write_text_atomic
from rfcompass.studies.compaction import remove_replaced
from rfcompass.studies.rows import read_shards, set_aside_partial_shards, sorted_rows
from rfcompass.studies.study import Study
from rfcompass.studies.versions import software_versions

SCHEMA = "rfcompass-study/1"
MANIFEST = "study.json"
ROWS = "rows"

# What must agree for two runs to share a folder; seeds may be added later.
_IDENTITY = ("schema", "name", "kind", "factors", "metrics")


def open_folder(study: Study, seeds: Sequence[int], out: Path, *, resume: bool) -> Path:
    """Prepare a folder for rows of this study and return the folder of its shards.

    Args:
        study: Study to run.
        seeds: Seeds that are asked for.
        out: Folder; made if it is not there.
        resume: Go on with the rows that are there; a folder that is empty or absent is started.

    Raises:
        StudyError: If the folder holds another study or other things, or rows that `resume` was not asked for.
    """
    if not out.is_dir() and out.exists():
        raise StudyError(f"{out} is a file, not a folder", out=str(out))
    if (out / MANIFEST).exists():
        _check_same_study(study, read_manifest(out), out)
        if not resume:
            raise StudyError(f"{out} holds rows of study {study.name} already: resume it or name another folder")
    elif out.exists() and any(not _is_draft(path) for path in out.iterdir()):
        raise StudyError(f"{out} is not empty and holds no study", out=str(out))
    (out / ROWS).mkdir(parents=True, exist_ok=True)
    for draft in filter(_is_draft, [*out.iterdir(), *(out / ROWS).iterdir()]):
        draft.unlink()
    set_aside_partial_shards(out / ROWS)
    remove_replaced(out / ROWS)
    text = json.dumps(_manifest(study, seeds), indent=2, ensure_ascii=False) + "\n"
    write_text_atomic(out / MANIFEST, text)
    return out / ROWS


def read_rows(out: Path | str, study: Study | None = None) -> pa.Table:
    """Read all rows of a run as one table, in the order (cell, seed).

    Args:
        out: Folder of the run.
        study: Study that the rows must belong to; any if None.

    Raises:
        StudyError: If the folder holds no study, another one, no row yet, or a trial twice.
    """
    manifest = read_manifest(Path(out))
    if study is not None:
        _check_same_study(study, manifest, Path(out))
    tables = list(read_shards(Path(out) / ROWS))
    if not tables:
        raise StudyError(f"{out} holds no rows yet", out=str(out))
    return sorted_rows(tables)


def read_manifest(out: Path) -> dict[str, Any]:
    """Read `study.json`.

    Raises:
        StudyError: If there is none, or it is no manifest of ours.
    """
    path = out / MANIFEST
    try:
        manifest = json.loads(path.read_text(encoding="utf-8"))
    except FileNotFoundError as error:
        raise StudyError(f"{out} holds no study: there is no {MANIFEST}", file=str(path)) from error
    except ValueError as error:
        raise StudyError(f"{path} is not JSON: {error}", file=str(path)) from error
    if not isinstance(manifest, dict) or manifest.get("schema") != SCHEMA:
        raise StudyError(f"{path} is not of schema {SCHEMA}", file=str(path), expected=SCHEMA)
    return manifest


def _manifest(study: Study, seeds: Sequence[int]) -> dict[str, Any]:
    return {
        "schema": SCHEMA,
        "name": study.name,
        "title": study.title,
        "kind": study.kind,
        "factors": {name: list(values) for name, values in study.factors.items()},
        "metrics": {metric.name: metric.column for metric in study.metrics},
        "seeds": _seeds(seeds),
        "versions": software_versions(),
    }


def _seeds(seeds: Sequence[int]) -> dict[str, int | list[int]]:
    if isinstance(seeds, range):
        return {"start": seeds.start, "stop": seeds.stop, "step": seeds.step}
    return {"listed": list(seeds)}


def _check_same_study(study: Study, found: dict[str, Any], out: Path) -> None:
    asked = _manifest(study, study.seeds)
    different = [key for key in _IDENTITY if json.dumps(found.get(key)) != json.dumps(asked[key])]  # order counts
    if different:
        raise StudyError(
            f"{out} holds study {found.get('name')!r}, not {study.name!r}; {', '.join(different)} differ",
            out=str(out),
            different=different,
        )


def _is_draft(path: Path) -> bool:
    return path.name.startswith(".") and path.name.endswith(".tmp")
