"""Studies on measured sweeps: how well tags are located, and which comparisons are right.

The sweeps are public but not ours to ship: those of [AdaRF2019] and of [UAB2025]. They are looked for in the folder
named by `RFCOMPASS_MEASURED_DATA`: `traces/NAME/` in the trace format, and `truth/NAME.json` with the tape-measured tag
positions, which only this module reads. One sweep is one seed.
"""

import functools
import json
import os
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from rfcompass.arrays import FloatArray
from rfcompass.errors import StudyError
from rfcompass.evaluation.metrics import order_comparisons, position_error_m, triplet_comparisons
from rfcompass.evaluation.records import MetricValue
from rfcompass.localization import survey
from rfcompass.recordings import open_trace
from rfcompass.rf import METERS, meter
from rfcompass.studies.metric import SHARE, Metric
from rfcompass.studies.study import Cell, PaperValue, Study

DATA_VARIABLE = "RFCOMPASS_MEASURED_DATA"
DEFAULT_DATA = Path("..") / "shared" / "data" / "measured"  # beside a checkout
FAMILIES = {
    "D1train": "adarf_D1train_",
    "D1test": "adarf_D1test_",
    "D2": "adarf_D2test_",
    "D3": "adarf_D3test_",
    "D4": "adarf_D4test_",
    "UAB": "uab_",
}
MAX_SWEEPS = 500
FAR_GAP_M = 0.20
PILOT = "our own pilot study on all public sweeps of the set, unpublished"


def data_folder() -> Path:
    """Folder of the measured sweeps.

    Raises:
        StudyError: If it is not there.
    """
    folder = Path(os.environ.get(DATA_VARIABLE, DEFAULT_DATA))
    if not (folder / "traces").is_dir():
        message = (
            f"no measured sweeps at {folder}; set {DATA_VARIABLE} to a folder with traces/NAME/ and truth/NAME.json"
        )
        raise StudyError(f"{message}, NAME beginning with {', '.join(FAMILIES.values())}", folder=str(folder))
    return folder


def sweeps(family: str) -> tuple[str, ...]:
    """Names of the sweeps of a family that have a tape-measured truth, sorted."""
    return _sweeps_in(data_folder(), family)


@functools.cache
def _sweeps_in(folder: Path, family: str) -> tuple[str, ...]:
    names = (path.name for path in (folder / "traces").glob(f"{FAMILIES[family]}*"))
    return tuple(sorted(name for name in names if (folder / "truth" / f"{name}.json").is_file()))


def tape_positions(name: str) -> dict[str, FloatArray]:
    """Tape-measured position of each tag of a sweep in the antenna frame [m], shape (3,) each."""
    text = (data_folder() / "truth" / f"{name}.json").read_text(encoding="utf-8")
    return {tag["epc"]: np.array(tag["point_m"], dtype=np.float64) for tag in json.loads(text)["tags"]}


def _is_there(cell: Cell, seed: int) -> bool:
    return seed < len(sweeps(str(cell["family"])))


def survey_trial(cell: Cell, seed: int, rng: np.random.Generator) -> Mapping[str, MetricValue]:  # noqa: ARG001
    """Locate the tags of one sweep and compare with the tape."""
    family = str(cell["family"])
    name = sweeps(family)[seed]
    truth = tape_positions(name)
    fixes = [
        fix
        for fix in survey(open_trace(data_folder() / "traces" / name).scan(), str(cell["method"]))
        if fix.epc in truth
    ]
    found = np.array([fix.point_m for fix in fixes]).reshape(-1, 3)
    tape = np.array([truth[fix.epc] for fix in fixes]).reshape(-1, 3)
    range_is_observable = family != "UAB"
    return {
        "sweep": name,
        "x_error_m": np.abs(found[:, 0] - tape[:, 0]).tolist(),
        "plane_error_m": position_error_m(found[:, :2], tape[:, :2]).tolist() if range_is_observable else None,
        "x_order": order_comparisons(found[:, 0], tape[:, 0]).correct.tolist() if len(fixes) > 1 else None,
        "not_located": float(len(truth) - len(fixes)),
    }


