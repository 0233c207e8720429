"""What every proximity meter obeys, whatever it measures."""

import pickle
from dataclasses import FrozenInstanceError, fields, is_dataclass

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rfcompass.errors import TagNeverHeard, UnsuitablePath
from rfcompass.interfaces import ProximityMeter
from rfcompass.rf import METERS, free_space_channel, meter
from rfcompass.types.reads import ReadTrace, Scan

FREQUENCIES_HZ = np.array([920.625e6, 922.125e6, 924.125e6])
LINE_M = np.stack([np.linspace(0.0, 1.0, 51), np.zeros(51), np.zeros(51)], axis=1)
TAGS_M = np.array([[0.2, 0.6, 0.0], [0.35, 0.6, 0.0], [0.6, 0.7, 0.1], [0.9, 0.8, 0.0]])
ANGULAR = ("pinit_dtw", "profile_l1", "aoa")
KEEPS_LATERAL_ORDER = ("auto", "sar_nearfield", "phase_rms", "phase_l1", "phase_dtw", "profile_l1")
IGNORES_LOUDNESS = tuple(kind for kind in METERS if kind != "rssi")

every_kind = pytest.mark.parametrize("kind", METERS)


def trace_of(epc, channel, antenna_m=LINE_M, ports=None, half_turns=False):
    return ReadTrace(
        epc=epc,
        antenna_positions_m=antenna_m,
        frequencies_hz=FREQUENCIES_HZ,
        channel=channel,
        read_counts=(channel != 0).astype(np.int64),
        antenna_ports=np.ones(len(antenna_m), dtype=np.int64) if ports is None else ports,
        phase_modulus_rad=np.pi if half_turns else 2 * np.pi,
    )


def scan_of(points_m=TAGS_M, antenna_m=LINE_M, factor=None, **options):
    """One tag e0, e1... at each point; `factor(k)` multiplies the channel of tag k."""
    traces = {}
    for k, point_m in enumerate(points_m):
        h = free_space_channel(point_m, antenna_m, FREQUENCIES_HZ)
        traces[f"e{k}"] = trace_of(f"e{k}", h if factor is None else h * factor(k), antenna_m, **options)
    return Scan(traces)


def anchor_m(kind, scan):
    return meter(kind).measure(scan).anchor_m


@every_kind
def test_a_meter_is_a_frozen_record_of_keyword_parameters(kind):
    one = meter(kind)
    assert isinstance(one, ProximityMeter)
    assert is_dataclass(one)
    assert all(field.kw_only for field in fields(one))
    assert one == meter(kind)
    assert pickle.loads(pickle.dumps(one)) == one
    with pytest.raises((FrozenInstanceError, AttributeError, TypeError)):
        one.kind = "other"


@every_kind
def test_all_pairs_of_heard_tags_are_compared(kind):
    found = meter(kind).measure(scan_of(), targets=["e1"])
    assert found.kind == (kind if kind != "auto" else "phase_rms")
    assert np.isfinite(found.m).all()
    assert np.isfinite(found.anchor_m[~np.eye(3, dtype=bool)]).all()
    assert found.m.max() > 0


@every_kind
def test_measuring_twice_gives_the_same_bits(kind):
    np.testing.assert_array_equal(anchor_m(kind, scan_of()), anchor_m(kind, scan_of()))


@every_kind
def test_a_pair_has_one_proximity_whatever_the_roles(kind):
    scan = scan_of()
    whole = anchor_m(kind, scan)
    found = meter(kind).measure(scan, targets=["e2", "e0"], anchors=["e3", "e1"])
    np.testing.assert_allclose(found.m, whole[np.ix_([2, 0], [3, 1])], rtol=1e-9)


@every_kind
def test_two_tags_in_one_place_are_nearest(kind):
    m = anchor_m(kind, scan_of(np.concatenate([TAGS_M, TAGS_M[:1]])))
    assert m[0, 4] == pytest.approx(0.0, abs=1e-6 * np.nanmax(m))
    assert np.nanargmin(m[0]) == 4


@every_kind
@settings(max_examples=8)
@given(seed=st.integers(0, 2**31))
def test_unknown_phase_constants_of_tag_channel_and_port_drop_out(kind, seed):
    ports = np.tile([1, 2], 26)[:51]
    rng = np.random.default_rng(seed)

    def constants(k):
        phases = np.exp(1j * rng.uniform(0, 2 * np.pi, (2, len(FREQUENCIES_HZ))))
        return phases[ports - 1]

    plain = anchor_m(kind, scan_of(ports=ports))
    np.testing.assert_allclose(anchor_m(kind, scan_of(factor=constants, ports=ports)), plain, rtol=1e-6)


@pytest.mark.parametrize("kind", IGNORES_LOUDNESS)
def test_a_tag_may_be_louder_than_another(kind):
    louder = scan_of(factor=lambda k: 10.0 ** (k - 2))
    np.testing.assert_allclose(anchor_m(kind, louder), anchor_m(kind, scan_of()), rtol=1e-6)


