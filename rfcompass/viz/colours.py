"""Colours that scenes and legends share, each 0xRRGGBB."""

import numpy as np

from rfcompass.arrays import FloatArray

REGION, PART, PATH, CLOUD = 0xF2C14E, 0xD1495B, 0x3B6EA5, 0x6A3FB5
OBSTACLE, CHOSEN, REACH = 0x8A99A8, 0x1D2733, 0x7FB800
# Probability of success, from 0 to 1; between the stops colours are mixed.
SUCCESS_SCALE = ((0.0, 0xD95F02), (0.5, 0xE6C229), (1.0, 0x1A9850))
# One for each reason of a rejection, in the order of the legend; then they repeat.
REJECTED = (0x8C8C8C, 0xA65353, 0xC9A0A0, 0x5E5E5E, 0xC97B7B, 0x73414B)


def success_rgb(probabilities: FloatArray) -> FloatArray:
    """Colour of each probability of success: red, green, blue in [0, 1], shape (N, 3); N probabilities."""
    stops = [stop for stop, _ in SUCCESS_SCALE]
    scale = np.array([rgb(colour) for _, colour in SUCCESS_SCALE])
    return np.column_stack([np.interp(probabilities, stops, channel) for channel in scale.T])


def rgb(colour: int) -> FloatArray:
    """Red, green and blue in [0, 1], shape (3,)."""
    return np.array([(colour >> 16) & 255, (colour >> 8) & 255, colour & 255]) / 255


def packed(rgba: FloatArray) -> int:
    """0xRRGGBB of red, green, blue in [0, 1]; an opacity behind them is left out."""
    red, green, blue = (round(255 * float(value)) for value in rgba[:3])
    return (red << 16) + (green << 8) + blue


def css(colour: int) -> str:
    """A colour as style sheets write it."""
    return f"#{colour:06x}"
