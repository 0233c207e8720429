"""SAR images of 1e6 voxels from 200 antenna poses and 50 frequencies, beside plain numpy [Boroushaki2023], Eq. 1.

The peer computes the sum as it is printed: one exponential for each voxel, pose and frequency. It would take minutes,
so it gets a stated share of the voxels and its time is scaled up. Coarse to fine answers the question that the image is
for, where the peak is, and is compared with the peak of the full grid. The third row is the same grid for a commercial
reader, whose constant for each channel makes each of them a look of its own.

    OMP_NUM_THREADS=1 python -m benchmarks.bench_sar [--fast]
"""

import sys
from dataclasses import dataclass

import numpy as np

from benchmarks.timing import Timing, best_of, show
from rfcompass.localization import SarSurveyor, sar_image
from rfcompass.rf import SPEED_OF_LIGHT_M_S, Matching, build_hologram
from rfcompass.types import ReadTrace, SearchVolume

TAG_M = np.array([0.1137, -0.0712, 0.0521])  # on no grid


@dataclass(frozen=True)
class Size:
    """How much work: voxels along an edge, antenna poses, frequencies, and the peer's share of the voxels."""

    edge: int
    poses: int
    frequencies: int
    peer_share: float


FULL, TINY = Size(100, 200, 50, 0.002), Size(12, 20, 4, 0.1)


def sweep(size: Size) -> ReadTrace:
    """Noise-free reads of one tag from a square path 0.45 m above it, 0.5 m wide, over 200 MHz."""
    side = np.linspace(-0.25, 0.25, size.poses // 4, endpoint=False)
    edge, top = np.full(side.size, 0.25), np.full(4 * side.size, 0.5)
    x, y = np.concatenate([side, edge, -side, -edge]), np.concatenate([-edge, side, edge, -side])
    positions_m, f = np.column_stack([x, y, top]), np.linspace(800e6, 1000e6, size.frequencies)
    d = 2.0 * np.linalg.norm(positions_m - TAG_M, axis=1)
    h = np.exp(-2j * np.pi * np.outer(d, f) / SPEED_OF_LIGHT_M_S)
    ones = np.ones(h.shape, dtype=np.int64)
    return ReadTrace("tag", positions_m, f, h, ones, np.ones(len(d), dtype=np.int64))


def direct(trace: ReadTrace, points_m: np.ndarray, *, coherent: bool = True) -> np.ndarray:
    """|ΣΣ h exp(+j 2π f d / c)|², all channels coherent or each squared on its own, shape (P,)."""
    k = 2.0 * np.pi * trace.frequencies_hz / SPEED_OF_LIGHT_M_S
    power = np.empty(len(points_m))
    for p, d in enumerate(trace.round_trip_m(points_m)):
        sums = (trace.channel * np.exp(1j * np.outer(d, k))).sum(axis=0)
        power[p] = np.abs(sums.sum()) ** 2 if coherent else (np.abs(sums) ** 2).sum()
    return power


def run(fast: bool = False) -> list[Timing]:
    """Time the full grid and the search from coarse to fine."""
    size = TINY if fast else FULL
    trace, matching = sweep(size), Matching(coherent=True)
    low_m = np.array([-0.25, -0.25, 0.0])
    spacing_m = 0.5 / size.edge
    volume = SearchVolume(low_m, low_m + spacing_m * (size.edge - 1))
    surveyor = SarSurveyor(matching=matching)
    for each in (matching, Matching()):
        sar_image(trace, volume, spacing_m=spacing_m * 4, matching=each)  # compiles
    surveyor.locate(trace, volume)

    full_s, image = best_of(2, lambda: sar_image(trace, volume, spacing_m=spacing_m, matching=matching))
    fine_s, fix = best_of(3, lambda: surveyor.locate(trace, volume))
    voxels = image.values.size
    chosen = np.random.default_rng(0).choice(voxels, max(int(size.peer_share * voxels), 1), replace=False)
    points_m = low_m + spacing_m * np.column_stack(np.unravel_index(chosen, image.values.shape))
    peer_s, reference = best_of(1, lambda: direct(trace, points_m))
    peer_s *= voxels / chosen.size
    peak_m = low_m + spacing_m * np.array(np.unravel_index(image.values.argmax(), image.values.shape))
    difference = np.abs(image.values.ravel()[chosen] - reference).max() / image.values.max()
    peak = float(build_hologram(trace, volume, matching).power(fix.point_m[None])[0])
    peer = f"numpy, scaled up from {100 * chosen.size / voxels:.2g} % of the voxels"
    name = f"{voxels:.0e} voxels x {size.poses} x {size.frequencies}"
    apart_s, apart = best_of(1, lambda: sar_image(trace, volume, spacing_m=spacing_m, matching=Matching()))
    peer_apart_s, reference_apart = best_of(1, lambda: direct(trace, points_m, coherent=False))
    peer_apart_s *= voxels / chosen.size
    apart_off = np.abs(apart.values.ravel()[chosen] - reference_apart).max() / apart.values.max()
    missed = max(0.0, 1.0 - peak / float(image.values.max()))
    print(f"peak: full grid {peak_m}, coarse to fine {fix.point_m.round(4)}, truth {TAG_M}", file=sys.stderr)
    return [
        Timing(f"SAR full grid, {name}", full_s, peer, peer_s, float(difference)),
        Timing(f"SAR coarse to fine, {name}", fine_s, peer, peer_s, missed),
        Timing(f"SAR, a look per channel, {name}", apart_s, peer, peer_apart_s, float(apart_off)),
    ]


def main(argv: list[str]) -> None:
    """Print the table."""
    show(run("--fast" in argv))


if __name__ == "__main__":
    main(sys.argv[1:])
