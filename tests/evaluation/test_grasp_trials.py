"""Attempts are geometric, fewer with a wider hand or a kinder threshold, and the same for the same seed."""

from dataclasses import dataclass

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rfcompass.errors import InputError, ShapeError
from rfcompass.evaluation.error_pairs import ErrorFamily, ErrorPairs
from rfcompass.evaluation.grasp_trials import (
    Attempts,
    Chance,
    GraspRule,
    ThresholdRule,
    chance_of,
    draw_runs,
    factor_bounds,
    implied_factor,
    until_success,
)

WIDTH_M = 0.05
FAMILY = ErrorFamily(median_m=0.0276, theta_median_rad=0.1, shape=2.46)
PAIRS = ErrorPairs(
    distance_m=np.abs(np.random.default_rng(0).normal(0.03, 0.015, 60)),
    theta_rad=np.abs(np.random.default_rng(1).normal(0.0, 0.1, 60)),
)


@dataclass(frozen=True)
class AcrossRule:
    """Holds what is near enough across the part, whatever happens along it."""

    most_m: float

    def holds(self, draws):
        return np.abs(draws.offset_m[:, 1]) <= self.most_m


def run_trials(source, rules, rng, *, runs=1000, cap=1000, combined=False):
    drawn = draw_runs(source, rng, runs=runs, cap=cap)
    drawn = drawn.combined() if combined else drawn
    return {name: until_success(drawn, rule) for name, rule in rules.items()}


def rules(openings_m=(0.075, 0.085, 0.10), factors=(0.5, 1.0)):
    return {(opening, c): ThresholdRule(opening, WIDTH_M, c) for opening in openings_m for c in factors}


@pytest.mark.parametrize("source", [FAMILY, PAIRS], ids=["family", "pairs"])
def test_a_wider_hand_and_a_kinder_threshold_never_need_more_attempts_in_any_run(source):
    found = run_trials(source, rules(), np.random.default_rng(2), runs=400, cap=300)
    for narrow, wide in ((0.075, 0.085), (0.085, 0.10)):
        assert (found[wide, 0.5].tries <= found[narrow, 0.5].tries).all()
        assert (found[wide, 0.5].tries < found[narrow, 0.5].tries).any()
    for opening in (0.075, 0.085, 0.10):
        assert (found[opening, 1.0].tries <= found[opening, 0.5].tries).all()


@pytest.mark.parametrize("source", [FAMILY, PAIRS], ids=["family", "pairs"])
def test_attempts_are_geometric(source):
    rule = ThresholdRule(0.085, WIDTH_M, 0.5)
    first = (source.draw(200_000, np.random.default_rng(3)).distance_m <= 0.0175).mean()
    found = run_trials(source, {"rule": rule}, np.random.default_rng(4), runs=20_000, cap=200)["rule"]
    t = np.arange(1, 41)
    np.testing.assert_allclose(found.cdf(40), 1 - (1 - first) ** t, atol=0.02)
    assert found.mean == pytest.approx(1 / first, rel=0.05)


def test_the_chance_is_what_the_runs_show_and_knows_all_directions():
    rule = AcrossRule(0.01)
    chance = chance_of(PAIRS, rule)
    found = run_trials(PAIRS, {"rule": rule}, np.random.default_rng(5), runs=20_000, cap=1)["rule"]
    assert found.first_share == pytest.approx(chance.value, abs=0.015)
    inside = np.minimum(0.01 / PAIRS.distance_m, 1.0)
    np.testing.assert_allclose(chance.by_pair, 2 / np.pi * np.arcsin(inside), atol=0.03)
    assert chance.mean_tries == pytest.approx(1 / chance.value)


def test_known_vectors_are_judged_once_each():
    pairs = ErrorPairs(
        distance_m=np.array([0.02, 0.02]), theta_rad=np.array([0.1, -0.1]), heading_rad=np.array([0.0, np.pi / 2])
    )
    np.testing.assert_array_equal(chance_of(pairs, AcrossRule(0.01)).by_pair, [1.0, 0.0])


def test_the_interval_of_a_chance_comes_from_the_pairs():
    chance = chance_of(PAIRS, ThresholdRule(0.085, WIDTH_M, 0.5))
    interval = chance.interval(np.random.default_rng(0))
    assert interval.low < chance.value < interval.high
    twice = Chance(np.tile(chance.by_pair, 16)).interval(np.random.default_rng(0))
    assert twice.high - twice.low == pytest.approx((interval.high - interval.low) / 4, rel=0.2)


def test_what_never_holds_is_given_up_and_says_so():
    found = run_trials(FAMILY, {"rule": ThresholdRule(0.04, WIDTH_M, 1.0)}, np.random.default_rng(6), runs=5, cap=30)
    assert (found["rule"].tries == 30).all()
    assert not found["rule"].held.any()
    assert found["rule"].first_share == 0.0
    assert (found["rule"].cdf(40) == 0.0).all()
    assert chance_of(PAIRS, ThresholdRule(0.04, WIDTH_M, 1.0)).mean_tries == np.inf


