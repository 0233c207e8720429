"""The one-way field of a stop: 13 tags x 150 antenna positions x 8 frequencies, walls to second order.

The peer is what one would write in numpy: every sequence of one or two walls, vectorised over positions, tags and
frequencies. It does walls only; for the furnished room with its scatterers, which is another answer and much more work,
the ratio is a bound.

    OMP_NUM_THREADS=1 python -m benchmarks.bench_channel [--fast]
"""

import itertools
import sys
from dataclasses import replace

import numpy as np

from benchmarks.timing import Timing, best_of, show
from rfcompass.rf import wavenumber
from rfcompass.simulation import (
    SQUIGGLE,
    VERT900,
    AntennaTrack,
    PlacedTags,
    RadioScene,
    Scatterers,
    load_recipe,
    one_way_field,
)


def reflected(e: np.ndarray, d: np.ndarray, axis: int, permittivity: float) -> tuple[np.ndarray, np.ndarray]:
    """Fresnel's reflection of field vectors e (..., 3) that travel along d (..., 3) at a plane across `axis`."""
    n = np.eye(3)[axis]
    s = np.cross(d, n)
    s /= np.linalg.norm(s, axis=-1, keepdims=True)
    back = d - 2.0 * d[..., axis, None] * n
    cosine = np.abs(d[..., axis])
    root = np.sqrt(permittivity - 1.0 + cosine**2)
    te, tm = (cosine - root) / (cosine + root), (permittivity * cosine - root) / (permittivity * cosine + root)
    across, within = (e * s).sum(-1), (e * np.cross(s, d)).sum(-1)
    return (te * across)[..., None] * s + (tm * within)[..., None] * np.cross(s, back), back


def numpy_field(
    size_m: np.ndarray, permittivity: float, track: AntennaTrack, tags: PlacedTags, k: np.ndarray
) -> np.ndarray:
    """Sum over the sequences of walls, shape (M, T, F)."""
    start, tag = track.positions_m[:, None], tags.points_m[None]
    planes = [(axis, side * size_m[axis]) for axis in range(3) for side in (0, 1)]
    h = np.zeros((len(track), len(tags), len(k)), dtype=complex)
    for n in range(3):
        for walls in itertools.product(planes, repeat=n):
            image = np.array(tag)
            for axis, place in reversed(walls):
                image = image.copy()
                image[..., axis] = 2.0 * place - image[..., axis]
            ray = image - start
            r = np.linalg.norm(ray, axis=-1)
            d, valid, at = ray / r[..., None], np.ones(r.shape, bool), np.broadcast_to(start, ray.shape)
            p = VERT900.vectors(np.ones(1, dtype=np.int64))[0]
            e = p - (d @ p)[..., None] * d
            target = image
            for axis, place in walls:
                run = target[..., axis] - at[..., axis]
                share = np.divide(place - at[..., axis], run, out=np.full(r.shape, -1.0), where=run != 0)
                at = at + share[..., None] * (target - at)
                others = [i for i in range(3) if i != axis]
                valid &= (share > 0) & (share <= 1)
                valid &= ((at[..., others] >= 0) & (at[..., others] <= size_m[others])).all(-1)
                e, d = reflected(e, d, axis, permittivity)
                target = target.copy()
                target[..., axis] = 2.0 * place - target[..., axis]
            amplitude = np.where(valid, (e * tags.dipoles[None]).sum(-1) / np.maximum(r, 0.05), 0.0)
            h += amplitude[..., None] * np.exp(-1j * r[..., None] * k)
    gain = 10.0 ** ((VERT900.gain_dbi + tags.model.gain_dbi + tags.gain_db) / 20.0)
    return h * gain[:, None] / (2.0 * k)


def run(fast: bool = False) -> list[Timing]:
    """Time bare walls and the furnished room."""
    M, T, F = (6, 2, 2) if fast else (150, 13, 8)
    rng = np.random.default_rng(0)
    furnished = load_recipe("room_los").draw(rng, part_m=(3.0, 3.0))
    bare = RadioScene(replace(furnished.scene, obstacles=()), Scatterers.none())
    track = AntennaTrack.line((1.5, 0.7, 0.3), (4.5, 0.7, 0.3), 3.0 / (M - 1))
    points_m, dipoles = rng.uniform((2.0, 2.0, 0.03), (4.0, 4.0, 0.3), (T, 3)), rng.normal(size=(T, 3))
    tags = PlacedTags.draw([f"{t:02x}" for t in range(T)], points_m, dipoles, SQUIGGLE, rng)
    f_hz = np.linspace(902e6, 928e6, F)

    def ours(scene: RadioScene) -> np.ndarray:
        return one_way_field(scene, track.positions_m, track.rotations, VERT900, tags, f_hz)[:, :, 0]

    ours(furnished)  # compiles
    bare_s, field = best_of(5, lambda: ours(bare))
    full_s, everything = best_of(5, lambda: ours(furnished))
    room = bare.scene.room
    permittivity = bare.scene.materials[room.wall_material].permittivity
    peer_s, expected = best_of(2, lambda: numpy_field(room.size_m, permittivity, track, tags, wavenumber(f_hz)))
    differ, more = (float(np.abs(h - expected).max() / np.abs(expected).max()) for h in (field, everything))
    size = f"{T} tags x {M} x {F}"
    return [
        Timing(f"channel, bare walls, {size}", bare_s, "numpy, vectorised", peer_s, differ),
        Timing(f"channel, furnished room, {size}", full_s, "numpy, vectorised, walls only", peer_s, more),
    ]


def main(argv: list[str]) -> None:
    """Print the table."""
    show(run("--fast" in argv))


if __name__ == "__main__":
    main(sys.argv[1:])
