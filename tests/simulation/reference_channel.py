"""The one-way field, slowly: paths found wall by wall, vectors reflected by the book. Written from the equations of
`docs/channel.md`, not from the kernels."""

import itertools

import numpy as np

from rfcompass.rf.waves import wavenumber
from rfcompass.types.shapes import Box

NEAREST_M = 0.05


def planes(room, materials):
    """(axis, place, permittivity) of the six surfaces; a conductor has infinite permittivity."""
    if room is None:
        return []
    found = []
    for axis, pair in enumerate(room.surfaces):
        for side, name in enumerate(pair):
            material = materials[name]
            found.append((axis, side * room.size_m[axis], np.inf if material.conductor else material.permittivity))
    return found


def mirrored(point, plane):
    image = np.array(point, dtype=float)
    image[plane[0]] = 2.0 * plane[1] - image[plane[0]]
    return image


def path(start, end, bounces, size_m):
    """Corners of the path that bounces off the given planes in turn, or None if there is no such path."""
    image = np.array(end, dtype=float)
    for plane in reversed(bounces):
        image = mirrored(image, plane)
    corners, at, target = [np.array(start, dtype=float)], np.array(start, dtype=float), image
    for plane in bounces:
        axis, place, _ = plane
        run = target[axis] - at[axis]
        if run == 0 or not 0 < (share := (place - at[axis]) / run) <= 1:
            return None
        at = at + share * (target - at)
        others = [i for i in range(3) if i != axis]
        if any(not 0 <= at[i] <= size_m[i] for i in others):
            return None
        corners.append(at)
        target = mirrored(target, plane)
    return [*corners, np.array(end, dtype=float)]


def fresnel(e, d, plane):
    """Reflect a field and its direction at a plane."""
    axis, _, permittivity = plane
    n = np.eye(3)[axis]
    s = np.cross(d, n)
    s = np.eye(3)[(axis + 1) % 3] if np.linalg.norm(s) < 1e-12 else s / np.linalg.norm(s)
    d_out = d - 2.0 * (d @ n) * n
    cosine = abs(d @ n)
    if np.isinf(permittivity):
        te, tm = -1.0, 1.0
    else:
        root = np.sqrt(permittivity - (1.0 - cosine**2))
        te, tm = (cosine - root) / (cosine + root), (permittivity * cosine - root) / (permittivity * cosine + root)
    return te * (e @ s) * s + tm * (e @ np.cross(s, d)) * np.cross(s, d_out), d_out


def chord(a, b, obstacle):
    """Length of the segment a b inside an obstacle, by cutting it into its parts at every surface."""
    T = obstacle.T_scene_obstacle
    a, b = (T[:3, :3].T @ (p - T[:3, 3]) for p in (a, b))
    half, cuts = obstacle.shape.upper_m, [0.0, 1.0]
    flat = range(3) if isinstance(obstacle.shape, Box) else ["xyz".index(obstacle.shape.axis)]
    for axis in flat:
        if b[axis] != a[axis]:
            cuts += [(side * half[axis] - a[axis]) / (b[axis] - a[axis]) for side in (-1, 1)]
    if not isinstance(obstacle.shape, Box):
        round_ = [i for i in range(3) if i not in flat]
        o, v = a[round_], (b - a)[round_]
        roots = np.roots([v @ v, 2 * o @ v, o @ o - obstacle.shape.radius_m**2]) if v @ v > 0 else []
        cuts += [root.real for root in roots if abs(root.imag) < 1e-12]
    cuts = sorted(cut for cut in cuts if 0 <= cut <= 1)
    inside = 0.0
    for low, high in itertools.pairwise(cuts):
        p = a + 0.5 * (low + high) * (b - a)
        if isinstance(obstacle.shape, Box):
            within = (np.abs(p) <= half).all()
        else:
            within = np.linalg.norm(p[round_]) <= obstacle.shape.radius_m and abs(p[flat[0]]) <= half[flat[0]]
        inside += (high - low) * within
    return inside * np.linalg.norm(b - a)


def legs_cost(corners, scene):
    """Amplitude that obstacles leave on all legs, and the extra electrical length."""
    loss_db, extra_m = 0.0, 0.0
    for a, b in itertools.pairwise(corners):
        for obstacle in scene.obstacles:
            material, t = scene.materials[obstacle.material], chord(a, b, obstacle)
            if t > 1e-9:
                loss_db += material.surface_loss_db + material.loss_db_per_m * t
                extra_m += material.delay_ratio * t
    return 10.0 ** (-loss_db / 20.0), extra_m


def launch(antenna, p, boresight, d):
    """Field of an antenna with polarisation vector p along d."""
    across = p - (p @ d) * d
    if antenna.pattern == "isotropic":
        return across / np.linalg.norm(across)
    if antenna.pattern == "dipole":
        return across
    front = ((1.0 + boresight @ d) / 2.0) ** antenna.exponent
    return (antenna.back_field + (1.0 - antenna.back_field) * front) * across


def arriving(start, end, launched, radio_scene, order, k, least_m):
    """Σ over paths of e e^{-jkL} / r at the end, shape (3,)."""
    scene = radio_scene.scene
    total, walls = np.zeros(3, dtype=complex), planes(scene.room, scene.materials)
    for n in range(order + 1 if walls else 1):
        for bounces in itertools.product(walls, repeat=n):
            corners = path(start, end, bounces, None if scene.room is None else scene.room.size_m)
            if corners is None:
                continue
            length = sum(np.linalg.norm(b - a) for a, b in itertools.pairwise(corners))
            d = (corners[1] - corners[0]) / np.linalg.norm(corners[1] - corners[0])
            e = launched(d)
            for plane in bounces:
                e, d = fresnel(e, d, plane)
            left, extra_m = legs_cost(corners, scene)
            total += e * left * np.exp(-1j * k * (length + extra_m)) / max(length, least_m)
    return total


def reference_field(radio_scene, track, antenna, tags, frequencies_hz):
    """The same as `one_way_field`, shape (M, T, P, F)."""
    k_all, axes = wavenumber(np.asarray(frequencies_hz)), tags.axes()
    vectors = np.einsum("mij,mj->mi", track.rotations, antenna.vectors(track.ports))
    h = np.zeros((len(track), len(tags), axes.shape[1], len(k_all)), dtype=complex)
    scatterers = radio_scene.scatterers
    for (m, t, p, f), _ in np.ndenumerate(h):
        start, tag, u, k = track.positions_m[m], tags.points_m[t], axes[t, p], k_all[f]

        def launched(d, m=m):
            return launch(antenna, vectors[m], track.rotations[m][:, 0], d)

        def dipole(d, u=u):
            return (u - (u @ d) * d).astype(complex)

        total = arriving(start, tag, launched, radio_scene, radio_scene.order, k, NEAREST_M) @ u
        for s in range(len(scatterers)):
            size = np.sqrt(scatterers.cross_section_m2[s] / (4.0 * np.pi))
            point, least_m, order = scatterers.points_m[s], max(NEAREST_M, size), min(1, radio_scene.order)
            a = arriving(start, point, launched, radio_scene, order, k, least_m)
            b = arriving(tag, point, dipole, radio_scene, order, k, least_m)
            total += size * np.exp(1j * scatterers.phase_rad[s]) * (b @ scatterers.matrices()[s] @ a)
        gain = 10.0 ** ((antenna.gain_dbi + tags.model.gain_dbi + tags.gain_db[t]) / 20.0)
        h[m, t, p, f] = gain * total / (2.0 * k)
    return h
