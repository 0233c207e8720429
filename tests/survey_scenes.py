"""Noise-free reads of one tag for the tests of surveyors."""

import numpy as np

from rfcompass.rf import free_space_channel
from rfcompass.types import ReadTrace

RAIL_M = np.column_stack([np.linspace(0.0, 1.0, 41), np.zeros(41), np.zeros(41)])
FREQUENCIES_HZ = np.array([903e6, 915e6, 927e6])


def square_m(side_m=0.5, height_m=0.5, poses=80):
    """A square path in a plane, as the wrist antenna of FuseBot drives it [m], shape (poses, 3)."""
    step = np.linspace(-0.5, 0.5, poses // 4, endpoint=False) * side_m
    edge = np.full(step.size, side_m / 2)
    x, y = np.concatenate([step, edge, -step, -edge]), np.concatenate([-edge, step, edge, -step])
    return np.column_stack([x, y, np.full(x.size, height_m)])


def reads_of(tag_m, positions_m=RAIL_M, *, seed=0, modulus_rad=2 * np.pi, heard=1.0, same_constant=False):
    """Reads with an unknown phase constant for each channel, and, modulo π, a random half turn for each cell."""
    rng = np.random.default_rng(seed)
    M, F = len(positions_m), FREQUENCIES_HZ.size
    h = free_space_channel(np.asarray(tag_m), positions_m, FREQUENCIES_HZ)
    if not same_constant:
        h = h * np.exp(1j * rng.uniform(0, 2 * np.pi, (1, F)))
    if modulus_rad < 2 * np.pi:
        h = h * rng.choice([-1.0, 1.0], (M, F))
    counts = (rng.random((M, F)) < heard).astype(np.int64)
    ports = np.ones(M, dtype=np.int64)
    return ReadTrace("tag", positions_m, FREQUENCIES_HZ, h * counts, counts, ports, phase_modulus_rad=modulus_rad)


WRIST_HZ = np.linspace(800e6, 1000e6, 9)
SENDER_M = np.array([0.1, 0.0, 0.0])  # from the receiver of a wrist
RISE_M = np.array([0.0, 0.0, 0.25])


def two_heights_m(path_m):
    """A path, and the same 25 cm higher up [m]."""
    return np.concatenate([path_m, path_m + RISE_M])


def wrist_reads(tag_m, positions_m=None, frequencies_hz=WRIST_HZ, *, constant_rad=0.7):
    """Noise-free reads of a wrist with two antennas, by default from a square; one phase constant for all of them."""
    rx_m = square_m(0.5, 0.45, 48) if positions_m is None else positions_m
    h = free_space_channel(np.asarray(tag_m), rx_m, frequencies_hz, tx_positions_m=rx_m + SENDER_M)
    counts, ports = np.ones(h.shape, dtype=np.int64), np.ones(len(rx_m), dtype=np.int64)
    return ReadTrace("tag", rx_m, frequencies_hz, h * np.exp(1j * constant_rad), counts, ports, rx_m + SENDER_M)
