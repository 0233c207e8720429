import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from rfcompass.geometry import (
    clip_polygon,
    intersect_half_planes,
    polygon_area_m2,
    polygon_centroid_m,
    polygon_contains,
)
from rfcompass.geometry.polygons import box_polygon

BOUNDS = np.array([[-1.0, 1.0], [-2.0, 2.0]])
seeds = st.integers(0, 10_000)


def random_planes(seed: int, count: int = 5) -> tuple[np.ndarray, np.ndarray]:
    rng = np.random.default_rng(seed)
    return rng.normal(size=(count, 2)), rng.normal(size=count)


@given(seeds)
def test_a_point_is_in_the_polygon_exactly_if_it_meets_every_row(seed):
    A, b = random_planes(seed)
    points = np.random.default_rng(seed + 1).uniform(BOUNDS[:, 0], BOUNDS[:, 1], (200, 2))
    clear = (np.abs(points @ A.T - b) > 1e-9).all(axis=1)  # leave out points on an edge
    inside = (points @ A.T <= b).all(axis=1)
    assert np.array_equal(polygon_contains(intersect_half_planes(A, b, BOUNDS), points)[clear], inside[clear])


@given(seeds)
def test_a_cut_and_its_opposite_share_the_area(seed):
    A, b = random_planes(seed, 1)
    whole = box_polygon(BOUNDS[:, 0], BOUNDS[:, 1])
    kept, lost = clip_polygon(whole, A[0], b[0]), clip_polygon(whole, -A[0], -b[0])
    assert np.isclose(polygon_area_m2(kept) + polygon_area_m2(lost), polygon_area_m2(whole))


@given(seeds)
def test_another_half_plane_never_enlarges_the_polygon(seed):
    A, b = random_planes(seed)
    areas = [polygon_area_m2(intersect_half_planes(A[:n], b[:n], BOUNDS)) for n in range(len(b) + 1)]
    assert (np.diff(areas) <= 1e-12).all()


@given(seeds, st.floats(-1e3, 1e3), st.floats(-1e3, 1e3))
def test_the_centroid_moves_with_the_polygon(seed, dx, dy):
    polygon = intersect_half_planes(*random_planes(seed, 3), BOUNDS)
    shift = np.array([dx, dy])
    if abs(polygon_area_m2(polygon)) > 1e-6:
        moved = polygon_centroid_m(polygon + shift)
        assert np.allclose(moved, polygon_centroid_m(polygon) + shift, atol=1e-6)
        assert polygon_contains(polygon, polygon_centroid_m(polygon)[None]).all()


def test_contradicting_half_planes_leave_nothing():
    polygon = intersect_half_planes(np.array([[1.0, 0.0], [-1.0, 0.0]]), np.array([-0.5, -0.5]), BOUNDS)
    assert len(polygon) == 0
    assert polygon_area_m2(polygon) == 0.0
    assert not polygon_contains(polygon, np.zeros((1, 2))).any()
