"""A target in plain sight: the paper's is red, and found by colour [Boroushaki2023], sections 4.5.2 and 7.1."""

from dataclasses import dataclass

import numpy as np
from scipy import ndimage

from rfcompass.arrays import BoolArray, FloatArray, IntArray, read_only
from rfcompass.errors import InputError
from rfcompass.mapping.camera import back_project
from rfcompass.types.piles import DepthView
from rfcompass.types.record import Record


@dataclass(frozen=True, slots=True)
class ColourRule(Record):
    """Which colours the target has, as hue [degree], saturation and value [0 to 1].

    The defaults are the red of the code that [XRay2020] published (hue 0-10 or 170-180 of 180, saturation from 120,
    value from 70 of 255); the paper names none.

    Attributes:
        middle_deg: Middle of the hues.
        half_width_deg: How far a hue may be from it.
        saturation: Least saturation.
        value: Least value.
        least_pixels: The largest connected patch must have at least so many pixels; ours.
    """

    middle_deg: float = 0.0
    half_width_deg: float = 20.0
    saturation: float = 120 / 255
    value: float = 70 / 255
    least_pixels: int = 30

    def __post_init__(self) -> None:
        """Check the ranges."""
        shares = (self.saturation, self.value)
        if not (0 < self.half_width_deg <= 180 and all(0 <= s <= 1 for s in shares) and self.least_pixels >= 1):
            raise InputError(f"{self}: out of range", got=[self.half_width_deg, *shares, self.least_pixels])


RED = ColourRule()


@dataclass(frozen=True, slots=True)
class VisibleTarget(Record):
    """The part of a target that a camera sees.

    Attributes:
        pixels: Its pixels, shape (H, W).
        points_m: Where they are in the world frame [m], shape (P, 3); empty if none of them has a depth.
    """

    pixels: BoolArray
    points_m: FloatArray

    def __post_init__(self) -> None:
        """Freeze the arrays."""
        object.__setattr__(self, "pixels", read_only(self.pixels, "VisibleTarget.pixels", (None, None), np.bool_))
        object.__setattr__(self, "points_m", read_only(self.points_m, "VisibleTarget.points_m", (None, 3)))


def find_visible_target(view: DepthView, rule: ColourRule = RED) -> VisibleTarget | None:
    """Find the largest connected patch of the target's colour.

    Args:
        view: A depth image with colour.
        rule: Which colours count.

    Returns:
        The patch; None if it is too small to be sure, so that the target counts as hidden.

    Raises:
        InputError: If the camera has no colour.
    """
    if view.colour is None:
        raise InputError("the view has no colour to find the target by", name="colour")
    patches, count = ndimage.label(pixels_of_colour(view.colour, rule), structure=np.ones((3, 3)))
    sizes = np.bincount(patches.ravel(), minlength=count + 1)[1:]
    if not count or sizes.max() < rule.least_pixels:
        return None
    pixels = patches == 1 + int(sizes.argmax())
    return VisibleTarget(pixels, back_project(view, pixels))


def pixels_of_colour(colour: IntArray, rule: ColourRule = RED) -> BoolArray:
    """Tell which pixels have the colours of a rule.

    Args:
        colour: Red, green, blue, 0 to 255, shape (H, W, 3).
        rule: Which colours count.
    """
    hue_deg, saturation, value = np.moveaxis(hue_saturation_value(colour), -1, 0)
    off_deg = np.abs((hue_deg - rule.middle_deg + 180.0) % 360.0 - 180.0)
    return np.asarray((off_deg <= rule.half_width_deg) & (saturation >= rule.saturation) & (value >= rule.value))


def hue_saturation_value(colour: IntArray) -> FloatArray:
    """Convert red, green, blue (0 to 255) to hue [degree, 0 to 360], saturation and value [0 to 1], shape (..., 3)."""
    rgb = np.asarray(colour, dtype=np.float64) / 255.0
    value, spread = rgb.max(axis=-1), np.ptp(rgb, axis=-1)
    largest = rgb.argmax(axis=-1)
    safe = np.where(spread > 0, spread, 1.0)
    r, g, b = np.moveaxis(rgb, -1, 0)
    sixths = np.choose(largest, [(g - b) / safe % 6, (b - r) / safe + 2, (r - g) / safe + 4])
    saturation = spread / np.where(value > 0, value, 1.0)
    return np.stack([60.0 * np.where(spread > 0, sixths, 0.0), saturation, value], axis=-1)
