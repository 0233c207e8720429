"""Record from a reader: an inventory over TCP becomes a trace, and the trace is surveyed.

No reader at hand? The emulated one stands behind the same LLRP protocol as a real one. Here it serves the reads of a
simulated R420 (four European channels, phases up to half a turn, outliers) that a carrier drives past four tags. The
carrier logs where it is; the recorder knows the antenna's place of each read from that log.

You will see what was recorded and where the tags are, and get `survey.png`. Takes 20 s. Needs the extra `llrp`.
"""

import sys
import time
from collections.abc import Iterator, Sequence
from itertools import groupby
from pathlib import Path

import numpy as np

from rfcompass import open_trace, survey
from rfcompass.recordings import CarrierLog, TraceMeta, record
from rfcompass.recordings.sources import EmulatedReader, LlrpSource
from rfcompass.simulation import RIG_R420_ETSI, SQUIGGLE, AntennaTrack, PlacedTags, load_recipe, simulate_inventory
from rfcompass.types import TagFix, TagRead
from rfcompass.viz.sweep_figures import draw_survey

TAGS_M = np.array([[2.1, 1.8, 0.5], [2.4, 1.9, 0.5], [2.7, 1.8, 0.5], [3.0, 1.9, 0.5]])
EPCS = [f"5246434f4d50415353ee000{i}" for i in range(len(TAGS_M))]


class DrivenReads:
    """A `ReadSource` that hands out the reads of one pose after the other, and logs where the carrier is meanwhile."""

    def __init__(self, reads: Sequence[TagRead], track: AntennaTrack, log: Path) -> None:
        """Take all reads, in the order of the track."""
        self.reads, self.track, self.log = reads, track, log

    def __iter__(self) -> Iterator[list[TagRead]]:
        """Stand still at each pose while its reads go out."""
        with self.log.open("w", buffering=1) as log:
            log.write("t_ns,antenna,x_m,y_m,z_m\n")
            for pose_id, of_pose in groupby(self.reads, key=lambda read: read.pose_id):
                row = ",".join(map(str, (1, *self.track.positions_m[pose_id])))
                log.write(f"{time.time_ns()},{row}\n")
                yield list(of_pose)
                time.sleep(0.02)  # what is under way arrives before the carrier moves
                log.write(f"{time.time_ns()},{row}\n")

    def places(self) -> CarrierLog:
        """Read the log once the carrier has written its last line."""
        time.sleep(0.1)
        return CarrierLog.read(self.log)


def main(fast: bool = False, out: Path = Path("runs/07_record")) -> dict[str, TagFix]:
    """Record over TCP, survey the trace and return where each tag is."""
    rng = np.random.default_rng(1)
    scene = load_recipe("room_los").draw(rng, part_m=(2.6, 1.9), keep_clear=[(2.6, 1.4, 0.9)])
    upright = np.tile([0.0, 0.0, 1.0], (len(EPCS), 1))
    tags = PlacedTags.draw(EPCS, TAGS_M, upright, SQUIGGLE, rng)
    track = AntennaTrack.line((2.0, 1.0, 0.5), (3.2, 1.0, 0.5), 0.04 if fast else 0.02, facing_m=(2.6, 3.0, 0.5))
    inventory = simulate_inventory(scene, RIG_R420_ETSI, track, tags, rng)

    out.mkdir(parents=True, exist_ok=True)
    reads, table_hz = inventory.reads(), RIG_R420_ETSI.frequencies_hz.tolist()
    driven = DrivenReads(reads, track, out / "carrier.csv")
    with EmulatedReader(driven, frequencies_hz=table_hz, rng=rng) as reader:
        source = LlrpSource(reader.host, reader.port, max_reads=len(reads))
        meta = TraceMeta(frame="room", phase_modulus="pi", reader="emulated", source="simulated: radio")
        done = record(source, out / "trace", meta=meta, carriage=driven.places, overwrite=True)
    print(f"sent {len(reads)} reads, recorded {done.reads} of {len(done.epcs)} tags: {done.path}")

    scan = open_trace(done.path).scan()
    fixes = {fix.epc: fix for fix in survey(scan)}
    for epc, truth_m in zip(EPCS, TAGS_M, strict=True):
        x, y, _ = 100 * (fixes[epc].point_m - truth_m)
        print(f"{epc}: {x:6.1f} cm along the path, {y:6.1f} cm across it")
    figure = draw_survey(next(iter(scan.traces.values())).antenna_positions_m, list(fixes.values()), scan.frame)
    figure.savefig(out / "survey.png", dpi=80 if fast else 150)
    print(f"picture: {out / 'survey.png'}")
    return fixes


if __name__ == "__main__":
    main(fast="--fast" in sys.argv)
