"""Which software computed a row."""

import functools
import platform
from importlib.metadata import PackageNotFoundError, version

_PACKAGES = ("rfcompass", "numpy", "scipy", "numba")


@functools.cache
def software_versions() -> str:
    """Return the versions of Python and of what decides about numbers, in one line."""
    packages = ", ".join(f"{name} {_version(name)}" for name in _PACKAGES)
    return f"{packages}, Python {platform.python_version()}, {platform.system()} {platform.machine()}"


def _version(name: str) -> str:
    try:
        return version(name)
    except PackageNotFoundError:
        return "uninstalled"
