"""A small simulated sweep as a trace folder, and a way to run the command line in this process."""

import json
import shutil
from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest
from typer.testing import CliRunner

from rfcompass.cli import app
from rfcompass.recordings import AntennaPoses, Trace, TraceMeta, TraceTag, reads_table, write_trace
from rfcompass.simulation import SweepScene, simulate_sweep

TAGS_M = {f"30080000000000000000000{i}": np.array([0.2 + 0.3 * i, 0.7, 0.0]) for i in range(3)}


@dataclass
class Ran:
    code: int
    out: str
    err: str

    @property
    def json(self) -> Any:
        return json.loads(self.out)


@pytest.fixture
def run():
    def _run(*arguments: object) -> Ran:
        result = CliRunner().invoke(app, [str(argument) for argument in arguments])
        if result.exception is not None and not isinstance(result.exception, SystemExit):
            raise result.exception
        return Ran(result.exit_code, result.stdout, result.stderr)

    return _run


@pytest.fixture(scope="session")
def tags_m():
    """True positions of the tags that were heard [m], by EPC."""
    return TAGS_M


@pytest.fixture(scope="session")
def sweep(tmp_path_factory):
    """Trace of three tags beside a 1 m rail; a fourth tag belongs to it and was never heard."""
    rail_m = np.column_stack([np.linspace(0, 1, 30), np.zeros(30), np.zeros(30)])
    scene = SweepScene(tags_m=TAGS_M, antenna_positions_m=rail_m, frequencies_hz=np.array([920.6e6, 924.1e6]))
    reads = simulate_sweep(scene, np.random.default_rng(0))
    meta = TraceMeta(frame="rail", dimensions=2, tags=tuple(TraceTag(epc) for epc in (*TAGS_M, "silent")))
    folder = tmp_path_factory.mktemp("sweep") / "trace"
    write_trace(Trace(meta, reads_table(reads), AntennaPoses.along(rail_m)), folder)
    return folder


@pytest.fixture
def damaged(sweep, tmp_path):
    """Copy of the sweep, to be damaged."""
    return shutil.copytree(sweep, tmp_path / "damaged")
