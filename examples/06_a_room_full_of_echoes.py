"""A room full of echoes: what a sliding antenna hears of one tag in free space and in the furnished room.

The same tag, the same slide, the same reader; once nothing else, once walls, desks, chairs and scatterers.

You will see how often the tag was read, how far the level swings, and how far its near-field image is off with one
straight slide, and get `echoes.png`. Takes 5 s.
"""

import sys
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from rfcompass.rf import SarNearfieldMeter
from rfcompass.simulation import (
    RIG_PAPER,
    SQUIGGLE,
    AntennaTrack,
    PlacedTags,
    inventory_scan,
    load_recipe,
    simulate_inventory,
)
from rfcompass.types import ReadTrace

TAG_M = np.array([3.2, 2.8, 0.10])
EPC = "5246434f4d50415353ff0001"


def listen(room: str) -> ReadTrace:
    """Slide past the tag once, in a room of that recipe."""
    rng = np.random.default_rng(4)
    scene = load_recipe(room).draw(rng, part_m=(3.2, 2.8))
    tag = PlacedTags.draw([EPC], TAG_M[None], np.array([[0.0, 0.0, 1.0]]), SQUIGGLE, rng)
    track = AntennaTrack.line((1.5, 0.7, 0.3), (4.5, 0.7, 0.3))
    return inventory_scan(simulate_inventory(scene, RIG_PAPER, track, tag, rng), [EPC]).trace(EPC)


def main(fast: bool = False, out: Path = Path("runs/06_echoes")) -> dict[str, float]:
    """Listen in both rooms; return how far off the image is in each [m]."""
    figure = Figure(figsize=(8, 5), layout="constrained")
    level, phase = figure.subplots(2, 1, sharex=True)
    errors_m = {}
    for room, colour in (("free_space", "#3b6ea5"), ("room_los", "#d1495b")):
        trace = listen(room)
        first = trace.tx_positions_m[:, 0] == trace.tx_positions_m[0, 0]  # positions lit by the first transmitter
        x_m, h = trace.antenna_positions_m[first, 0], trace.channel[first, 0]
        place_m = SarNearfieldMeter().place(trace, height_m=float(TAG_M[2]))
        errors_m[room] = float(np.linalg.norm(place_m - TAG_M))
        dbm = 20.0 * np.log10(np.abs(h))
        swing_db, off_cm = np.ptp(dbm), 100 * errors_m[room]
        print(f"{room:<10} {trace.reads} reads, level swings {swing_db:4.1f} dB, image {off_cm:5.1f} cm off")
        level.plot(x_m, dbm, color=colour, label=room)
        phase.plot(x_m, np.unwrap(-np.angle(h)), color=colour, label=room)
    level.set_ylabel("level [dBm]")
    phase.set_ylabel("unwrapped phase lag [rad]")
    phase.set_xlabel("antenna along the slide, x [m]")
    level.set_title("One tag, heard along a slide of 3 m", loc="left")
    level.legend(frameon=False)
    out.mkdir(parents=True, exist_ok=True)
    figure.savefig(out / "echoes.png", dpi=80 if fast else 150)
    print(f"picture: {out / 'echoes.png'}")
    return errors_m


if __name__ == "__main__":
    main(fast="--fast" in sys.argv)
