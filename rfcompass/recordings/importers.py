"""Importers of foreign logs, by the name that the command line uses."""

from collections.abc import Callable, Mapping
from inspect import signature
from pathlib import Path
from types import MappingProxyType

from rfcompass.errors import InputError
from rfcompass.recordings.adarf import import_adarf
from rfcompass.recordings.itemtest import import_itemtest
from rfcompass.recordings.llrpkit_csv import import_llrpkit
from rfcompass.recordings.sllurp_csv import import_sllurp
from rfcompass.recordings.spool_trace import import_spool
from rfcompass.recordings.trace import Trace

IMPORTERS: Mapping[str, Callable[..., Trace]] = MappingProxyType(
    {
        "adarf": import_adarf,
        "itemtest": import_itemtest,
        "llrpkit": import_llrpkit,
        "sllurp": import_sllurp,
        "spool": import_spool,
    }
)
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


def import_log(kind: str, path: str | Path, **options: object) -> Trace:
    """Run an importer with options, those that are None left out.

    Raises:
        InputError: If there is no such importer, or it knows no such option; lists those that it knows.
    """
    run = importer(kind)
    given = {name: value for name, value in options.items() if value is not None}
    known = [name for name in signature(run).parameters if name != "path"]
    for name in given:
        if name not in known:
            message = f"importer {kind!r} has no use for {name} (it knows: {', '.join(known)})"
            raise InputError(message, kind=kind, option=name, known=known)
    return run(path, **given)
