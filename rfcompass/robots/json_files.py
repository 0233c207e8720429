"""JSON files of robots and tag layouts, with errors that name the file and the key."""

import json
from pathlib import Path
from typing import Any

import numpy as np

from rfcompass.arrays import FloatArray
from rfcompass.errors import RobotModelError


class JsonFile:
    """One JSON object on disk, read key by key; every error names the file.

    Args:
        path: Where it lies.
        schema: What its key `schema` must say.

    Raises:
        RobotModelError: If the file cannot be read, is no JSON object, or is of another schema.
    """

    def __init__(self, path: Path, schema: str) -> None:
        self.path = path
        try:
            content = json.loads(path.read_text(encoding="utf-8"))
        except OSError as cause:
            raise self.error(f"cannot be read: {cause.strerror}") from cause
        except (ValueError, RecursionError) as cause:
            raise self.error(f"is no JSON: {cause}") from cause
        if not isinstance(content, dict) or content.get("schema") != schema:
            raise self.error(f'is no object with "schema": "{schema}"', key="schema")
        self._content: dict[str, Any] = content

    def error(self, message: str, **numbers: object) -> RobotModelError:
        """Build the error for one defect of the file."""
        return RobotModelError(f"{self.path}: {message}", file=str(self.path), **numbers)

    def text(self, key: str, default: str | None = None) -> str:
        """A string; required if there is no default."""
        return str(self._typed(self._content, key, str, default))

    def mapping(self, key: str) -> dict[str, Any]:
        """An object; empty if the key is absent."""
        return dict(self._typed(self._content, key, dict, {}))

    def texts(self, key: str) -> list[str]:
        """A list of strings; empty if the key is absent."""
        values = self._typed(self._content, key, list, [])
        if not all(isinstance(value, str) for value in values):
            raise self.error(f"{key} holds something that is no string", key=key)
        return list(values)

    def objects(self, key: str) -> list[dict[str, Any]]:
        """A list of objects."""
        values = self._typed(self._content, key, list, None)
        if not all(isinstance(value, dict) for value in values):
            raise self.error(f"{key} holds something that is no object", key=key)
        return list(values)

    def vector(self, key: str, default: tuple[float, float, float]) -> FloatArray:
        """Three finite numbers, shape (3,)."""
        return self.vector_of(self._content if key in self._content else {key: default}, key)

    def number(self, key: str, default: float) -> float:
        """A number."""
        return float(self._typed(self._content, key, (int, float), default))

    def text_of(self, entry: dict[str, Any], key: str) -> str:
        """A string inside an object of this file."""
        return str(self._typed(entry, key, str, None))

    def vector_of(self, entry: dict[str, Any], key: str) -> FloatArray:
        """Three finite numbers inside an object of this file, shape (3,)."""
        values = list(self._typed(entry, key, (list, tuple), None))
        if len(values) != 3 or not all(isinstance(value, int | float) and abs(value) < 1e300 for value in values):
            raise self.error(f"{key} is {values}, not three finite numbers", key=key)
        return np.array(values, dtype=np.float64)

    def _typed(self, entry: dict[str, Any], key: str, kind: type | tuple[type, ...], default: object) -> Any:  # noqa: ANN401
        value = entry.get(key, default)
        if value is None:
            raise self.error(f"{key} is missing", key=key)
        if not isinstance(value, kind):
            raise self.error(f"{key} is of type {type(value).__name__}", key=key)
        return value
