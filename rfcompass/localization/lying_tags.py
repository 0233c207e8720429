"""Tags that an upright reader antenna hardly hears: those that lie flat."""

import numpy as np

from rfcompass.types.tags import TagLayout

MOST_TILT_RAD = float(np.deg2rad(45.0))  # ours: beyond it, more of the axis lies flat than stands


def lying_tags(layout: TagLayout, up: tuple[float, float, float] = (0.0, 0.0, 1.0)) -> tuple[str, ...]:
    """EPCs of tags whose electrical axis is tilted by more than 45° from upright.

    A dipole sends nothing along its own axis, and an upright antenna hears a lying one only by reflections: on
    simulated rooms such tags make twice as many comparisons wrong (study `tag-polarisation`).

    Args:
        layout: Tags on a body that stands or lies as its frame says.
        up: Axis of the reader's antenna in that frame, unit vector.
    """
    upright = np.abs(layout.dipoles @ np.array(up))
    return tuple(epc for epc, share in zip(layout.epcs, upright, strict=True) if share < np.cos(MOST_TILT_RAD) - 1e-9)
