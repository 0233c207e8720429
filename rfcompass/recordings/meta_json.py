"""`meta.json`: reading and writing the record of a trace's conventions."""

import json
from collections.abc import Mapping
from typing import Any

from rfcompass.errors import TraceError
from rfcompass.recordings.defects import defect
from rfcompass.recordings.trace_meta import META_FILE, TraceMeta, TraceTag, Vector

SCHEMA = "rfcompass-trace/1"

_KEYS = ("frame", "geometry", "phase_sign", "phase_modulus", "dimensions")
_OPTIONAL_KEYS = ("source", "license", "reader", "robot", "tag_layout")
_TAG_KEYS = ("epc", "body", "link")
_TAG_VECTORS = ("point_m", "dipole")


def parse_meta(text: str) -> TraceMeta:
    """Read the text of a `meta.json`.

    Raises:
        TraceError: If it is no JSON, of another schema, incomplete or impossible.
    """
    content = _parse_json(text)
    if (schema := content.pop("schema", None)) != SCHEMA:
        raise defect(META_FILE, f"schema is {schema!r}, expected {SCHEMA!r}", column="schema", schema=schema)
    for key in (*_KEYS, "tags"):
        if key not in content:
            raise defect(META_FILE, "is missing", column=key)
    values = {key: content.pop(key) for key in (*_KEYS, *_OPTIONAL_KEYS) if key in content}
    tags = _parse_tags(content.pop("tags"))
    offsets = _parse_offsets(content.pop("channel_offsets_rad", {}))
    return TraceMeta(**values, tags=tags, channel_offsets_rad=offsets, unknown_json=_canonical(content))


def is_trace_meta(text: str) -> bool:
    """True if the text is a JSON object of our schema, whatever else may be wrong with it."""
    try:
        return bool(_parse_json(text).get("schema") == SCHEMA)
    except TraceError:
        return False


def _parse_json(text: str) -> dict[str, Any]:
    try:
        content = json.loads(text, parse_constant=_reject_constant)
    except (ValueError, RecursionError) as cause:
        raise defect(META_FILE, f"is no JSON: {cause}") from cause
    if not isinstance(content, dict):
        raise defect(META_FILE, f"holds a {type(content).__name__}, not an object")
    return content


def _reject_constant(name: str) -> float:
    raise ValueError(f"{name} is no JSON number")


def _parse_tags(entries: object) -> tuple[TraceTag, ...]:
    if not isinstance(entries, list):
        raise defect(META_FILE, f"{type(entries).__name__} is no list", column="tags")
    return tuple(_parse_tag(entry, row) for row, entry in enumerate(entries))


def _parse_tag(entry: object, row: int) -> TraceTag:
    if not isinstance(entry, dict) or "epc" not in entry:
        raise defect(META_FILE, "a tag must be an object with an epc", column="tags", row=row)
    content = dict(entry)
    texts = {key: content.pop(key, None) for key in _TAG_KEYS}
    point_m, dipole = (_parse_vector(key, content.pop(key, None), row) for key in _TAG_VECTORS)
    return TraceTag(**texts, point_m=point_m, dipole=dipole, unknown_json=_canonical(content))


def _parse_vector(key: str, value: object, row: int) -> Vector | None:
    if value is None:
        return None
    numbers = [_as_number(entry) for entry in value] if isinstance(value, list) else []
    if len(numbers) != 3 or None in numbers:
        raise defect(META_FILE, f"{value!r} is no list of three finite numbers", column=key, row=row)
    x, y, z = (float(number) for number in numbers if number is not None)
    return x, y, z


def _parse_offsets(value: object) -> tuple[tuple[float, float], ...]:
    column = "channel_offsets_rad"
    if not isinstance(value, dict):
        raise defect(META_FILE, "must be an object {frequency in Hz: radians}", column=column)
    pairs = []
    for text, entry in value.items():
        freq_hz, offset_rad = _text_as_number(text), _as_number(entry)
        if freq_hz is None or offset_rad is None:
            raise defect(META_FILE, f"{text!r}: {entry!r} is no frequency in Hz with radians", column=column)
        pairs.append((freq_hz, offset_rad))
    return tuple(pairs)


def _text_as_number(text: str) -> float | None:
    try:
        return float(text)
    except ValueError:
        return None


def _as_number(value: object) -> float | None:
    if isinstance(value, bool) or not isinstance(value, int | float) or not abs(value) < 1e300:
        return None
    return float(value)


def _canonical(content: Mapping[str, object]) -> str:
    return json.dumps(content, sort_keys=True)


def meta_json(meta: TraceMeta) -> str:
    """Write a `meta.json`; equal records give equal text. Values that are None or empty are left out."""
    content: dict[str, object] = {"schema": SCHEMA}
    content |= {key: getattr(meta, key) for key in ("source", "license", "reader", *_KEYS)}
    content |= {key: value for key in ("robot", "tag_layout") if (value := getattr(meta, key)) is not None}
    content["tags"] = [_tag_content(tag) for tag in meta.tags]
    if meta.channel_offsets_rad:
        content["channel_offsets_rad"] = {f"{freq_hz:.17g}": offset for freq_hz, offset in meta.channel_offsets_rad}
    return json.dumps(_with_unknown(content, meta.unknown_json), indent=1) + "\n"


def _tag_content(tag: TraceTag) -> dict[str, object]:
    known = {key: value for key in (*_TAG_KEYS, *_TAG_VECTORS) if (value := getattr(tag, key)) is not None}
    return _with_unknown(known, tag.unknown_json)


def _with_unknown(known: dict[str, object], unknown_json: str) -> dict[str, object]:
    return known | {key: value for key, value in json.loads(unknown_json).items() if key not in known}