@every_kind
@settings(max_examples=8)
@given(seed=st.integers(0, 2**31))
def test_moving_tags_and_antenna_together_changes_nothing(kind, seed):
    rng = np.random.default_rng(seed)
    R, _ = np.linalg.qr(rng.normal(size=(3, 3)))
    moved = scan_of(TAGS_M @ R.T + [1.0, -2.0, 0.5], LINE_M @ R.T + [1.0, -2.0, 0.5])
    np.testing.assert_allclose(anchor_m(kind, moved), anchor_m(kind, scan_of()), rtol=1e-6)


@every_kind
@given(order=st.permutations(range(4)))
@settings(max_examples=8)
def test_names_and_order_of_the_tags_change_nothing(kind, order):
    plain = anchor_m(kind, scan_of())
    renamed = Scan({f"x{o}": trace_of(f"x{o}", scan_of().trace(f"e{k}").channel) for k, o in enumerate(order)})
    found = meter(kind).measure(renamed, anchors=[f"x{o}" for o in order])
    np.testing.assert_allclose(found.anchor_m, plain, rtol=1e-9)


@every_kind
def test_a_tag_that_was_not_heard_leaves_nan_and_the_others_alone(kind):
    scan = scan_of()
    found = meter(kind).measure(scan, targets=["e0", "gone"], anchors=["e1", "lost", "e2"])
    plain = meter(kind).measure(scan, targets=["e0"], anchors=["e1", "e2"])
    np.testing.assert_allclose(found.m[0, [0, 2]], plain.m[0], rtol=1e-12)
    assert np.isnan(found.m[1]).all()
    assert np.isnan(found.m[:, 1]).all()


@every_kind
def test_a_tag_heard_once_does_not_spoil_the_others(kind):
    scan = scan_of()
    faint = np.where(np.arange(51 * 3).reshape(51, 3) == 70, scan.trace("e0").channel, 0.0)
    with_faint = Scan({**scan.traces, "faint": trace_of("faint", faint)})
    found = meter(kind).measure(with_faint, targets=["faint"], anchors=["e0", "e1", "e2", "e3"])
    np.testing.assert_allclose(found.anchor_m, anchor_m(kind, scan), rtol=1e-12)
    assert kind == "rssi" or np.isnan(found.m).all()


@every_kind
def test_if_no_tag_was_heard_there_is_no_answer(kind):
    with pytest.raises(TagNeverHeard):
        meter(kind).measure(scan_of(), targets=["gone"], anchors=["lost"])
    with pytest.raises(TagNeverHeard):
        meter(kind).measure(Scan())


@every_kind
def test_signs_that_mean_nothing_are_ignored(kind):
    fine_m = np.stack([np.linspace(0.0, 1.0, 101), np.zeros(101), np.zeros(101)], axis=1)
    rng = np.random.default_rng(4)
    plain = scan_of(antenna_m=fine_m, half_turns=True)
    flipped = scan_of(antenna_m=fine_m, factor=lambda k: rng.choice([-1.0, 1.0], (101, 3)), half_turns=True)
    np.testing.assert_allclose(anchor_m(kind, flipped), anchor_m(kind, plain), rtol=1e-6)


@pytest.mark.parametrize("kind", KEEPS_LATERAL_ORDER)
def test_with_half_turns_a_tag_further_along_the_path_is_still_further_away(kind):
    fine_m = np.stack([np.linspace(0.0, 1.0, 101), np.zeros(101), np.zeros(101)], axis=1)
    rng = np.random.default_rng(4)
    places_m = [[0.3, 0.7, 0.0], [0.38, 0.7, 0.0], [0.5, 0.7, 0.0]]
    flips = {"factor": lambda k: rng.choice([-1.0, 1.0], (101, 3)), "half_turns": True}
    m = anchor_m(kind, scan_of(places_m, fine_m, **flips))
    assert m[0, 1] < m[0, 2]
    assert m[2, 1] < m[2, 0]


@pytest.mark.parametrize("kind", KEEPS_LATERAL_ORDER)
@settings(max_examples=15)
@given(
    x_m=st.floats(0.2, 0.5), y_m=st.floats(0.5, 1.2), steps_m=st.lists(st.floats(0.05, 0.15), min_size=2, max_size=2)
)
def test_in_free_space_a_tag_further_along_the_path_is_further_away(kind, x_m, y_m, steps_m):
    places_m = x_m + np.concatenate([[0.0], np.cumsum(steps_m)])
    m = anchor_m(kind, scan_of([[x, y_m, 0.0] for x in places_m]))
    assert m[0, 1] < m[0, 2]
    assert m[2, 1] < m[2, 0]


@every_kind
def test_a_path_with_a_corner_works(kind):
    leg = LINE_M[:31]
    corner = np.concatenate([leg, leg[-1] + leg[1:][:, [1, 0, 2]] * [1.0, -1.0, 1.0]])
    scan = scan_of(antenna_m=corner)
    assert np.isfinite(meter(kind).measure(scan, targets=["e0"]).m).all()


@every_kind
def test_a_curved_antenna_path_works_or_is_refused(kind):
    angle = np.linspace(0.0, np.pi, 61)[:, None]
    scan = scan_of(antenna_m=0.4 * np.hstack([np.cos(angle), -np.sin(angle), 0 * angle]))
    if kind in ANGULAR:
        with pytest.raises(UnsuitablePath, match="straight"):
            meter(kind).measure(scan)
    else:
        assert np.isfinite(meter(kind).measure(scan, targets=["e0"]).m).all()
