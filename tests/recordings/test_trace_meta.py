import pickle

import numpy as np
import pytest

from rfcompass.errors import TraceError
from rfcompass.recordings import TraceMeta, TraceTag


@pytest.mark.parametrize(
    ("column", "value"),
    [
        ("geometry", "tristatic"),
        ("phase_sign", 0),
        ("phase_sign", True),
        ("phase_sign", "+1"),
        ("phase_modulus", "3pi"),
        ("phase_modulus", ["2pi"]),
        ("dimensions", 4),
        ("frame", ""),
        ("frame", None),
        ("robot", 7),
        ("license", 1.5),
        ("channel_offsets_rad", ((0.0, 1.0),)),
        ("channel_offsets_rad", ((9e8, float("nan")),)),
        ("channel_offsets_rad", ((9e8, 1.0), (9e8, 2.0))),
    ],
)
def test_an_impossible_value_is_an_error_that_names_its_key(column, value):
    with pytest.raises(TraceError) as caught:
        TraceMeta(**{"frame": "rail", column: value})
    assert caught.value.numbers["file"] == "meta.json"
    assert caught.value.numbers["column"] == column


@pytest.mark.parametrize(
    ("tag", "column"),
    [
        (TraceTag(""), "epc"),
        (TraceTag("B", body=3), "body"),
        (TraceTag("B", point_m=(0.0, 0.0, 0.0)), "point_m"),
        (TraceTag("B", body="robot", point_m=(0.0, 0.0, 0.0)), "point_m"),
        (TraceTag("B", body="leg", dipole=(0.0, 0.0, 0.0)), "dipole"),
        (TraceTag("A"), "tags"),
    ],
)
def test_an_impossible_tag_is_an_error_that_names_its_row(tag, column):
    with pytest.raises(TraceError) as caught:
        TraceMeta(frame="rail", tags=(TraceTag("A"), tag))
    assert (caught.value.numbers["column"], caught.value.numbers["row"]) == (column, 1)


def test_a_duplicate_epc_is_named():
    with pytest.raises(TraceError) as caught:
        TraceMeta(frame="rail", tags=(TraceTag("A"), TraceTag("B"), TraceTag("A")))
    assert caught.value.numbers["epc"] == "A"
    assert caught.value.numbers["row"] == 2


def test_the_order_of_the_channel_offsets_does_not_matter():
    offsets = ((921e6, 0.1), (920e6, 0.2))
    assert TraceMeta(frame="a", channel_offsets_rad=offsets) == TraceMeta(frame="a", channel_offsets_rad=offsets[::-1])


def test_the_phase_modulus_is_also_a_number():
    assert TraceMeta(frame="a", phase_modulus="pi").phase_modulus_rad == np.pi
    assert TraceMeta(frame="a").phase_modulus_rad == 2 * np.pi


def test_a_record_survives_the_trip_between_processes():
    meta = TraceMeta(frame="rail", tags=(TraceTag("A", body="leg", point_m=(0.1, 0.0, 0.0)),))
    assert pickle.loads(pickle.dumps(meta)) == meta
