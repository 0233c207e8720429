"""The robot, its tags, the part and what is known about it, drawn into a meshcat scene."""

from collections.abc import Mapping, Sequence

import meshcat.geometry as shapes
import numpy as np
from meshcat.animation import Animation

from rfcompass.arrays import FloatArray
from rfcompass.geometry.pose2 import Pose2, as_pose2
from rfcompass.types.estimate import PartEstimate
from rfcompass.types.grasps import ReachMap
from rfcompass.types.parts import Part
from rfcompass.types.placed_shape import PlacedShape
from rfcompass.types.world import World
from rfcompass.viz import colours
from rfcompass.viz.drawn_shapes import (
    T_shape_geometry,
    T_solid_geometry,
    flat_material,
    material,
    placed_geometry,
    solid_geometry,
    surface,
)
from rfcompass.viz.meshcat_page import RecordingWindow
from rfcompass.viz.triangles import Triangles, polygon

_FRAMES_PER_SECOND = 30
_SAME_M = 1e-9  # a link that moves less than this [m, or of its axes' tips] stands still


class RobotScene:
    """Collects what to draw; `window` then becomes a page (`meshcat_page.write_scene`)."""

    def __init__(self) -> None:
        """Start with an empty floor under a bright sky."""
        self.window = RecordingWindow()
        self._root = self.window.visualizer()
        self._animation = Animation(default_framerate=_FRAMES_PER_SECOND)
        self._root["/Background"].set_property("top_color", [0.85, 0.9, 0.95])
        self._root["/Background"].set_property("bottom_color", [1.0, 1.0, 1.0])

    def look_at(self, target_m: FloatArray, offset_m: FloatArray) -> None:
        """Aim the camera at a point from an offset to it, both in the world [m], shape (3,) each."""
        x, y, z = offset_m.tolist()
        self._root["/Cameras/default"].set_transform(_shifted(target_m))
        self._root["/Cameras/default/rotated/<object>"].set_property("position", [x, z, -y])  # three.js: y is up

    def draw_robot(
        self,
        stops: Sequence[Sequence[PlacedShape]],
        seconds_per_stop: float = 1.0,
        times_s: Sequence[float] | None = None,
    ) -> None:
        """Draw a robot at its last stop, and play its way there.

        Args:
            stops: All shapes of the robot, placed in the world, at each stop; the same shapes at every stop.
            seconds_per_stop: Time from one stop to the next in the animation [s].
            times_s: When it is at each stop [s]; evenly spaced if None.
        """
        when_s = [seconds_per_stop * stop for stop in range(len(stops))] if times_s is None else times_s
        ways: dict[str, list[FloatArray]] = {}
        for link, indices in _by_link(stops[-1]).items():
            first = indices[0]
            T_first_world = np.asarray(np.linalg.inv(stops[-1][first].T_world_shape), dtype=np.float64)
            for index in indices:
                self._draw_shape(f"robot/{link}/{index}", stops[-1][index], T_first_world)
            ways[f"robot/{link}"] = [stop[first].T_world_shape for stop in stops]
        self._move(ways, when_s)

    def move_robot(self, shapes_now: Sequence[PlacedShape]) -> None:
        """Put a robot that was drawn where its shapes are now, placed in the world."""
        for link, indices in _by_link(shapes_now).items():
            self._root[f"robot/{link}"].set_transform(shapes_now[indices[0]].T_world_shape)

    def clear(self, *nodes: str) -> None:
        """Take away all that was drawn below some nodes."""
        for node in nodes:
            self._root[node].delete()

    def draw_part(self, part: Part, T_world_part: Pose2, tags_m: FloatArray, name: str = "part") -> None:
        """Draw a part as it is believed to lie, with its tags.

        Args:
            part: What to draw.
            T_world_part: Pose on the floor.
            tags_m: Tags in the part frame [m], shape (K, 3).
            name: Path of its node, where there are several parts.
        """
        node = self._root[name]
        node["body"].set_object(solid_geometry(part.shape), material(colours.PART, 0.6))
        node["body"].set_transform(T_solid_geometry(part.shape))
        for k, tag_m in enumerate(tags_m):
            node[f"tag_{k}"].set_object(shapes.Box([0.044, 0.004, 0.044]), material(0xFFFFFF))
            node[f"tag_{k}"].set_transform(_shifted(tag_m))
        self.move_part([_lifted(T_world_part, part.resting_height_m)], name=name)

    def move_part(self, poses: Sequence[FloatArray], times_s: Sequence[float] = (0.0,), name: str = "part") -> None:
        """Put a part at the last of its poses in the world, shape (4, 4) each, and play its way there."""
        self._move({name: poses}, times_s)

    def show_between(self, node: str, start_s: float, end_s: float | None = None) -> None:
        """Show a node of the scene in a part of the animation only; where that ends it stays as it was at the end.

        Args:
            node: Path of the node.
            start_s: When it appears [s].
            end_s: When it disappears [s]; never if None.

        The animation is told of it by `play`, once for all nodes.
        """
        changes = [(0.0, start_s <= 0.0), (start_s, True)] + ([] if end_s is None else [(end_s, False)])
        for time_s, shown in changes[start_s <= 0.0 :]:
            with self._animation.at_frame(self._root, _FRAMES_PER_SECOND * float(time_s)) as frame:
                frame[node].set_property("visible", "boolean", shown)
        self._root[node].set_property("visible", end_s is None)

    def play(self) -> None:
        """Let the page play all motions and appearances that were drawn so far."""
        self._root.set_animation(self._animation, play=True, repetitions=1)

    def draw_world(self, world: World) -> None:
        """Draw every body that stands still, under its name; the floor is the grid."""
        for body in world.bodies:
            if body.stands_still:
                node = self._root["world"][body.name]
                node.set_object(solid_geometry(body.shape), material(colours.OBSTACLE, 0.5))
                node.set_transform(body.T_parent_body @ T_solid_geometry(body.shape))

    def draw_shapes(self, name: str, placed: Sequence[PlacedShape]) -> None:
        """Draw shapes that stand still, such as the items of a pile, each under `name` and its link."""
        for shape in placed:
            self._draw_shape(f"{name}/{shape.link}", shape, np.eye(4))

    def draw_region(self, name: str, vertices_m: FloatArray, height_m: float = 0.002) -> None:
        """Draw a convex polygon on the floor; vertices in the world [m], counter-clockwise, shape (V, 2)."""
        if len(vertices_m) >= 3:
            self._root["region"][name].set_object(surface(polygon(vertices_m, height_m)), material(colours.REGION, 0.7))

    def draw_path(self, name: str, points_m: FloatArray) -> None:
        """Draw a line through points on the floor; points in the world [m], shape (S, 2)."""
        points = np.column_stack([points_m, np.full(len(points_m), 0.01)]).astype(np.float32)
        line = shapes.Line(shapes.PointsGeometry(points.T), shapes.LineBasicMaterial(color=colours.PATH, linewidth=3))
        self._root["path"][name].set_object(line)

    def draw_reach(self, reach_map: ReachMap, T_world_base: Pose2) -> None:
        """Draw what an arm reaches: a point in each voxel that it reaches, red (few directions) to green (all)."""
        voxels = np.argwhere(reach_map.reachable)
        share = reach_map.share[tuple(voxels.T)]
        points_m = reach_map.origin_m + reach_map.spacing_m * voxels
        rgb = np.column_stack([1 - share, share, np.full(len(share), 0.2)])
        self.draw_points("reach", points_m, rgb, reach_map.spacing_m / 3)
        self._root["reach"].set_transform(_lifted(T_world_base, 0.0))

    def draw_points(self, node: str, points_m: FloatArray, rgb: FloatArray, size_m: float) -> None:
        """Draw points in the world.

        Args:
            node: Path of the node, for example `"voxels/C"`.
            points_m: Where they are [m], shape (P, 3).
            rgb: Colour of each in [0, 1], shape (P, 3).
            size_m: Edge of the square that stands for each [m].
        """
        cloud = shapes.PointCloud(points_m.T.astype(np.float32), rgb.T.astype(np.float32), size=size_m)
        self._root[node].set_object(cloud)

    def draw_estimate(self, estimate: PartEstimate, T_world_base: Pose2, part: Part, tags_m: FloatArray) -> None:
        """Draw region and part of an estimate that is given in a base frame."""
        placed = estimate.in_frame(T_world_base)
        self.draw_region("estimate", placed.region_m)
        if placed.theta_rad is not None:
            self.draw_part(part, as_pose2([*placed.centre_m, placed.theta_rad]), tags_m)

    def draw_markers(
        self,
        node: str,
        markers: Triangles,
        colour: int = 0,
        *,
        by_vertex: FloatArray | None = None,
        opacity: float = 1.0,
    ) -> None:
        """Draw flat-coloured triangles, given in the world.

        Args:
            node: Path of the node, for example `"candidates/chosen"`.
            markers: What to draw.
            colour: 0xRRGGBB of all of it.
            by_vertex: Colour of each vertex in place of that, in [0, 1], shape (V, 3).
            opacity: 1 hides what is behind.
        """
        tint = 0xFFFFFF if by_vertex is not None else colour
        drawn = flat_material(tint, opacity, by_vertex=by_vertex is not None)
        self._root[node].set_object(surface(markers, by_vertex), drawn)

    def _draw_shape(self, node: str, shape: PlacedShape, T_link_world: FloatArray) -> None:
        """Draw a shape of the robot in the node of its link."""
        drawn = material(colours.packed(shape.rgba), float(shape.rgba[3]))
        self._root[node].set_object(placed_geometry(shape), drawn)
        self._root[node].set_transform(T_link_world @ shape.T_world_shape @ T_shape_geometry(shape))

    def _move(self, ways: Mapping[str, Sequence[FloatArray]], times_s: Sequence[float]) -> None:
        """Put each node at the last of its poses, and play its way there if it moves."""
        moving = []
        for node, poses in ways.items():
            self._root[node].set_transform(poses[-1])
            if max(np.abs(T - poses[0]).max() for T in poses) > _SAME_M:
                moving.append(node)
        for index, time_s in enumerate(times_s):
            with self._animation.at_frame(self._root, _FRAMES_PER_SECOND * float(time_s)) as frame:
                for node in moving:
                    frame[node].set_transform(ways[node][index])
        if moving:
            self.play()


def _by_link(stop: Sequence[PlacedShape]) -> dict[str, list[int]]:
    """Indices of the shapes of each link."""
    found: dict[str, list[int]] = {}
    for index, shape in enumerate(stop):
        found.setdefault(shape.link, []).append(index)
    return found


def _lifted(pose: Pose2, height_m: float) -> FloatArray:
    T = np.eye(4)
    T[:2, :2], T[:2, 3], T[2, 3] = pose.rotation, pose.translation_m, height_m
    return T


def _shifted(offset_m: FloatArray) -> FloatArray:
    T = np.eye(4)
    T[:3, 3] = offset_m
    return T
