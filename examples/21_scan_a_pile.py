"""Scan a pile with camera and antennas on one arm, locate its tags, and map where the hidden target can be.

A UR5e goes round the table at two heights: eight depth images, and reads of every tag through the things that lie over
it. You will see how far off each tag is, how well the paper's map and the posterior know where the target is, with and
without tags, and get `maps.png`, `scan.html` (pile, arm, the antenna's way, tags with their confidence boxes, all maps
as layers), and `trace/`, which `rfcompass survey` reads. Needs MuJoCo (`pip install -c constraints.txt '.[piles]'`).
Takes 20 s.
"""

import sys
from dataclasses import replace
from pathlib import Path

import numpy as np

from rfcompass.evaluation.map_quality import map_quality
from rfcompass.localization import LocatedTags
from rfcompass.mapping import (
    fuse_maps,
    gaussian_target,
    located_items,
    map_views,
    occupancy_map,
    posterior_map,
    rf_certainty_map,
    tagged_items,
)
from rfcompass.recordings import write_trace
from rfcompass.simulation.piles import PileFamily, PileWorld, TaggedItems, drawn_shapes, make_pile, scan_pile, tag_items
from rfcompass.studies.pile_scan import T_WORLD_BASE, WristWay, located, pile_trace, workspace, wrist_way
from rfcompass.types import Configuration, VoxelGrid
from rfcompass.viz.meshcat_page import write_scene
from rfcompass.viz.overlay import Layer, Overlay
from rfcompass.viz.robot_scene import RobotScene
from rfcompass.viz.tag_boxes import tag_boxes
from rfcompass.viz.voxel_figures import draw_maps
from rfcompass.viz.voxel_layers import draw_voxels

SMALL = PileFamily("small", "covered", (4,))


def tell_tags(found: LocatedTags, tags: TaggedItems, world: PileWorld) -> None:
    """Print a line for each tag."""
    names = {size.epc: size.name for size in tags.sizes}
    for epc, point_m, _ in zip(*tags.placed(world), strict=True):
        if epc in found.refusals:
            print(f"  {names[epc]:<14} {found.refusals[epc].message}")
            continue
        fix = found.fixes[epc]
        off_cm, box_cm = 100 * np.linalg.norm(fix.point_m - point_m), " x ".join(f"{100 * s:.0f}" for s in fix.box_m)
        print(f"  {names[epc]:<14} {off_cm:4.1f} cm off, box {box_cm} cm{'' if fix.confident else ', not confident'}")


def page(world: PileWorld, way: WristWay, found: LocatedTags, maps: dict[str, VoxelGrid], path: Path) -> None:
    """Write everything as one page with layers."""
    scene = RobotScene()
    scene.look_at(np.array([0.0, 0.0, 0.05]), np.array([0.7, 0.7, 0.6]))
    scene.draw_shapes("pile", drawn_shapes(world, opacity=0.35))
    arm = way.robot.visual_shapes(Configuration(way.motion.path[0]))
    shapes = [replace(s, link=f"{s.link}_{n}", T_world_shape=T_WORLD_BASE @ s.T_world_shape) for n, s in enumerate(arm)]
    scene.draw_shapes("arm", shapes)
    for node, points_m in (("antenna", way.track.positions_m), ("camera", way.camera_poses[:, :3, 3])):
        scene.draw_points(f"way/{node}", points_m, np.tile([0.1, 0.5, 0.3], (len(points_m), 1)), 0.012)
    scene.draw_shapes("tags", tag_boxes(found.fixes.values()))
    layers = [
        Layer("pile", "pile", None, len(world.items)),
        Layer("arm", "arm", None),
        Layer("antenna and camera", "way", None),
        Layer("tags, confidence boxes", "tags", None, len(found.fixes)),
        *(
            draw_voxels(scene, f"map_{n}", name, grid, share=0.3, shown=n == len(maps) - 1)
            for n, (name, grid) in enumerate(maps.items())
        ),
    ]
    write_scene(path, scene.window, "A scan of a pile", Overlay("A scan of a pile", (), tuple(layers)))


def main(fast: bool = False, out: Path = Path("runs/21_scan")) -> float:
    """Plan, scan, locate, map; return the log-loss of the posterior with tags [bit]."""
    rng, way = np.random.default_rng(0), wrist_way("one" if fast else "two")
    print(f"{len(way.motion.path)} waypoints, nothing nearer than {1000 * way.motion.report.at_least_m:.1f} mm")
    scene = make_pile(SMALL if fast else "poured_1p10", 3, "hidden")
    world, tags = scene.world(), tag_items(scene, "any", 2 if fast else 6, rng)
    scan = scan_pile(world, tags, way.camera_poses, way.track, rng)
    out.mkdir(parents=True, exist_ok=True)
    write_trace(pile_trace(scan), out / "trace", overwrite=True)

    epcs = [tag.epc for tag in tags.tags]
    found = located(scan.scan(epcs), epcs)
    print(f"{len(scan.inventory)} samples of {len(epcs)} tags; try: rfcompass survey {out / 'trace'} --method wrist")
    tell_tags(found, tags, world)

    seen = map_views(workspace(0.02 if fast else 0.01), scan.views)
    radio = rf_certainty_map(
        located_items(found.fixes.values(), tags.sizes), seen.workspace, heights_m=seen.heights_m()
    )
    target = gaussian_target(tags.target_size.shortest_m, tags.target_size.longest_m, seen.workspace.spacing_m)
    visual = seen.uncertainty()
    maps = {
        "C": visual,
        "R": radio.grid,
        "occupancy": occupancy_map(fuse_maps(visual, radio.grid), target),
        "posterior": posterior_map(seen, tags.target_size, tagged_items(found.fixes.values(), tags.sizes)),
    }
    true_m = world.pose(scene.target)[:3, 3]
    judged = {
        "C": visual,
        "occupancy, cameras alone": occupancy_map(visual, target),
        "occupancy": maps["occupancy"],
        "posterior, cameras alone": posterior_map(seen, tags.target_size),
        "posterior": maps["posterior"],
    }
    for name, grid in judged.items():
        quality = map_quality(grid, true_m, seen.unobserved)
        print(f"  {name:<26} {quality.bits:5.2f} bit, {100 * quality.rank:4.1f} % of hidden voxels likelier")
    marks = {fix.epc[-2:]: fix.point_m for fix in found.confident} | {"target": true_m}
    draw_maps(maps, marks, y_m=float(true_m[1])).savefig(out / "maps.png", dpi=70 if fast else 130)
    page(world, way, found, maps, out / "scan.html")
    print(f"pictures: {out / 'maps.png'}, {out / 'scan.html'}")
    return map_quality(maps["posterior"], true_m, seen.unobserved).bits


if __name__ == "__main__":
    main(fast="--fast" in sys.argv)
