"""Shared by all tests: where the measured sweeps lie, and a quiet hypothesis profile."""

import os
from pathlib import Path

import pytest
from hypothesis import HealthCheck, settings

# Before numpy is imported: the last bits of a sum depend on the number of threads of its linear algebra, and a trial
# computes with one, whatever process it runs in.
os.environ.setdefault("OMP_NUM_THREADS", "1")

settings.register_profile(
    "default", max_examples=40, deadline=None, derandomize=True, suppress_health_check=[HealthCheck.too_slow]
)
settings.load_profile("default")

ROOT = Path(__file__).resolve().parent.parent


@pytest.fixture(scope="session")
def measured_data() -> Path:
    """Folder of the measured development sweeps; skips where it is absent."""
    folder = Path(os.environ.get("RFCOMPASS_MEASURED_DATA", ROOT / ".." / "shared" / "data" / "measured"))
    if not (folder / "traces").is_dir():
        pytest.skip(f"no measured sweeps at {folder} (set RFCOMPASS_MEASURED_DATA)")
    return folder
