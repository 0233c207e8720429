"""`survey` reads the trace of a pile's scan."""

import numpy as np
import pytest

pytest.importorskip("mujoco", reason="the extra `piles` is not installed")

from rfcompass.recordings import write_trace
from rfcompass.simulation.piles import PileFamily, make_pile, scan_pile, tag_items
from rfcompass.studies.pile_scan import pile_trace, wrist_way


def test_every_tag_of_a_scan_is_located_in_the_frame_of_the_table(run, tmp_path):
    scene, way = make_pile(PileFamily("tiny", "covered", (4,)), 1, "hidden"), wrist_way("two")
    world, tags = scene.world(), tag_items(scene, "any", 2, np.random.default_rng(0))
    scan = scan_pile(world, tags, way.camera_poses, way.track, np.random.default_rng(0))
    write_trace(pile_trace(scan), tmp_path / "trace")
    answer = run("survey", tmp_path / "trace", "--method", "wrist", "--json").json
    assert answer["frame"] == "table"
    epcs, points_m, _ = tags.placed(world)
    found = {tag["epc"]: tag["point_m"] for tag in answer["tags"]}
    assert set(found) == set(epcs)
    off_m = [
        np.linalg.norm(np.array(found[epc])[:2] - point_m[:2]) for epc, point_m in zip(epcs, points_m, strict=True)
    ]
    assert max(off_m) < 0.15
