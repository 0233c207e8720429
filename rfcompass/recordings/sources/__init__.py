"""Sources of reads: traces, sequences, and live readers over LLRP (extra `llrp`)."""

from typing import TYPE_CHECKING

from rfcompass.errors import MissingExtra
from rfcompass.lazy import lazy_names
from rfcompass.recordings.sources.replay import Pace, SequenceSource, TraceSource

if TYPE_CHECKING:
    from rfcompass.recordings.sources.emulated_reader import EmulatedReader
    from rfcompass.recordings.sources.llrp_session import InventorySettings, ReaderInfo
    from rfcompass.recordings.sources.llrp_source import Backoff, LlrpSource

__all__ = [
    "Backoff",
    "EmulatedReader",
    "InventorySettings",
    "LlrpSource",
    "Pace",
    "ReaderInfo",
    "SequenceSource",
    "TraceSource",
]

_load, __dir__ = lazy_names(
    __name__,
    {
        "Backoff": "llrp_source",
        "EmulatedReader": "emulated_reader",
        "InventorySettings": "llrp_session",
        "LlrpSource": "llrp_source",
        "ReaderInfo": "llrp_session",
    },
)


def __getattr__(name: str) -> object:
    try:
        return _load(name)
    except ModuleNotFoundError as cause:
        if cause.name is None or not cause.name.startswith("llrpkit"):
            raise
        message = f"{name} needs llrpkit, which is not installed: pip install 'rfcompass[llrp]'"
        raise MissingExtra(message, extra="llrp", name=name) from cause
