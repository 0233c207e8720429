"""What is known about the measured sweeps must show in their quality reports."""

import numpy as np
import pytest

from rfcompass.recordings import open_trace


@pytest.mark.parametrize(
    ("name", "tags", "positions", "frequencies"),
    [
        ("adarf_D1test_181218-01", 3, 50, 8),
        ("adarf_D3test_190126-01", 6, 50, 8),
        ("adarf_D4test_190115-21", 10, 50, 8),
        ("uab_813mm_r1", 1, 38, 4),
    ],
)
def test_a_measured_sweep_opens_with_the_stated_size_and_scatter(measured_data, name, tags, positions, frequencies):
    trace = open_trace(measured_data / "traces" / name)
    quality = trace.quality
    assert (len(quality.tags), quality.positions, quality.frequencies) == (tags, positions, frequencies)
    assert quality.strays == quality.silent_epcs == ()
    assert all(tag.coverage > 0.85 for tag in quality.tags)
    assert np.degrees(quality.phase_spread_rad) < 5.0
    assert quality.flip_share < 0.06
    scan = trace.scan()
    assert scan.epcs == tuple(sorted(trace.epcs))
    assert sum(scan.trace(epc).reads for epc in scan.epcs) == quality.reads
