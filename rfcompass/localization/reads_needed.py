"""How many reads a tag needs before its position can be asked for."""

import numpy as np

from rfcompass.errors import TooFewReads
from rfcompass.rf.runs import runs
from rfcompass.types.reads import ReadTrace

LEAST_DIFFERENCES = 8  # ours: three unknowns, and enough beside them to see that they fit


def require_reads(trace: ReadTrace) -> None:
    """Check that enough phase differences are free of the unknown constants.

    A channel that was heard at n positions of a run gives n - 1 differences.

    Raises:
        TooFewReads: If all runs and channels together give fewer than eight.
    """
    heard = [trace.mask[rows].sum(axis=0) for rows in runs(trace)]
    differences = int(sum(np.maximum(count - 1, 0).sum() for count in heard))
    if differences < LEAST_DIFFERENCES:
        raise TooFewReads(
            f"tag {trace.epc}: {trace.reads} reads give {differences} phase differences along the antenna path, "
            f"{LEAST_DIFFERENCES} are needed to locate it",
            epc=trace.epc,
            reads=trace.reads,
            differences=differences,
            needed=LEAST_DIFFERENCES,
        )
