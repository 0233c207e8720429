"""A value inside a JSON document that knows the way to itself, so that every defect can be named."""

import json
import math
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

from rfcompass.errors import InputError, PartError


@dataclass(frozen=True, slots=True)
class Node:
    """One value of a JSON document.

    Attributes:
        value: What json.loads made of it.
        file: Name of the document, for errors.
        key: Way to the value, for example `parts[0].shape.size_m`; empty for the document itself.
    """

    value: Any
    file: str
    key: str = ""

    def defect(self, message: str) -> PartError:
        """Build the error for a defect of this value."""
        place = f"{self.file}, key {self.key}" if self.key else self.file
        return PartError(f"{place}: {message}", file=self.file, key=self.key)

    def fields(self, required: Sequence[str], optional: Sequence[str] = ()) -> dict[str, "Node"]:
        """Return the values of an object by name.

        Raises:
            PartError: If it is no object, if a required key is missing, or if there are others.
        """
        if not isinstance(self.value, dict):
            raise self.defect(f"{_shown(self.value)} is no object")
        for name in required:
            if name not in self.value:
                raise self._at(name).defect("is missing")
        for name in self.value:
            if name not in (*required, *optional):
                raise self._at(name).defect(f"is unknown here (known: {', '.join((*required, *optional))})")
        return {name: self._at(name, value) for name, value in self.value.items()}

    def entries(self) -> dict[str, "Node"]:
        """Return the values of an object whose keys are free.

        Raises:
            PartError: If it is no object.
        """
        if not isinstance(self.value, dict):
            raise self.defect(f"{_shown(self.value)} is no object")
        return {name: self._at(name, value) for name, value in self.value.items()}

    def items(self) -> list["Node"]:
        """Return the values of a list.

        Raises:
            PartError: If it is no list.
        """
        if not isinstance(self.value, list):
            raise self.defect(f"{_shown(self.value)} is no list")
        return [Node(value, self.file, f"{self.key}[{i}]") for i, value in enumerate(self.value)]

    def text(self) -> str:
        """Return a text.

        Raises:
            PartError: If it is none.
        """
        if not isinstance(self.value, str):
            raise self.defect(f"{_shown(self.value)} is no text")
        return self.value

    def flag(self) -> bool:
        """Return true or false.

        Raises:
            PartError: If it is neither.
        """
        if not isinstance(self.value, bool):
            raise self.defect(f"{_shown(self.value)} is neither true nor false")
        return self.value

    def number(self) -> float:
        """Return a finite number.

        Raises:
            PartError: If it is none.
        """
        number = _as_float(self.value)
        if number is None:
            raise self.defect(f"{_shown(self.value)} is no finite number")
        return number

    def numbers(self) -> list[float]:
        """Return a list of finite numbers.

        Raises:
            PartError: If it is none.
        """
        return [item.number() for item in self.items()]

    def rows(self) -> list[list[float]]:
        """Return a list of lists of finite numbers, all of the same length.

        Raises:
            PartError: If it is none.
        """
        rows = [item.numbers() for item in self.items()]
        if len({len(row) for row in rows}) > 1:
            raise self.defect("its rows differ in length")
        return rows

    def integer_rows(self) -> list[list[int]]:
        """Return a list of lists of integers.

        Raises:
            PartError: If it is none.
        """
        return [[item._integer() for item in row.items()] for row in self.items()]

    @contextmanager
    def naming(self) -> Iterator[None]:
        """Add file and key to what a record has to say about values from here."""
        try:
            yield
        except InputError as error:
            if "file" in error.numbers:
                raise
            place = f"{self.file}, key {self.key}" if self.key else self.file
            numbers = {**error.numbers, "file": self.file, "key": self.key}
            raise type(error)(f"{place}: {error.message}", **numbers) from error

    def _integer(self) -> int:
        if isinstance(self.value, bool) or not isinstance(self.value, int) or not abs(self.value) < 2**63:
            raise self.defect(f"{_shown(self.value)} is no integer")
        return self.value

    def _at(self, name: str, value: object = None) -> "Node":
        return Node(value, self.file, f"{self.key}.{name}" if self.key else name)


def parse_document(text: str, file: str) -> Node:
    """Read a JSON document.

    Raises:
        PartError: If it is no JSON, holds NaN or infinity, or names a key twice in one object.
    """
    try:
        return Node(json.loads(text, parse_constant=_reject_constant, object_pairs_hook=_reject_twins), file)
    except (ValueError, RecursionError) as cause:
        raise PartError(f"{file}: is no JSON: {cause}", file=file) from cause


def _reject_constant(name: str) -> float:
    raise ValueError(f"{name} is no JSON number")


def _reject_twins(pairs: list[tuple[str, object]]) -> dict[str, object]:
    content = dict(pairs)
    if len(content) < len(pairs):
        raise ValueError(f"a key stands twice in one object: {[name for name, _ in pairs]}")
    return content


def _as_float(value: object) -> float | None:
    if isinstance(value, bool) or not isinstance(value, int | float):
        return None
    try:
        number = float(value)
    except OverflowError:
        return None
    return number if math.isfinite(number) else None


def _shown(value: object) -> str:
    text = repr(value)
    return text if len(text) <= 60 else f"{text[:57]}..."
