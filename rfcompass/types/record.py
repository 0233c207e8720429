"""Base of all records: they come back from a pickle through their constructor."""

from collections.abc import Mapping
from dataclasses import fields
from types import MappingProxyType
from typing import Any


class Record:
    """Mixin for frozen, slotted dataclasses that hold read-only arrays or mappings.

    A plain pickle would drop the read-only flag of arrays and cannot hold mapping proxies, so a record is
    pickled as its constructor arguments and checked again when it is loaded.
    """

    __slots__ = ()

    def __reduce__(self) -> tuple[Any, tuple[Any, ...]]:
        """Pickle as a call of the constructor."""
        values = {field.name: _plain(getattr(self, field.name)) for field in fields(self)}  # type: ignore[arg-type]
        return _made_of, (type(self), values)


def frozen_mapping(mapping: Mapping[Any, Any]) -> Mapping[Any, Any]:
    """Return a read-only copy of a mapping, for a record's field."""
    return MappingProxyType(dict(mapping))


def _made_of(kind: type[Any], values: dict[str, Any]) -> Any:  # noqa: ANN401 - a record of that kind
    """By names: some records take no positional arguments."""
    return kind(**values)


def _plain(value: Any) -> Any:  # noqa: ANN401 - a field holds anything
    if isinstance(value, Mapping):
        return {key: _plain(item) for key, item in value.items()}
    return value
