"""Whether two records hold the same, to the last bit."""

import dataclasses
from collections.abc import Mapping

import numpy as np


def differences(one, other, where="it"):
    """Where two values differ; records, mappings and sequences are looked into, NaN equals NaN."""
    if type(one) is not type(other):
        return [f"{where}: {type(one).__name__} and {type(other).__name__}"]
    if dataclasses.is_dataclass(one):
        pairs = {f.name: (getattr(one, f.name), getattr(other, f.name)) for f in dataclasses.fields(one)}
    elif isinstance(one, Mapping):
        if list(one) != list(other):
            return [f"{where}: keys {list(one)} and {list(other)}"]
        pairs = {key: (one[key], other[key]) for key in one}
    elif isinstance(one, tuple | list):
        if len(one) != len(other):
            return [f"{where}: {len(one)} and {len(other)} entries"]
        pairs = dict(enumerate(zip(one, other, strict=True)))
    else:
        same = np.array_equal(one, other, equal_nan=True) if isinstance(one, np.ndarray) else _same(one, other)
        return [] if same else [f"{where}: {one!r} and {other!r}"]
    return [found for key, (a, b) in pairs.items() for found in differences(a, b, f"{where}.{key}")]


def _same(one, other):
    return one == other or (isinstance(one, float) and np.isnan(one) and np.isnan(other))
