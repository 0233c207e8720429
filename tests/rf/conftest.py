"""Made-up scans in free space: known tags, known antenna path, unknown phase constants."""

from collections.abc import Callable

import numpy as np
import pytest

from rfcompass.rf.waves import free_space_channel
from rfcompass.types.reads import ReadTrace, Scan

FREQUENCIES_HZ = np.array([920.625e6, 922.125e6, 924.125e6])


def _line(length_m: float = 1.0, positions: int = 51) -> np.ndarray:
    return np.stack([np.linspace(0.0, length_m, positions), np.zeros(positions), np.zeros(positions)], axis=1)


def _trace(
    point_m: np.ndarray,
    antenna_m: np.ndarray | None = None,
    *,
    epc: str = "e0",
    frequencies_hz: np.ndarray = FREQUENCIES_HZ,
    heard: np.ndarray | None = None,
    ports: np.ndarray | None = None,
    tx_m: np.ndarray | None = None,
    half_turns: bool = False,
    seed: int = 0,
) -> ReadTrace:
    """One tag; phase constants are random for each port and channel, signs for each cell if `half_turns`."""
    rng = np.random.default_rng(seed)
    antenna_m = _line() if antenna_m is None else antenna_m
    M, F = len(antenna_m), len(frequencies_hz)
    ports = np.ones(M, dtype=np.int64) if ports is None else ports
    h = free_space_channel(np.asarray(point_m, dtype=float), antenna_m, frequencies_hz, tx_positions_m=tx_m)
    for port in np.unique(ports):
        h[ports == port] *= np.exp(1j * rng.uniform(0, 2 * np.pi, F))
    if half_turns:
        h = h * rng.choice([-1.0, 1.0], (M, F))
    heard = np.ones((M, F), dtype=bool) if heard is None else heard
    return ReadTrace(
        epc=epc,
        antenna_positions_m=antenna_m,
        frequencies_hz=frequencies_hz,
        channel=np.where(heard, h, 0.0),
        read_counts=heard.astype(np.int64),
        antenna_ports=ports,
        tx_positions_m=tx_m,
        phase_modulus_rad=np.pi if half_turns else 2 * np.pi,
    )


def _scan(points_m: np.ndarray, antenna_m: np.ndarray | None = None, **options: object) -> Scan:
    traces = [_trace(p, antenna_m, epc=f"e{k}", seed=k, **options) for k, p in enumerate(np.atleast_2d(points_m))]
    return Scan({trace.epc: trace for trace in traces})


@pytest.fixture(scope="session")
def line() -> Callable[..., np.ndarray]:
    return _line


@pytest.fixture(scope="session")
def make_trace() -> Callable[..., ReadTrace]:
    return _trace


@pytest.fixture(scope="session")
def make_scan() -> Callable[..., Scan]:
    return _scan
