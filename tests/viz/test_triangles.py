"""Markers have the size and the place that they stand for."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rfcompass.viz.triangles import Triangles, ellipse, hand_glyph, join, needles, polygon

Z, Y = np.array([0.0, 0.0, 1.0]), np.array([0.0, 1.0, 0.0])


def volume_m3(surface):
    """Enclosed volume; negative where triangles are seen clockwise from outside."""
    a, b, c = (surface.vertices_m[surface.corners[:, k]] for k in range(3))
    return np.einsum("ij,ij->i", a, np.cross(b, c)).sum() / 6


@given(st.floats(0.01, 0.2))
def test_the_fingers_of_a_hand_leave_the_aperture_between_them(aperture_m):
    hand = hand_glyph(aperture_m, Z, Y)
    tips = hand.vertices_m[hand.vertices_m[:, 2] > 0.0]
    assert np.abs(tips[:, 1]).min() == pytest.approx(aperture_m / 2)


def test_a_hand_points_along_its_approach_and_closes_along_its_closing_axis():
    hand = hand_glyph(0.07, Y, Z)
    assert np.ptp(hand.vertices_m, axis=0).argmax() == 2  # closing along z: the wide side
    assert hand.vertices_m[:, 1].min() < -hand.vertices_m[:, 1].max()  # the stem is behind


def test_bars_are_closed_and_seen_from_outside():
    hand = hand_glyph(0.07, Z, Y)
    edges = np.sort(np.concatenate([hand.corners[:, [0, 1]], hand.corners[:, [1, 2]], hand.corners[:, [2, 0]]]), axis=1)
    _, uses = np.unique(edges, axis=0, return_counts=True)
    assert (uses == 2).all()
    assert volume_m3(hand) > 0


def test_joined_pieces_keep_their_triangles():
    one, other = hand_glyph(0.05, Z, Y), hand_glyph(0.08, Z, Y)
    both = join([one, other])
    assert volume_m3(both) == pytest.approx(volume_m3(one) + volume_m3(other))
    assert len(join([]).corners) == 0


def test_a_moved_surface_keeps_its_volume():
    T = np.eye(4)
    T[:3, :3], T[:3, 3] = [[0, -1, 0], [1, 0, 0], [0, 0, 1]], (1.0, 2.0, 3.0)
    hand = hand_glyph(0.07, Z, Y)
    assert volume_m3(hand.placed(T)) == pytest.approx(volume_m3(hand))


def test_a_needle_is_centred_on_its_sample_and_points_along_theta():
    rng = np.random.default_rng(1)
    samples = np.column_stack([rng.normal(size=(20, 2)), rng.uniform(-np.pi, np.pi, 20)])
    marks = needles(samples, 0.05, 0.01)
    corners = marks.vertices_m[marks.corners]
    points_at = corners[:, 0] - corners[:, 1:].mean(axis=1)
    middle = (corners[:, 0] + corners[:, 1:].mean(axis=1)) / 2
    assert middle[:, :2] == pytest.approx(samples[:, :2])
    assert np.arctan2(points_at[:, 1], points_at[:, 0]) == pytest.approx(samples[:, 2])
    assert np.linalg.norm(points_at, axis=1) == pytest.approx(0.05)


def test_an_ellipse_holds_what_it_says_and_is_counter_clockwise():
    covariance = np.array([[4e-4, 1e-4], [1e-4, 1e-4]])
    outline = ellipse(np.array([1.0, 2.0]), covariance, 0.9)
    draws = np.random.default_rng(2).multivariate_normal([1.0, 2.0], covariance, 20_000)
    sides = np.roll(outline, -1, axis=0) - outline
    to_draws = draws[:, None] - outline[None]
    inside = (sides[:, 0] * to_draws[..., 1] - sides[:, 1] * to_draws[..., 0] > 0).all(axis=1)
    assert inside.mean() == pytest.approx(0.9, abs=0.01)


def test_a_polygon_becomes_a_fan():
    square = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
    fan = polygon(square, 0.5)
    a, b, c = (fan.vertices_m[fan.corners[:, k]] for k in range(3))
    assert (np.cross(b - a, c - a)[:, 2] / 2).sum() == pytest.approx(1.0)
    assert isinstance(fan, Triangles)
    assert (fan.vertices_m[:, 2] == 0.5).all()
