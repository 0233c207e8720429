"""Importers of foreign logs, by the name that the command line uses."""

from collections.abc import Callable, Mapping
from types import MappingProxyType

from rfcompass.errors import InputError
from rfcompass.recordings.adarf import import_adarf
from rfcompass.recordings.trace import Trace

IMPORTERS: Mapping[str, Callable[..., Trace]] = MappingProxyType({"adarf": import_adarf})
"""Each importer takes a path and, by keyword, what its layout leaves open."""


def importer(kind: str) -> Callable[..., Trace]:
    """Return the importer of a layout.

    Raises:
        InputError: If there is none of that name; lists those that there are.
    """
    if kind not in IMPORTERS:
        known = sorted(IMPORTERS)
        raise InputError(f"no importer {kind!r}; known: {', '.join(known)}", kind=kind, known=known)
    return IMPORTERS[kind]
