"""From the records of a scan to the map of where the target can be: 8 views and 10 tags of a simulated pile.

Everything that an arm has to wait for is timed, on one thread: every tag located by the matched filter with its box and
advice, 8 views into the map C, kernels, sum and convolution. The peer does the same in numpy and scipy: Eq. 1 of
[Boroushaki2023] at all points of a 2 cm grid in one matrix product, then at 5 mm about the peak, without a box; all
voxels into each image at once; `scipy.signal.fftconvolve`.

    OMP_NUM_THREADS=1 python -m benchmarks.bench_pile_scan [--fast]
"""

import resource
import sys

import numpy as np
from scipy.signal import fftconvolve

from benchmarks.bench_mapping import numpy_radio, numpy_view
from benchmarks.timing import Timing, best_of, show
from rfcompass.arrays import FloatArray
from rfcompass.mapping import fuse_maps, gaussian_target, map_views, occupancy_map, rf_certainty_map
from rfcompass.mapping.view_kernels import FREE, OUTSIDE, SURFACE, UNOBSERVED
from rfcompass.rf.waves import SPEED_OF_LIGHT_M_S
from rfcompass.simulation.piles import PileScan, TaggedItems, make_pile, scan_pile, tag_items
from rfcompass.studies.pile_scan import SEARCH, located, workspace, wrist_way
from rfcompass.types import ItemSize, LocatedItem, TagFix
from rfcompass.types.reads import ReadTrace

TAGS, VIEWS = 10, 8


def scanned(fast: bool) -> tuple[PileScan, TaggedItems]:
    """A scan with ten tags: eight views, two rounds of the antennas."""
    rng, way = np.random.default_rng(0), wrist_way("two")
    scene = make_pile("covered_2p20", 2, "open")
    tags = tag_items(scene, "any", 4 if fast else TAGS, rng)
    return scan_pile(scene.world(), tags, way.camera_poses, way.track, rng), tags


def items_of(fixes: list[TagFix], sizes: tuple[ItemSize, ...]) -> list[LocatedItem]:
    """Look up what each tag hangs on; all count here."""
    by_epc = {size.epc: size for size in sizes}
    return [
        LocatedItem(
            TagFix(fix.epc, fix.point_m, fix.box_m, True),
            by_epc[fix.epc].name,
            by_epc[fix.epc].shortest_m,
            by_epc[fix.epc].longest_m,
            by_epc[fix.epc].deformable,
        )
        for fix in fixes
    ]


def ours(scan: PileScan, tags: TaggedItems, spacing_m: float) -> tuple[FloatArray, FloatArray]:
    """Locate and map; where the tags are [m], shape (T, 3), and the final map."""
    epcs = [tag.epc for tag in tags.tags]
    found = located(scan.scan(epcs), epcs)
    seen = map_views(workspace(spacing_m), scan.views)
    radio = rf_certainty_map(
        items_of(list(found.fixes.values()), tags.sizes), seen.workspace, heights_m=seen.heights_m()
    )
    target = gaussian_target(tags.target_size.shortest_m, tags.target_size.longest_m, spacing_m)
    occupancy = occupancy_map(fuse_maps(seen.uncertainty(), radio.grid), target)
    return np.array([found.fixes[epc].point_m for epc in epcs]), occupancy.values


def numpy_power(trace: ReadTrace, points_m: FloatArray) -> FloatArray:
    """Eq. 1 at points (P, 3), all carriers at once, shape (P,)."""
    there = np.linalg.norm(points_m[:, None] - trace.tx_positions_m[None], axis=2)
    round_m = there + np.linalg.norm(points_m[:, None] - trace.antenna_positions_m[None], axis=2)
    total = np.zeros(len(points_m), dtype=np.complex128)
    for f, f_hz in enumerate(trace.frequencies_hz):
        heard = np.nan_to_num(trace.channel[:, f])
        total += np.exp(2j * np.pi * f_hz / SPEED_OF_LIGHT_M_S * round_m) @ heard
    return np.abs(total) ** 2


def numpy_place(trace: ReadTrace) -> FloatArray:
    """Peak on a coarse grid, then on a fine one about it [m], shape (3,)."""
    low_m, high_m, best_m = SEARCH.lower_m, SEARCH.upper_m, np.zeros(3)
    for step_m, half_m in ((0.02, None), (0.005, 0.02)):
        if half_m is not None:
            low_m, high_m = np.maximum(best_m - half_m, SEARCH.lower_m), np.minimum(best_m + half_m, SEARCH.upper_m)
        axes = [np.arange(a, b + 1e-9, step_m) for a, b in zip(low_m, high_m, strict=True)]
        points_m = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
        power = np.concatenate(
            [numpy_power(trace, part) for part in np.array_split(points_m, len(points_m) // 4096 + 1)]
        )
        best_m = points_m[power.argmax()]
    return best_m


def peers(scan: PileScan, tags: TaggedItems, spacing_m: float) -> tuple[FloatArray, FloatArray]:
    """The same with numpy and scipy, rigid kernels for all."""
    epcs, table = [tag.epc for tag in tags.tags], workspace(spacing_m)
    reads = scan.scan(epcs)
    places_m = np.array([numpy_place(reads.trace(epc)) for epc in epcs])
    state = np.full(table.shape, OUTSIDE, dtype=np.uint8)
    for view in scan.views:
        state = np.maximum(state, numpy_view(table, view))
    fixes = [TagFix(epc, place_m, np.full(3, 0.1), True) for epc, place_m in zip(epcs, places_m, strict=True)]
    fused = np.maximum((state == UNOBSERVED) + numpy_radio(table, items_of(fixes, tags.sizes)), 0.0)
    target = gaussian_target(tags.target_size.shortest_m, tags.target_size.longest_m, spacing_m)
    return places_m, fftconvolve(fused, target.values, mode="same")


def run(fast: bool = False) -> list[Timing]:
    """Time both sizes of voxels; "differ" is the median distance of the places of the tags [m]."""
    assert OUTSIDE < UNOBSERVED < FREE < SURFACE  # the peer takes the largest
    scan, tags = scanned(fast)
    ours(scan, tags, 0.01)
    timings = []
    peer_s, (places_m, _) = best_of(1, lambda: peers(scan, tags, 0.01))
    for spacing_m in (0.01,) if fast else (0.01, 0.005):
        our_s, (found_m, _) = best_of(1 if fast else 3, lambda spacing_m=spacing_m: ours(scan, tags, spacing_m))
        off_m = float(np.median(np.linalg.norm(found_m - places_m, axis=1)))
        what = f"{VIEWS} views, {len(tags.tags)} tags, {1000 * spacing_m:.0f} mm"
        timings.append(Timing(what, our_s, "numpy and scipy, no boxes, 10 mm", peer_s, off_m))
    peak_mb = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / (1e6 if sys.platform == "darwin" else 1e3)
    print(f"largest memory of the process, with simulator and peer: {peak_mb:.0f} MB", file=sys.stderr)
    return timings


def main(argv: list[str]) -> None:
    """Print the table."""
    show(run("--fast" in argv))


if __name__ == "__main__":
    main(sys.argv[1:])
