"""Dynamic time warping beside dtaidistance's C code, in one run on one thread, float64.

Run `python -m benchmarks.bench_dtw`; about 20 seconds, or one with `--fast`. Times are CPU times.
"""

import argparse
from collections.abc import Sequence

import numpy as np
from dtaidistance import __version__ as peer_version
from dtaidistance import dtw as peer

from benchmarks.timing import Timing, best_of, show
from rfcompass.arrays import FloatArray
from rfcompass.rf.dtw import dtw_matrix


def run(fast: bool = False) -> list[Timing]:
    """Warp every profile of one set onto every profile of another, without and with a band."""
    count, length, repeats = (8, 64, 1) if fast else (100, 256, 3)
    rng = np.random.default_rng(0)
    A, B = rng.normal(size=(2, count, length)).cumsum(axis=2)
    dtw_matrix(A[:1], B[:1])  # compile
    return [_compare(A, B, band, repeats) for band in (None, length // 10)]


def _compare(A: FloatArray, B: FloatArray, band: int | None, repeats: int) -> Timing:
    ours_s, ours = best_of(repeats, lambda: np.sqrt(dtw_matrix(A, B, band=band, cost="squared")))
    peer_s, theirs = best_of(repeats, lambda: _peer_matrix(A, B, band))
    size = f"{len(A)} x {len(B)} profiles of {A.shape[1]}"
    return Timing(
        name=f"DTW, {size}, " + ("free" if band is None else f"band {band}"),
        ours_s=ours_s,
        peer=f"dtaidistance {peer_version} (C)",
        peer_s=peer_s,
        agreement=float(np.abs(ours - theirs).max() / theirs.max()),
    )


def _peer_matrix(A: FloatArray, B: FloatArray, band: int | None) -> FloatArray:
    """Our band counts the steps off the diagonal, theirs the diagonal too."""
    P, Q = len(A), len(B)
    window = None if band is None else band + 1
    both = np.concatenate([A, B])
    square = peer.distance_matrix_fast(both, block=((0, P), (P, P + Q)), window=window, parallel=False)
    return np.asarray(square[:P, P:])


def main(argv: Sequence[str] | None = None) -> int:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--fast", action="store_true", help="tiny problem, to see that it works")
    show(run(parser.parse_args(argv).fast))
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
