"""Study: which tags on a lying leg go with which reader antenna?"""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from rfcompass.arrays import FloatArray
from rfcompass.evaluation.records import MetricValue
from rfcompass.localization import measure_proximities
from rfcompass.localization.measuring import with_known_heights
from rfcompass.rf import SarNearfieldMeter
from rfcompass.simulation import (
    DUAL_DIPOLE,
    PATCH_CIRCULAR,
    PATCH_DUAL,
    PATCH_LINEAR,
    RIG_PAPER,
    SQUIGGLE,
    VERT900,
    AntennaModel,
    TagModel,
)
from rfcompass.studies.comparisons import TAGS, robot_and_part, wrong_comparisons
from rfcompass.studies.metric import SHARE, Metric
from rfcompass.studies.radio_scan import ScannedStop, scan_over_part
from rfcompass.studies.radio_setup import RadioSetup
from rfcompass.studies.study import Cell, PaperValue, Study

_UP, _ALONG = (0.0, 0.0, 1.0), (1.0, 0.0, 0.0)
# Electrical axis in the part frame, and type.
PART_TAGS: Mapping[str, tuple[tuple[float, float, float], TagModel]] = {
    "small, upright": (_UP, SQUIGGLE),
    "9.5 cm, along the leg": (_ALONG, SQUIGGLE),
    "small, two crossed dipoles": (_UP, DUAL_DIPOLE),
}
# Receiving antenna, and the ports that it is read through.
READERS: Mapping[str, tuple[AntennaModel, tuple[int, ...]]] = {
    "vertical whip": (VERT900, (1,)),
    "linear panel": (PATCH_LINEAR, (1,)),
    "circular panel": (PATCH_CIRCULAR, (1,)),
    "dual-polarised panel": (PATCH_DUAL, (1, 2)),
}
FACING_M = (3.2, 3.1, 0.2)  # ours: the middle of where the part may lie


def polarisation_trial(cell: Cell, seed: int, rng: np.random.Generator) -> Mapping[str, MetricValue]:  # noqa: ARG001
    """Scan once with the hand over the part; judge comparisons, and where the images put the part's tags."""
    robot, part = robot_and_part()
    axis, model = PART_TAGS[str(cell["part_tags"])]
    antenna, ports = READERS[str(cell["reader"])]
    radio = RadioSetup(
        rig=replace(RIG_PAPER, rx=antenna), facing_m=FACING_M, ports=ports, part_tag_model=model
    )  # fmt: skip
    layout = replace(part.layout(TAGS), dipoles=np.tile(axis, (TAGS, 1)))
    stop = scan_over_part(robot, part, layout, radio, rng)
    matrix = measure_proximities(stop.observation, SarNearfieldMeter())
    errors_m = part_tag_errors_m(stop)
    return {
        "wrong": wrong_comparisons(matrix.m, stop.distances_m, 0.0).tolist(),
        "tag_error_m": errors_m.tolist(),
        "unheard": float(TAGS - len(errors_m)),
    }


def part_tag_errors_m(stop: ScannedStop) -> FloatArray:
    """How far each heard part tag's image is off, less what is common to the robot's tags [m], shape (K',)."""
    scan, meter, truth = with_known_heights(stop.observation), SarNearfieldMeter(), stop.truth

    def off_m(epcs: tuple[str, ...], points_m: FloatArray) -> FloatArray:
        heard = [i for i, epc in enumerate(epcs) if epc in scan.traces]
        places = [meter.place(scan.traces[epcs[i]], scan.heights_m[epcs[i]]) for i in heard]
        return np.array(places).reshape(-1, 3) - points_m[heard]

    common_m = np.nanmedian(off_m(truth.anchors.epcs, truth.anchors.points_m), axis=0)
    errors_m = np.linalg.norm(off_m(truth.targets.epcs, truth.targets.points_m) - common_m, axis=1)
    return np.asarray(errors_m[np.isfinite(errors_m)])


POLARISATION = Study(
    name="tag-polarisation",
    title="Tags on a lying leg and the reader's antenna",
    kind="simulated",
    factors={"part_tags": tuple(PART_TAGS), "reader": tuple(READERS)},
    seeds=range(1000, 1040),
    tuning_seeds=range(20),
    trial=polarisation_trial,
    metrics=(
        Metric("wrong", (SHARE,), "samples", "wrong comparisons", "%", 100.0),
        Metric("tag_error_m", ("median", "p90"), "samples", "part tag in its image", "cm", 100.0),
        Metric("unheard", ("mean",), "float", "part tags not heard, of 4", "", 1.0, 2),
    ),
    paper=(
        PaperValue(
            "wrong", SHARE, 0.29, "our own pilot study on another simulated channel, unpublished",
            "constant wall reflections, one pose, other tag places",
            {"part_tags": "9.5 cm, along the leg", "reader": "vertical whip"},
        ),
    ),
    note=(
        "Robot tags stand. Two far legs at right angles, near-field images, furnished room; two circular panels that "
        "stand still send. The second dipole of a crossed pair lies along a fixed direction of the room."
    ),
)  # fmt: skip
