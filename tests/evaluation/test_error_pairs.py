"""Pairs stay together, families have the medians they are told, and a bad CSV is named by file, column and row."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rfcompass.errors import ImportFormatError, InputError, ShapeError
from rfcompass.evaluation.error_pairs import (
    RAYLEIGH_SHAPE,
    Draws,
    ErrorFamily,
    ErrorPairs,
    ErrorSource,
    read_error_csv,
    weibull_shape,
)

SIZES = ErrorPairs(distance_m=np.array([0.01, 0.02, 0.04]), theta_rad=np.array([0.1, 0.2, 0.4]), incomplete=1)
VECTORS = ErrorPairs(
    distance_m=np.array([0.01, 0.02]), theta_rad=np.array([-0.1, 0.2]), heading_rad=np.array([0.0, np.pi / 2])
)
FAMILY = ErrorFamily(median_m=0.0276, theta_median_rad=0.1, shape=2.46)


@pytest.fixture
def csv(tmp_path):
    def write(text):
        (tmp_path / "mine.csv").write_text(text, encoding="utf-8")
        return tmp_path / "mine.csv"

    return write


def test_position_and_orientation_of_a_draw_come_from_one_trial():
    draws = SIZES.draw(500, np.random.default_rng(0))
    np.testing.assert_allclose(np.abs(draws.theta_rad), 10.0 * draws.distance_m)


def test_every_pair_is_as_likely_as_any_other():
    draws = SIZES.draw(30_000, np.random.default_rng(1))
    shares = [np.isclose(draws.distance_m, d).mean() for d in SIZES.distance_m]
    np.testing.assert_allclose(shares, 1 / 3, atol=0.01)


def test_unknown_directions_are_drawn_evenly_with_either_sign_of_the_turn():
    draws = SIZES.draw(30_000, np.random.default_rng(2))
    unit = draws.offset_m / draws.distance_m[:, None]
    assert np.abs(unit.mean(axis=0)).max() < 0.02
    assert abs((draws.theta_rad > 0).mean() - 0.5) < 0.02


def test_known_vectors_keep_their_direction_and_sign():
    draws = VECTORS.draw(100, np.random.default_rng(3))
    first = draws.theta_rad < 0
    assert 0 < first.sum() < 100
    np.testing.assert_allclose(draws.offset_m[first], np.tile([0.01, 0.0], (first.sum(), 1)), atol=1e-15)
    np.testing.assert_allclose(draws.offset_m[~first], np.tile([0.0, 0.02], ((~first).sum(), 1)), atol=1e-15)


@pytest.mark.parametrize("source", [SIZES, VECTORS, FAMILY], ids=["sizes", "vectors", "family"])
def test_the_first_draws_do_not_depend_on_how_many_follow(source):
    assert isinstance(source, ErrorSource)
    few, many = (source.draw(count, np.random.default_rng(4)) for count in (7, 100))
    np.testing.assert_array_equal(few.offset_m, many.offset_m[:7])
    np.testing.assert_array_equal(few.theta_rad, many.theta_rad[:7])


@pytest.mark.parametrize("source", [SIZES, VECTORS, FAMILY], ids=["sizes", "vectors", "family"])
def test_a_quantile_is_that_of_the_draws(source):
    distances_m = source.draw(40_000, np.random.default_rng(5)).distance_m
    for share in (0.2, 0.6, 0.9):
        assert (distances_m <= source.distance_quantile_m(share) + 1e-12).mean() >= share - 0.01
    assert np.median(distances_m) == pytest.approx(source.distance_quantile_m(0.5), rel=0.5)


def test_a_family_has_its_medians():
    draws = FAMILY.draw(40_000, np.random.default_rng(6))
    assert np.median(draws.distance_m) == pytest.approx(0.0276, rel=0.01)
    assert np.median(np.abs(draws.theta_rad)) == pytest.approx(0.1, rel=0.02)


def test_the_shape_gives_the_papers_spread_and_a_rayleigh_is_wider():
    shape = weibull_shape(0.018 / 0.0403)
    distances_m = ErrorFamily(median_m=0.0403, theta_median_rad=0.1, shape=shape).draw(
        200_000, np.random.default_rng(7)
    )
    assert distances_m.distance_m.std() == pytest.approx(0.018, rel=0.01)
    assert shape > RAYLEIGH_SHAPE


@given(st.floats(1.0, 40.0))
def test_the_shape_is_the_inverse_of_the_ratio(shape):
    draws = (-np.log1p(-(np.arange(20_000) + 0.5) / 20_000)) ** (1.0 / shape)
    assert weibull_shape(draws.std() / np.median(draws)) == pytest.approx(shape, rel=0.05)


@pytest.mark.parametrize("ratio", [0.0, -1.0, np.nan, 1e6])
def test_an_impossible_ratio_has_no_shape(ratio):
    with pytest.raises(InputError):
        weibull_shape(ratio)


def test_the_surest_half_is_kept_whole():
    pairs = ErrorPairs(
        distance_m=np.arange(1.0, 5.0), theta_rad=np.arange(1.0, 5.0) / 10, spread_m=np.array([4.0, 1.0, 3.0, 2.0])
    )
    sure = pairs.surest(0.5)
    np.testing.assert_array_equal(sure.distance_m, [2.0, 4.0])
    np.testing.assert_array_equal(sure.theta_rad, [0.2, 0.4])
    with pytest.raises(InputError, match="not known"):
        SIZES.surest()


def test_trials_that_are_left_out_are_counted():
    assert SIZES.complete_share == 0.75


@pytest.mark.parametrize(
    "broken",
    [
        {"distance_m": [], "theta_rad": []},
        {"distance_m": [-0.1], "theta_rad": [0.0]},
        {"distance_m": [0.1], "theta_rad": [-0.1]},
        {"distance_m": [0.1, 0.2], "theta_rad": [0.1]},
        {"distance_m": [np.nan], "theta_rad": [0.1]},
        {"distance_m": [0.1], "theta_rad": [0.1], "heading_rad": [0.1, 0.2]},
    ],
)
def test_impossible_pairs_are_refused(broken):
    with pytest.raises(ShapeError):
        ErrorPairs(**{name: np.array(value, dtype=float) for name, value in broken.items()})


@pytest.mark.parametrize("name", ["median_m", "theta_median_rad", "shape"])
@pytest.mark.parametrize("value", [0.0, -1.0, np.nan, np.inf])
def test_a_family_needs_positive_parameters(name, value):
    with pytest.raises(InputError, match=name):
        ErrorFamily(**{"median_m": 0.03, "theta_median_rad": 0.1, "shape": 2.0, name: value})


def test_draws_must_fit_each_other():
    with pytest.raises(ShapeError):
        Draws(np.zeros((3, 2)), np.zeros(2))


def test_sizes_are_read_from_a_csv(csv):
    pairs = read_error_csv(csv("note,position_error_m,theta_error_rad,spread_m\na,0.01,-0.1,0.02\nb,0.03,0.2,0.01\n"))
    np.testing.assert_array_equal(pairs.distance_m, [0.01, 0.03])
    np.testing.assert_array_equal(pairs.theta_rad, [0.1, 0.2])
    np.testing.assert_array_equal(pairs.spread_m, [0.02, 0.01])
    assert pairs.heading_rad is None


def test_vectors_are_read_from_a_csv(csv):
    pairs = read_error_csv(csv("x_error_m,y_error_m,theta_error_rad\n0.03,-0.04,-0.1\n"))
    draw = pairs.draw(1, np.random.default_rng(0))
    np.testing.assert_allclose(draw.offset_m, [[0.03, -0.04]], atol=1e-15)
    np.testing.assert_array_equal(draw.theta_rad, [-0.1])


@pytest.mark.parametrize(
    ("text", "column", "row"),
    [
        ("position_error_m\n0.1\n", "theta_error_rad", None),
        ("theta_error_rad\n0.1\n", "position_error_m", None),
        ("x_error_m,theta_error_rad\n0.1,0.1\n", "y_error_m", None),
        ("x_error_m,y_error_m,position_error_m,theta_error_rad\n0,0,0,0\n", "position_error_m", None),
        ("position_error_m,theta_error_rad\n0.1,0.1\n0.1,\n", "theta_error_rad", 1),
        ("position_error_m,theta_error_rad\nnan,0.1\n", "position_error_m", 0),
        ("position_error_m,theta_error_rad\n0.1,0.1\n-0.1,0.1\n", "position_error_m", 1),
        ("position_error_m,theta_error_rad\n0.1,0.1\n0.1,30\n", "theta_error_rad", 1),
        ("position_error_m,theta_error_rad,spread_m\n0.1,0.1,-1\n", "spread_m", 0),
        ("position_error_m,theta_error_rad\n0.1,1,2\n", None, 0),
        ("position_error_m,theta_error_rad\n", None, None),
        ("", None, None),
    ],
)
def test_a_bad_csv_is_named_by_file_column_and_row(csv, text, column, row):
    with pytest.raises(ImportFormatError) as caught:
        read_error_csv(csv(text))
    assert caught.value.numbers["file"] == "mine.csv"
    assert caught.value.numbers.get("column") == column
    assert caught.value.numbers.get("row") == row


def test_a_file_that_is_not_there_is_named(tmp_path):
    with pytest.raises(ImportFormatError, match=r"none\.csv"):
        read_error_csv(tmp_path / "none.csv")
