"""Study: how often is the wrong one of two anchors said to be nearer, for every meter on the physical channel?"""

from collections.abc import Mapping
from functools import cache

import numpy as np

from rfcompass.arrays import FloatArray
from rfcompass.evaluation.metrics import TIE_M
from rfcompass.evaluation.records import MetricValue
from rfcompass.interfaces import ProximityMeter
from rfcompass.localization import compare_proximities, measure_proximities
from rfcompass.recordings import PartDatabase
from rfcompass.rf import METERS, meter
from rfcompass.robots import YouBot
from rfcompass.robots.robot import Robot
from rfcompass.simulation import FAR_L_M, FAR_LINE_M
from rfcompass.studies.metric import SHARE, Metric
from rfcompass.studies.radio_scan import scan_over_part
from rfcompass.studies.radio_setup import RadioSetup
from rfcompass.studies.study import Cell, PaperValue, Study
from rfcompass.types.parts import Part

TRACKS = {"one straight": FAR_LINE_M, "two at right angles": FAR_L_M}
SCENES = {"in sight": "room_los", "hidden": "room_nlos"}
ALL_SCENES = {**SCENES, "no walls": "free_space"}
EPSILONS = (0.0, 0.05, 0.1)
BANDED = "pinit_dtw, band 5°"
PILOT = "our own pilot study on another simulated channel, unpublished"
TAGS = 4


@cache
def robot_and_part() -> tuple[Robot, Part]:
    """The youBot with its default tags, and the part that the paper grasps."""
    return YouBot(), PartDatabase(":memory:").part("table_leg_3")


def named_meter(name: str) -> ProximityMeter:
    """A meter by its kind, or PinIt's with the band that repairs most of it."""
    return meter("pinit_dtw", band_rad=float(np.radians(5.0))) if name == BANDED else meter(name)


def comparison_trial(cell: Cell, seed: int, rng: np.random.Generator) -> Mapping[str, MetricValue]:  # noqa: ARG001
    """Scan once with the hand over the part, and judge every comparison of its tags."""
    robot, part = robot_and_part()
    radio = RadioSetup(scene=ALL_SCENES[str(cell["sight"])], legs_m=TRACKS[str(cell["tracks"])])
    stop = scan_over_part(robot, part, part.layout(TAGS), radio, rng)
    matrix = measure_proximities(stop.observation, named_meter(str(cell["meter"])))
    judged = {f"{100 * epsilon:02.0f}": wrong_comparisons(matrix.m, stop.distances_m, epsilon) for epsilon in EPSILONS}
    asked = len(judged["00"])
    return {
        **{f"wrong_{name}": wrong.tolist() for name, wrong in judged.items()},
        **{f"kept_{name}": len(wrong) / asked if asked else None for name, wrong in judged.items() if name != "00"},
        "unheard": float(np.isnan(matrix.m).all(axis=1).sum() + np.isnan(matrix.m).all(axis=0).sum()),
    }


def wrong_comparisons(m: FloatArray, distances_m: FloatArray, epsilon: float) -> FloatArray:
    """1 for each comparison that is wrong, 0 for each that is right; true ties are not asked.

    Args:
        m: Proximity of each target to each anchor, NaN where missing, shape (K, N).
        distances_m: True distance [m], shape (K, N).
        epsilon: Confidence threshold ε.
    """
    made = compare_proximities(m, epsilon)
    too_far_m = distances_m[made.target, made.nearer] - distances_m[made.target, made.farther]
    return np.asarray((too_far_m > 0)[np.abs(too_far_m) > TIE_M], dtype=np.float64)


def _pilot(meter_name: str, tracks: str, sight: str, values: tuple[float, ...]) -> list[PaperValue]:
    cell = {"meter": meter_name, "tracks": tracks, "sight": sight}
    differs = "constant wall reflections, no furniture, no robot body, other tag places; 12 rooms"
    return [
        PaperValue(f"wrong_{100 * epsilon:02.0f}", SHARE, value, PILOT, differs, cell)
        for epsilon, value in zip(EPSILONS, values, strict=False)  # some figures are known at ε = 0 only
    ]


COMPARISONS = Study(
    name="wrong-comparisons",
    title="Which of two robot tags is nearer to a part tag?",
    kind="simulated",
    factors={
        "sight": tuple(ALL_SCENES),
        "tracks": tuple(TRACKS),
        "meter": (*(kind for kind in METERS if kind != "auto"), BANDED),
    },
    seeds=range(1000, 1040),
    tuning_seeds=range(20),
    trial=comparison_trial,
    metrics=(
        Metric("wrong_00", (SHARE,), "samples", "wrong at ε = 0", "%", 100.0),
        Metric("wrong_05", (SHARE,), "samples", "wrong at ε = 0.05", "%", 100.0),
        Metric("kept_05", ("mean",), "float", "kept at ε = 0.05", "%", 100.0, 0),
        Metric("wrong_10", (SHARE,), "samples", "wrong at ε = 0.1", "%", 100.0),
        Metric("kept_10", ("mean",), "float", "kept at ε = 0.1", "%", 100.0, 0),
        Metric("unheard", ("mean",), "float", "tags not heard in a scan", "", 1.0, 2),
    ),
    paper=(
        *_pilot("pinit_dtw", "one straight", "in sight", (0.314, 0.299, 0.286)),
        *_pilot("profile_l1", "one straight", "in sight", (0.150, 0.128, 0.113)),
        *_pilot("pinit_dtw", "one straight", "hidden", (0.32, 0.31, 0.30)),
        *_pilot("profile_l1", "one straight", "hidden", (0.22, 0.19, 0.16)),
        *_pilot(BANDED, "two at right angles", "in sight", (0.14, 0.13, 0.11)),
        *_pilot("profile_l1", "two at right angles", "in sight", (0.12, 0.10, 0.07)),
        *_pilot("sar_nearfield", "two at right angles", "in sight", (0.02,)),
        *_pilot("pinit_dtw", "one straight", "no walls", (0.277, 0.250, 0.225)),
    ),
    note="youBot with nine tags, a leg with four, one stop; 920 MHz, one moving receiver, two fixed transmitters.",
)
