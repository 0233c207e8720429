"""Whole numbers: counts and seeds."""

import numpy as np

from rfcompass.errors import InputError


def check_count(value: object, name: str, least: int = 0) -> None:
    """Check that a value is a whole number, from `least` on.

    Raises:
        InputError: If it is anything else.
    """
    if isinstance(value, bool) or not isinstance(value, int | np.integer) or value < least:
        raise InputError(f"{name}: {value!r} is no whole number from {least} on", name=name, got=value)
