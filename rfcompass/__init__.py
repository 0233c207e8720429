"""RFID-guided manipulation: the open reference implementation of RF-Compass and FuseBot.

The public names below load on first use, so that `import rfcompass` costs nothing.
Start reading at `rfcompass/interfaces.py`.
"""

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rfcompass.geometry.pose2 import Pose2 as Pose2

_HOME = {
    "Pose2": "rfcompass.geometry.pose2",
}

__all__ = [
    "Pose2",
]


def __getattr__(name: str) -> object:
    """Import a public name from the module that defines it."""
    if name not in _HOME:
        raise AttributeError(f"module 'rfcompass' has no attribute {name!r}; it has: {', '.join(__all__)}")
    return getattr(import_module(_HOME[name]), name)


def __dir__() -> list[str]:
    """List the public names for completion."""
    return __all__