def proximity_trial(cell: Cell, seed: int, rng: np.random.Generator) -> Mapping[str, MetricValue]:  # noqa: ARG001
    """Compare the tags of one sweep with each other and check every triplet against the tape."""
    name = sweeps(str(cell["family"]))[seed]
    matrix = meter(str(cell["meter"])).measure(open_trace(data_folder() / "traces" / name).scan())
    judged = triplet_comparisons(matrix.anchor_epcs, matrix.anchor_m, tape_positions(name))
    return {
        "sweep": name,
        "used": matrix.kind,
        "correct": judged.correct.tolist(),
        "correct_far": judged.within(FAR_GAP_M).correct.tolist(),
    }


def _pilot(cell: Mapping[str, str], metric: str, summary: str, value: float, differs: str = "") -> PaperValue:
    return PaperValue(metric, summary, value, PILOT, differs, dict(cell))


_ONE_CHANNEL = "one channel only; all sweeps of the set"
_PHASE_ONLY = "all sweeps of the set"

MEASURED_SURVEY = Study(
    name="measured-survey",
    title="Tags located from measured sweeps",
    kind="measured",
    factors={"family": tuple(FAMILIES), "method": ("hyperbolic", "sar")},
    seeds=range(MAX_SWEEPS),
    applies=_is_there,
    trial=survey_trial,
    metrics=(
        Metric("sweep", column="text"),
        Metric("x_error_m", ("median",), "samples", "cross-range error", "cm", 100.0),
        Metric("plane_error_m", ("median", "p90"), "samples", "error in the plane", "cm", 100.0),
        Metric("x_order", (SHARE,), "samples", "pairs in the right order along x", "%", 100.0),
        Metric("not_located", ("mean",), "float", "tags not located in a sweep", "", 1.0, 2),
    ),
    paper=tuple(
        _pilot({"family": family, "method": method}, metric, summary, value, differs)
        for family, method, differs, values in (
            ("D1test", "sar", _PHASE_ONLY, (0.025, 0.092, 0.235, 1.000)),
            ("D2", "sar", _PHASE_ONLY, (0.040, 0.136, 0.528, 0.911)),
            ("D3", "sar", _PHASE_ONLY, (0.040, 0.196, 0.616, 0.850)),
            ("D4", "sar", _PHASE_ONLY, (0.030, 0.133, 0.525, 0.941)),
            ("D1test", "hyperbolic", _ONE_CHANNEL, (0.025, 0.102, 0.258, 1.000)),
            ("D2", "hyperbolic", _ONE_CHANNEL, (0.032, 0.100, 0.264, 0.975)),
            ("D3", "hyperbolic", _ONE_CHANNEL, (0.029, 0.187, 0.705, 0.883)),
            ("D4", "hyperbolic", _ONE_CHANNEL, (0.026, 0.118, 1.386, 0.968)),
        )
        for (metric, summary), value in zip(
            (("x_error_m", "median"), ("plane_error_m", "median"), ("plane_error_m", "p90"), ("x_order", SHARE)),
            values,
            strict=True,
        )
    ),
    note="Search volume and constants are the defaults of the command line. Of UAB only the cross-range is observable.",
)

MEASURED_PROXIMITY = Study(
    name="measured-proximity",
    title="Comparisons among the tags of one measured sweep",
    kind="measured",
    factors={"family": tuple(name for name in FAMILIES if name != "UAB"), "meter": tuple(METERS)},
    seeds=range(MAX_SWEEPS),
    applies=_is_there,
    trial=proximity_trial,
    metrics=(
        Metric("sweep", column="text"),
        Metric("used", column="text"),
        Metric("correct", (SHARE,), "samples", "comparisons that are right", "%", 100.0),
        Metric("correct_far", (SHARE,), "samples", "right for gaps of 20 cm and more", "%", 100.0),
    ),
    paper=tuple(
        _pilot({"family": family, "meter": kind}, "correct", SHARE, value, "all sweeps of the set, one channel")
        for kind, values in (
            ("pinit_dtw", {"D1train": 0.561, "D2": 0.456, "D3": 0.500, "D4": 0.517}),
            ("phase_dtw", {"D1train": 0.996, "D2": 0.894, "D3": 0.719, "D4": 0.901}),
            ("phase_l1", {"D1train": 0.983, "D2": 0.961, "D3": 0.821, "D4": 0.913}),
            ("rssi", {"D1train": 0.753, "D2": 0.682, "D3": 0.822, "D4": 0.668}),
        )
        for family, value in values.items()
    ),
    note="Tag a, pair i, j of the same sweep: is m(a, i) < m(a, j) exactly if |a - i| < |a - j|? A tie is wrong.",
)
