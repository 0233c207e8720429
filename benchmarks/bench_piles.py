"""The pile world: making a scene, and one depth image of it beside two peers.

Rays of one image of 320 x 240 pixels: MuJoCo's `mj_multiRay` in our camera, beside Embree through trimesh (`embreex`)
on the pile as triangles, built anew as the pile changes with every action, and without building; and beside numpy, box
by box and panel by panel, without the round items, which we see as well. "Differ" is the difference of depths [m]:
for Embree the 99th percentile, as round items are triangles there; for numpy the largest, where a box is seen.

Making a scene and letting it stand have no peer; 2 s of real time stand beside them.

Run `python -m benchmarks.bench_piles`; a minute.
"""

import argparse
import time
from collections.abc import Sequence

import numpy as np
import trimesh

from benchmarks.timing import Timing, best_of, show
from rfcompass.arrays import FloatArray
from rfcompass.simulation.piles import CameraModel, PileWorld, cast_image, look_down, make_pile

CAMERA = CameraModel(width=320, height=240)
EYE = look_down(0.0, 0.0, 0.7)
FIRST_SEED = 1


def run(fast: bool = False) -> list[Timing]:
    """Make scenes of two sizes, and look at each."""
    lines = []
    for family in ("covered_1p10",) if fast else ("covered_1p10", "covered_3p25"):
        start = time.process_time()
        scene = make_pile(family, FIRST_SEED, "open")
        made_s, world = time.process_time() - start, scene.world()
        moved_s, _ = best_of(1, lambda world=world: world.creep_m(2.0))
        lines.append(Timing(f"make {family}, {scene.tries} tries", made_s, "2 s of real time", 2.0, np.nan))
        lines.append(Timing(f"2 s of {len(scene.items)} items at rest", moved_s, "2 s of real time", 2.0, np.nan))
        lines += views(world, 1 if fast else 5)
    return lines


def views(world: PileWorld, repeats: int) -> list[Timing]:
    """One image of a pile by each way."""
    what = f"320 x 240 rays, {len(world.items)} items"
    ours_s, image = best_of(repeats, lambda: cast_image(world, CAMERA, EYE))
    mesh = triangles(world)
    rays = (CAMERA.directions() @ EYE[:3, :3].T).reshape(-1, 3)
    fresh_s, _ = best_of(repeats, lambda: embree(triangles(world), rays))
    embree(mesh, rays)
    cast_s, depth_m = best_of(repeats, lambda: embree(mesh, rays))
    off_m = float(np.nanpercentile(np.abs(depth_m - image.depth_m.reshape(-1)), 99))
    slabs_s, slab_m = best_of(repeats, lambda: slabs(world, rays))
    flat = np.isin(image.numbers.reshape(-1), [i.number for i in world.items if i.kind in ("box", "cover")])
    slab_off_m = float(np.abs(slab_m - image.depth_m.reshape(-1))[flat & (slab_m > 0)].max())
    return [
        Timing(what, ours_s, "embree, mesh built anew", fresh_s, off_m),
        Timing(what, ours_s, "embree, mesh at hand", cast_s, off_m),
        Timing(f"{what}, boxes", ours_s, "numpy, box by box", slabs_s, slab_off_m),
    ]


def triangles(world: PileWorld) -> trimesh.Trimesh:
    """The pile as one surface."""
    pieces = [trimesh.creation.box((2.0, 2.0, 0.001), trimesh.transformations.translation_matrix((0, 0, -0.0005)))]
    for item in world.items:
        x, y, z = item.panel_size_m
        for T in world.panel_poses(item.number):
            match item.kind:
                case "cylinder":
                    piece = trimesh.creation.cylinder(x / 2, z, sections=32)
                case "capsule":
                    piece = trimesh.creation.capsule(z - x, x / 2, count=[32, 32])
                    piece.apply_translation(-piece.bounds.mean(axis=0))
                case "ellipsoid":
                    piece = trimesh.creation.icosphere(3, 0.5)
                    piece.apply_scale((x, y, z))
                case _:
                    piece = trimesh.creation.box((x, y, z))
            pieces.append(piece.apply_transform(T))
    return trimesh.util.concatenate(pieces)


def embree(mesh: trimesh.Trimesh, rays: FloatArray) -> FloatArray:
    """Depth along the optical axis by Embree, NaN where nothing is [m], shape (R,)."""
    eyes = np.tile(EYE[:3, 3], (len(rays), 1))
    places, which, _ = mesh.ray.intersects_location(eyes, rays, multiple_hits=False)
    depth_m = np.full(len(rays), np.nan)
    depth_m[which] = (places - EYE[:3, 3]) @ EYE[:3, 2]
    return depth_m


def slabs(world: PileWorld, rays: FloatArray) -> FloatArray:
    """Depth of the boxes and covers alone by numpy; infinite where none is [m], shape (R,)."""
    nearest_m = np.full(len(rays), np.inf)
    for item in world.items:
        if item.kind not in ("box", "cover"):
            continue
        half = item.panel_size_m / 2
        for T in world.panel_poses(item.number):
            eye, along = (EYE[:3, 3] - T[:3, 3]) @ T[:3, :3], rays @ T[:3, :3]
            with np.errstate(divide="ignore"):
                a, b = (-half - eye) / along, (half - eye) / along
            enter, leave = np.minimum(a, b).max(axis=1), np.maximum(a, b).min(axis=1)
            nearest_m = np.where((enter <= leave) & (enter > 0), np.minimum(nearest_m, enter), nearest_m)
    return nearest_m


def main(argv: Sequence[str] | None = None) -> int:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--fast", action="store_true", help="one small pile, to see that it works")
    show(run(parser.parse_args(argv).fast))
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
