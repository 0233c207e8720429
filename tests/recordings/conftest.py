"""A made-up trace: a straight antenna path past a few tags, free space."""

from collections.abc import Callable

import numpy as np
import pytest

from rfcompass.recordings import AntennaPoses, Trace, TraceMeta, TraceTag, reads_table
from rfcompass.types.reads import TagRead

SPEED_OF_LIGHT_M_S = 299_792_458.0


def _make_trace(
    seed: int = 0, tags: int = 3, positions: int = 5, frequencies: int = 2, reads_per_cell: int = 3, **meta: object
) -> Trace:
    rng = np.random.default_rng(seed)
    antenna_m = np.stack([np.arange(positions) * 0.05, np.zeros(positions), np.zeros(positions)], axis=1)
    tags_m = rng.uniform([0.0, 0.5, 0.0], [0.4, 1.0, 0.0], (tags, 3))
    freqs_hz = 920.625e6 + 0.5e6 * np.arange(frequencies)
    sign = int(meta.get("phase_sign", 1))
    reads = []
    for k, p, f in np.ndindex(tags, positions, frequencies):
        distance_m = float(np.linalg.norm(tags_m[k] - antenna_m[p]))
        for _ in range(reads_per_cell):
            phase_rad = sign * 4 * np.pi * distance_m * freqs_hz[f] / SPEED_OF_LIGHT_M_S + rng.normal(0.0, 0.02)
            rssi_dbm = -50.0 - 40 * np.log10(distance_m) + rng.choice([-0.5, 0.0, 0.5])
            reads.append(TagRead(f"3008{k:04d}", 1, freqs_hz[f], rssi_dbm, phase_rad % (2 * np.pi), p))
    poses = AntennaPoses(
        pose_ids=np.arange(positions),
        antennas=np.ones(positions, dtype=np.int64),
        positions_m=antenna_m,
        quaternions_xyzw=np.tile([0.0, 0.0, 0.0, 1.0], (positions, 1)),
    )
    listed = tuple(TraceTag(f"3008{k:04d}") for k in range(tags))
    return Trace(TraceMeta(**{"frame": "rail", "tags": listed, **meta}), reads_table(reads), poses)


@pytest.fixture(scope="session")
def make_trace() -> Callable[..., Trace]:
    return _make_trace