def test_the_first_attempts_do_not_depend_on_the_cap():
    asked = {"rule": ThresholdRule(0.10, WIDTH_M, 1.0)}
    short, long = (run_trials(FAMILY, asked, np.random.default_rng(7), runs=1, cap=cap)["rule"] for cap in (50, 400))
    np.testing.assert_array_equal(short.tries, long.tries)


def test_a_seed_gives_the_same_runs_and_another_gives_others():
    one, again, other = (
        run_trials(FAMILY, rules(), np.random.default_rng(seed), runs=50, cap=100)[0.075, 0.5].tries
        for seed in (8, 8, 9)
    )
    np.testing.assert_array_equal(one, again)
    assert (one != other).any()


def test_rules_see_the_same_draws_whoever_else_asks():
    both = run_trials(FAMILY, rules(), np.random.default_rng(10), runs=50, cap=100)
    alone = run_trials(FAMILY, rules((0.085,), (0.5,)), np.random.default_rng(10), runs=50, cap=100)
    np.testing.assert_array_equal(both[0.085, 0.5].tries, alone[0.085, 0.5].tries)


def test_combining_measurements_helps_where_errors_are_independent():
    asked = {"rule": ThresholdRule(0.075, WIDTH_M, 0.5)}
    fresh, combined = (
        run_trials(FAMILY, asked, np.random.default_rng(11), runs=2000, cap=200, combined=combined)["rule"]
        for combined in (False, True)
    )
    np.testing.assert_array_equal(fresh.tries == 1, combined.tries == 1)  # the first attempt is the same
    assert combined.mean < 0.8 * fresh.mean


def test_combined_errors_are_the_means_of_the_measured_ones():
    pairs = ErrorPairs(distance_m=np.array([0.04]), theta_rad=np.array([0.2]))
    raw = pairs.draw(6, np.random.default_rng(12))
    combined = draw_runs(pairs, np.random.default_rng(12), runs=1, cap=6).combined()
    for t in range(6):
        np.testing.assert_allclose(combined.offset_m[0, t], raw.offset_m[: t + 1].mean(axis=0))
    unit = np.exp(1j * raw.theta_rad).cumsum()
    np.testing.assert_allclose(combined.theta_rad[0], np.angle(unit), atol=1e-12)


@given(st.floats(0.05, 0.95), st.sampled_from([0.075, 0.085, 0.10]))
def test_the_implied_factor_gives_the_share_it_was_asked_for(share, opening_m):
    factor = implied_factor(FAMILY, opening_m, WIDTH_M, share)
    held = ThresholdRule(opening_m, WIDTH_M, factor).holds(FAMILY.draw(20_000, np.random.default_rng(13)))
    assert held.mean() == pytest.approx(share, abs=0.02)


@pytest.mark.parametrize(("opening_m", "share"), [(0.05, 0.5), (0.04, 0.5), (0.1, 0.0), (0.1, 1.0), (np.nan, 0.5)])
def test_no_factor_is_implied_by_the_impossible(opening_m, share):
    with pytest.raises(InputError):
        implied_factor(FAMILY, opening_m, WIDTH_M, share)


def test_the_median_alone_bounds_the_factor():
    bounds = factor_bounds(0.0276, WIDTH_M, {0.075: 1 / 9, 0.085: 1 / 5, 0.10: 0.8})
    assert bounds.low == pytest.approx(0.0276 / 0.05)
    assert bounds.high == pytest.approx(0.0276 / 0.035)
    none = factor_bounds(0.0276, WIDTH_M, {0.10: 0.5})
    assert (none.low, none.high) == (0.0, np.inf)


@given(st.floats(0.3, 1.0), st.floats(0.5, 8.0))
def test_every_true_factor_lies_within_its_bounds(factor, shape):
    family = ErrorFamily(median_m=0.0276, theta_median_rad=0.1, shape=shape)
    draws = family.draw(4000, np.random.default_rng(14))
    shares = {G: ThresholdRule(G, WIDTH_M, factor).holds(draws).mean() for G in (0.06, 0.075, 0.085, 0.10, 0.12)}
    clear = {G: share for G, share in shares.items() if abs(share - 0.5) > 0.05}  # not by the luck of the draw
    bounds = factor_bounds(family.median_m, WIDTH_M, clear)
    assert bounds.low < factor < bounds.high


@pytest.mark.parametrize("name", ["opening_m", "width_m", "factor"])
def test_a_threshold_needs_positive_sizes(name):
    assert isinstance(ThresholdRule(0.1, 0.05, 1.0), GraspRule)
    with pytest.raises(InputError, match=name):
        ThresholdRule(**{"opening_m": 0.1, "width_m": 0.05, "factor": 1.0, name: np.nan})


def test_no_run_and_no_attempt_are_refused():
    for runs, cap in ((0, 5), (5, 0)):
        with pytest.raises(InputError, match="at least one"):
            draw_runs(FAMILY, np.random.default_rng(0), runs=runs, cap=cap)


def test_attempts_must_fit_each_other():
    with pytest.raises(ShapeError):
        Attempts(np.array([1, 2]), np.array([True]), 10)
