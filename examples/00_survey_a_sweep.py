"""Survey a sweep: where is every tag that an antenna passed?

An antenna slides along a 1 m rail past five tags, 20 cm apart, with a wall behind them. We let a simulated
reader listen, keep what it heard as a trace, forget the simulator, and locate the tags from the trace alone.

You will see a table of positions and their errors, and get `survey.html` with a picture of the rail, the tags
and the matched filter's image of one tag. Takes about 10 s the first time, while numba compiles.
"""

import sys
from pathlib import Path

import numpy as np

from rfcompass.localization import default_volume, sar_image, survey
from rfcompass.recordings import AntennaPoses, Trace, TraceMeta, TraceTag, open_trace, reads_table, write_trace
from rfcompass.simulation import SweepScene, simulate_sweep
from rfcompass.viz.page import PageFigure, write_page
from rfcompass.viz.sweep_figures import draw_image, draw_phase, draw_survey


def make_scene(fast: bool) -> SweepScene:
    """Five tags in a row, 0.7 m from the rail, 1.3 m in front of a wall."""
    tags_m = {f"30080000000000000000000{i}": np.array([0.1 + 0.2 * i, 0.7, 0.0]) for i in range(5)}
    poses = 25 if fast else 50
    rail_m = np.column_stack([np.linspace(0.0, 1.0, poses), np.zeros(poses), np.zeros(poses)])
    return SweepScene(tags_m=tags_m, antenna_positions_m=rail_m, frequencies_hz=np.linspace(920.6e6, 924.1e6, 4))


def record(scene: SweepScene, folder: Path, rng: np.random.Generator) -> None:
    """Let the simulated reader listen and write what it heard as a trace; the truth stays behind."""
    meta = TraceMeta(
        frame="rail",
        dimensions=2,
        tags=tuple(TraceTag(epc) for epc in scene.tags_m),
        source="simulated",
        license="Apache-2.0",
        reader="simulated",
    )
    reads = reads_table(simulate_sweep(scene, rng))
    trace = Trace(meta, reads, AntennaPoses.along(scene.antenna_positions_m))
    write_trace(trace, folder, overwrite=True)


def main(fast: bool = False, out: Path = Path("runs/00_survey")) -> dict[str, float]:
    """Simulate, record, locate, show; return the error of each tag [m]."""
    scene = make_scene(fast)
    out.mkdir(parents=True, exist_ok=True)
    record(scene, out / "trace", np.random.default_rng(7))

    scan = open_trace(out / "trace").scan()
    fixes = survey(scan)

    errors_m = {fix.epc: float(np.linalg.norm(fix.point_m - scene.tags_m[fix.epc])) for fix in fixes}
    print("simulated reads, truth known\n\nEPC                        x [m]   y [m]   error [cm]")
    for fix in fixes:
        print(f"{fix.epc}  {fix.point_m[0]:6.3f}  {fix.point_m[1]:6.3f}  {100 * errors_m[fix.epc]:6.1f}")

    middle = fixes[len(fixes) // 2]
    trace = scan.trace(middle.epc)
    figures = (
        PageFigure("Antenna path and located tags.", draw_survey(trace.antenna_positions_m, fixes, scan.frame)),
        PageFigure(
            "What the matched filter sees of one tag.",
            draw_image(sar_image(trace, default_volume(scan)), trace.antenna_positions_m, middle, scan.frame),
        ),
        PageFigure("The phase that it works on.", draw_phase(trace)),
    )
    write_page(out / "survey.html", "Survey of a simulated sweep", figures)
    print(f"\npicture: {out / 'survey.html'}   trace: {out / 'trace'}")
    return errors_m


if __name__ == "__main__":
    main(fast="--fast" in sys.argv)
