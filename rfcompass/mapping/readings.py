"""How the kernels of [Boroushaki2023] are read: as printed they cannot be meant, and units decide how wide they are.

`consistent` (the default)
    exp(-q² / (2 σ²)) with σ = d_s/2 as a length, as section 4.5.3 says it in words ("σ = d_s/2"), within ‖q‖ ≤ d_l.
    No normaliser: the peak is a parameter, since C to which it is added knows only 0 and 1.
`literal_m`, `literal_cm`
    d_s stands where the formula has it, in metres or centimetres: exp(-q² / d_s) / √(π d_s), so that d_s/2 is a
    variance. Only signs are mended: the exponent falls, R is the sum of negative kernels, the mask is ‖q‖ ≤ d_l.
`printed_m`, `printed_cm`
    To the letter, for the record: the exponent grows, the mask is ‖q‖² ≤ d_l, and R = -Σ m is positive.

A tag on an item with d_s = 4 cm has a kernel with a standard deviation of 2.0 cm and a peak of 1 (`consistent`),
14.1 cm and 2.82 (`literal_m`), or 1.41 cm and 0.28 (`literal_cm`).
"""

from typing import NamedTuple

from rfcompass.errors import InputError


class Reading(NamedTuple):
    """One way to read the kernels.

    Attributes:
        unit_m: Unit of length that numbers are put into the formula in [m]; None where it does not matter.
        printed: True to keep the printed signs and masks.
    """

    unit_m: float | None
    printed: bool = False


READINGS = {
    "consistent": Reading(None),
    "literal_m": Reading(1.0),
    "literal_cm": Reading(0.01),
    "printed_m": Reading(1.0, printed=True),
    "printed_cm": Reading(0.01, printed=True),
}


def reading_called(name: str) -> Reading:
    """Look a reading up.

    Raises:
        InputError: If there is none of that name; lists those there are.
    """
    if name not in READINGS:
        raise InputError(f"no reading {name!r} of the kernels; known: {', '.join(READINGS)}", known=list(READINGS))
    return READINGS[name]
