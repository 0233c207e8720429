"""Convex polygons in the plane, as vertex lists in counter-clockwise order."""

import numpy as np

from rfcompass.arrays import BoolArray, FloatArray


def box_polygon(lower_m: FloatArray, upper_m: FloatArray) -> FloatArray:
    """Corners of an axis-parallel rectangle, counter-clockwise [m], shape (4, 2)."""
    (x0, y0), (x1, y1) = lower_m, upper_m
    return np.array([[x0, y0], [x1, y0], [x1, y1], [x0, y1]])


def clip_polygon(vertices_m: FloatArray, a: FloatArray, b: float) -> FloatArray:
    """Cut a convex polygon with the half-plane a · p <= b (Sutherland and Hodgman, 1974).

    Args:
        vertices_m: Vertices [m], counter-clockwise, shape (V, 2).
        a: Normal of the half-plane, shape (2,).
        b: Right-hand side.

    Returns:
        Vertices of the intersection, shape (V', 2); V' = 0 if nothing is left.
    """
    if len(vertices_m) == 0:
        return vertices_m
    excess = vertices_m @ a - b
    kept: list[FloatArray] = []
    for i, (p, e_p) in enumerate(zip(vertices_m, excess, strict=True)):
        q, e_q = vertices_m[(i + 1) % len(vertices_m)], excess[(i + 1) % len(vertices_m)]
        if e_p <= 0:
            kept.append(p)
        if (e_p < 0 < e_q) or (e_q < 0 < e_p):
            kept.append(p + e_p / (e_p - e_q) * (q - p))
    return np.array(kept).reshape(-1, 2)


def intersect_half_planes(A: FloatArray, b: FloatArray, bounds_m: FloatArray) -> FloatArray:
    """Polygon {p : A p <= b} inside a bounding rectangle.

    Args:
        A: Normals, shape (M, 2).
        b: Right-hand sides, shape (M,).
        bounds_m: Rectangle [m], [[xmin, xmax], [ymin, ymax]], shape (2, 2).

    Returns:
        Vertices [m], counter-clockwise, shape (V, 2); V = 0 if the intersection is empty.
    """
    polygon = box_polygon(bounds_m[:, 0], bounds_m[:, 1])
    for a_row, b_row in zip(A, b, strict=True):
        polygon = clip_polygon(polygon, a_row, float(b_row))
    return polygon


def polygon_area_m2(vertices_m: FloatArray) -> float:
    """Signed area by the shoelace formula [m²]; positive if counter-clockwise."""
    if len(vertices_m) < 3:
        return 0.0
    x, y = vertices_m.T
    return 0.5 * float(x @ np.roll(y, -1) - y @ np.roll(x, -1))


def polygon_centroid_m(vertices_m: FloatArray) -> FloatArray:
    """Centre of mass of the area [m], shape (2,); the mean vertex if the polygon has no area."""
    if abs(polygon_area_m2(vertices_m)) < 1e-18:
        return np.asarray(vertices_m.mean(axis=0))
    local = vertices_m - vertices_m[0]  # keeps the products small far from the origin
    nxt = np.roll(local, -1, axis=0)
    cross = local[:, 0] * nxt[:, 1] - local[:, 1] * nxt[:, 0]
    return np.asarray(vertices_m[0] + ((local + nxt) * cross[:, None]).sum(axis=0) / (3.0 * cross.sum()))


def polygon_contains(vertices_m: FloatArray, points_m: FloatArray, tolerance_m: float = 0.0) -> BoolArray:
    """Tell which points lie in a convex polygon, or within `tolerance_m` of it along the edge normals.

    Args:
        vertices_m: Vertices [m], counter-clockwise, shape (V, 2).
        points_m: Points [m], shape (P, 2).
        tolerance_m: Distance outside an edge that still counts as inside [m].

    Returns:
        Shape (P,). All False for a polygon without area.
    """
    if len(vertices_m) < 3:
        return np.zeros(len(points_m), dtype=np.bool_)
    edges = np.roll(vertices_m, -1, axis=0) - vertices_m
    edges, starts = edges[np.hypot(*edges.T) > 0], vertices_m[np.hypot(*edges.T) > 0]
    normals = np.column_stack([edges[:, 1], -edges[:, 0]]) / np.hypot(*edges.T)[:, None]
    return np.asarray((points_m @ normals.T <= (starts * normals).sum(axis=1) + tolerance_m).all(axis=1))
