"""Reads as a reader on FCC channels reports them, and ways to say the wrong thing over LLRP."""

import numpy as np
import pytest

from rfcompass.types.reads import TagRead


def _made_up_reads(count: int, seed: int = 0, antennas: int = 2) -> tuple[TagRead, ...]:
    """Random reads, each with a reader clock of its own, so that no two are alike."""
    rng = np.random.default_rng(seed)
    return tuple(
        TagRead(
            epc=f"3008{int(rng.integers(5)):020x}",
            antenna=1 + int(rng.integers(antennas)),
            freq_hz=902.75e6 + 0.5e6 * int(rng.integers(50)),
            rssi_dbm=float(rng.uniform(-80.0, -30.0)),
            phase_rad=float(rng.uniform(0.0, 2.0 * np.pi)),
            doppler_hz=float(rng.uniform(-20.0, 20.0)),
            t_reader_us=1_700_000_000_000_000 + 1000 * k,
        )
        for k in range(count)
    )


@pytest.fixture(scope="session")
def made_up_reads():
    return _made_up_reads
