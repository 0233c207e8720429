"""A depth image of one's own camera, from a file of arrays."""

import zipfile
import zlib
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rfcompass.errors import InputError

if TYPE_CHECKING:
    from rfcompass.types import DepthView

_NEEDED = ("intrinsics", "T_world_camera")
# What numpy and its unpacking raise for files that are cut off, damaged, locked, or claim to be of any size.
_UNREADABLE = (
    OSError,
    ValueError,
    EOFError,
    zipfile.BadZipFile,
    zlib.error,
    NotImplementedError,
    RuntimeError,
    MemoryError,
)


def read_view(file: Path) -> "DepthView":
    """Read an image from an `.npz` file.

    It holds `depth_m`, or `depth_mm` as most cameras give it, shape (H, W), with 0 or NaN where nothing was seen;
    `intrinsics` [pixel], shape (3, 3); `T_world_camera`, shape (4, 4); and if there is one, `colour`, 0 to 255, shape
    (H, W, 3).

    Raises:
        InputError: If there is no such file, it is no `.npz` file, or an array is missing or not of numbers; carries
            `file`.
        ShapeError: If the arrays are no image, as `DepthView` has it.
    """
    import numpy as np

    from rfcompass.mapping import clean_depth_m
    from rfcompass.types import DepthView

    arrays = _arrays(file)
    depths = [name for name in ("depth_m", "depth_mm") if name in arrays]
    missing = [name for name in _NEEDED if name not in arrays]
    if len(depths) != 1 or missing:
        message = f"{file}: holds {', '.join(arrays) or 'nothing'}; wanted: depth_m or depth_mm, {', '.join(_NEEDED)}"
        raise InputError(message, file=str(file), found=list(arrays))
    numbers = {}
    for name in (*depths, *_NEEDED):
        if (array := arrays[name]).dtype.kind not in "iuf":
            raise InputError(f"{file}: {name} is of {array.dtype}, not of numbers", file=str(file), name=name)
        numbers[name] = np.asarray(array, dtype=np.float64)
    colour = arrays.get("colour")
    if colour is not None and (colour.dtype.kind not in "iu" or colour.size == 0):
        message = f"{file}: colour is of {colour.dtype}, not of whole numbers from 0 to 255"
        raise InputError(message, file=str(file), name="colour")
    depth_m = clean_depth_m(numbers[depths[0]]) / (1000.0 if depths[0] == "depth_mm" else 1.0)
    colour = None if colour is None else colour.astype(np.int64)
    return DepthView(depth_m, numbers["intrinsics"], numbers["T_world_camera"], colour)


def _arrays(file: Path) -> dict[str, Any]:
    import numpy as np

    try:
        # Opened here: numpy leaves a file open that it cannot read.
        with file.open("rb") as stream:
            stored = np.load(stream, allow_pickle=False)
            return dict(stored) if isinstance(stored, np.lib.npyio.NpzFile) else {"one array": stored}
    except FileNotFoundError as error:
        raise InputError(f"{file}: no such file", file=str(file)) from error
    except _UNREADABLE as error:
        raise InputError(f"{file}: no .npz file that can be read: {error}", file=str(file)) from error
