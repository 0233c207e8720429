"""Where the files are that a URDF names: `package://`, `file://` and plain paths, and the robots extra."""

import re
from collections.abc import Iterable, Iterator, Sequence
from functools import cache
from importlib.metadata import PackageNotFoundError, distribution
from pathlib import Path
from urllib.parse import unquote

from rfcompass.errors import RobotModelError

EXTRA = "example-robot-data"

_SCHEME = re.compile(r"(\w+)://(.*)", re.DOTALL)
_PACKAGE_NAME = re.compile(r"<name>\s*([^<\s]+)\s*</name>")


@cache
def extra_folder() -> Path | None:
    """Folder of the robots extra (`pip install rfcompass[robots]`), or None if it is not installed.

    The package ships data only and no Python module, hence the search among its files.
    """
    try:
        listed = distribution(EXTRA).files or ()
    except PackageNotFoundError:
        return None
    manifest = next((file for file in listed if file.match(f"{EXTRA}/package.xml")), None)
    return None if manifest is None else Path(str(manifest.locate())).resolve().parent


def resolve(uri: str, urdf: Path, package_dirs: Sequence[Path] = ()) -> Path:
    """Find a file that a URDF names; it need not exist.

    Args:
        uri: `package://name/file`, `file:///file`, or a path relative to the URDF.
        urdf: File that names it; its parent folders are searched for packages.
        package_dirs: Packages, or folders that hold packages, searched first.

    Raises:
        RobotModelError: If the package is nowhere, or the kind of address is not known.
    """
    match = _SCHEME.fullmatch(uri)
    if match is None:
        return urdf.parent / uri
    scheme, rest = match.groups()
    if scheme == "file":
        return Path(unquote(rest))
    if scheme != "package":
        raise RobotModelError(f"{uri}: {scheme}:// is not known (package://, file:// and paths are)", uri=uri)
    name, _, inside = rest.partition("/")
    return _find_package(name, urdf, package_dirs, uri) / inside


def _find_package(name: str, urdf: Path, package_dirs: Sequence[Path], uri: str) -> Path:
    folders = [*package_dirs, *urdf.resolve().parents]
    if (extra := extra_folder()) is not None:
        folders.append(extra)
    if name and (found := next(_matches(name, folders), None)) is not None:
        return found
    message = f"{uri}: no package {name!r} beside {urdf} or in {[str(folder) for folder in package_dirs]}"
    raise RobotModelError(message, uri=uri, package=name)


def _matches(name: str, folders: Iterable[Path]) -> Iterator[Path]:
    for folder in folders:
        if folder.name == name or _manifest_name(folder) == name:
            yield folder
        elif (folder / name).is_dir():
            yield folder / name


def _manifest_name(folder: Path) -> str | None:
    """Name that a folder's `package.xml` gives it."""
    try:
        match = _PACKAGE_NAME.search((folder / "package.xml").read_text(encoding="utf-8", errors="replace"))
    except OSError:
        return None
    return None if match is None else match.group(1)
