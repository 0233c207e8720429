"""The robot, its tags, the part and what is known about it, drawn into a meshcat scene."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import meshcat.geometry as shapes
import numpy as np
from meshcat.animation import Animation

from rfcompass.arrays import FloatArray
from rfcompass.errors import InputError
from rfcompass.geometry.pose2 import Pose2, as_pose2
from rfcompass.types.estimate import PartEstimate
from rfcompass.types.grasps import ReachMap
from rfcompass.types.parts import Part
from rfcompass.types.placed_shape import PlacedShape
from rfcompass.viz.meshcat_page import RecordingWindow

if TYPE_CHECKING:
    import meshcat

REGION_COLOUR, PART_COLOUR, PATH_COLOUR = 0xF2C14E, 0xD1495B, 0x3B6EA5
# meshcat's cylinders stand along y, ours and URDF's along z.
_Z_FROM_Y = np.array([[1.0, 0, 0, 0], [0, 0, -1.0, 0], [0, 1.0, 0, 0], [0, 0, 0, 1.0]])


class RobotScene:
    """Collects what to draw; `window` then becomes a page (`meshcat_page.write_scene`)."""

    def __init__(self) -> None:
        """Start with an empty floor under a bright sky."""
        self.window = RecordingWindow()
        self._root = self.window.visualizer()
        self._root["/Background"].set_property("top_color", [0.85, 0.9, 0.95])
        self._root["/Background"].set_property("bottom_color", [1.0, 1.0, 1.0])

    def look_at(self, target_m: FloatArray, offset_m: FloatArray) -> None:
        """Aim the camera at a point from an offset to it, both in the world [m], shape (3,) each."""
        x, y, z = offset_m.tolist()
        self._root["/Cameras/default"].set_transform(_shifted(target_m))
        self._root["/Cameras/default/rotated/<object>"].set_property("position", [x, z, -y])  # three.js: y is up

    def draw_robot(self, stops: Sequence[Sequence[PlacedShape]], seconds_per_stop: float = 1.0) -> None:
        """Draw a robot at its last stop, and play its way there.

        Args:
            stops: All shapes of the robot, placed in the world, at each stop; the same shapes at every stop.
            seconds_per_stop: Time from one stop to the next in the animation [s].
        """
        for index, shape in enumerate(stops[-1]):
            node = self._root["robot"][f"{index}_{shape.link}"]
            node.set_object(_geometry(shape), _material(_hex(shape.rgba), float(shape.rgba[3])))
            node.set_transform(_placed(shape))
        if len(stops) > 1:
            self._root.set_animation(_animation(self._root, stops, seconds_per_stop), play=True, repetitions=1)

    def draw_part(self, part: Part, T_world_part: Pose2, tags_m: FloatArray) -> None:
        """Draw a part as it is believed to lie, with its tags.

        Args:
            part: Its bounding box is drawn.
            T_world_part: Pose on the floor.
            tags_m: Tags in the part frame [m], shape (K, 3).
        """
        T = _lifted(T_world_part, part.resting_height_m)
        node = self._root["part"]
        node["body"].set_object(shapes.Box(part.size_m.tolist()), _material(PART_COLOUR, 0.6))
        node["body"].set_transform(T)
        for k, tag_m in enumerate(tags_m):
            node[f"tag_{k}"].set_object(shapes.Box([0.044, 0.004, 0.044]), _material(0xFFFFFF, 1.0))
            node[f"tag_{k}"].set_transform(T @ _shifted(tag_m))

    def draw_region(self, name: str, vertices_m: FloatArray, height_m: float = 0.002) -> None:
        """Draw a convex polygon on the floor; vertices in the world [m], counter-clockwise, shape (V, 2)."""
        if len(vertices_m) < 3:
            return
        points = np.column_stack([vertices_m, np.full(len(vertices_m), height_m)])
        fan = np.array([[0, i, i + 1] for i in range(1, len(points) - 1)])
        self._root["region"][name].set_object(shapes.TriangularMeshGeometry(points, fan), _material(REGION_COLOUR, 0.7))

    def draw_path(self, name: str, points_m: FloatArray) -> None:
        """Draw a line through points on the floor; points in the world [m], shape (S, 2)."""
        points = np.column_stack([points_m, np.full(len(points_m), 0.01)]).astype(np.float32)
        line = shapes.Line(shapes.PointsGeometry(points.T), shapes.LineBasicMaterial(color=PATH_COLOUR, linewidth=3))
        self._root["path"][name].set_object(line)

    def draw_reach(self, reach_map: ReachMap, T_world_base: Pose2) -> None:
        """Draw what an arm reaches: a point in each voxel that it reaches, red (few directions) to green (all)."""
        voxels = np.argwhere(reach_map.reachable)
        share = reach_map.share[tuple(voxels.T)]
        points_m = reach_map.origin_m + reach_map.spacing_m * voxels
        colours = np.column_stack([1 - share, share, np.full(len(share), 0.2)])
        cloud = shapes.PointCloud(
            points_m.T.astype(np.float32), colours.T.astype(np.float32), size=reach_map.spacing_m / 3
        )
        self._root["reach"].set_object(cloud)
        self._root["reach"].set_transform(_lifted(T_world_base, 0.0))

    def draw_estimate(self, estimate: PartEstimate, T_world_base: Pose2, part: Part, tags_m: FloatArray) -> None:
        """Draw region and part of an estimate that is given in a base frame."""
        placed = estimate.in_frame(T_world_base)
        self.draw_region("estimate", placed.region_m)
        if placed.theta_rad is not None:
            self.draw_part(part, as_pose2([*placed.centre_m, placed.theta_rad]), tags_m)


def _animation(root: "meshcat.Visualizer", stops: Sequence[Sequence[PlacedShape]], seconds: float) -> Animation:
    animation = Animation(default_framerate=30)
    for stop, placed in enumerate(stops):
        with animation.at_frame(root, round(30 * seconds * stop)) as frame:
            for index, shape in enumerate(placed):
                frame["robot"][f"{index}_{shape.link}"].set_transform(_placed(shape))
    return animation


def _geometry(shape: PlacedShape) -> shapes.Geometry:
    match shape.kind:
        case "box":
            return shapes.Box(shape.dimensions_m.tolist())
        case "cylinder":
            radius, length = shape.dimensions_m.tolist()
            return shapes.Cylinder(length, radius)
        case "sphere":
            return shapes.Sphere(float(shape.dimensions_m[0]))
    if shape.mesh is None or shape.mesh.suffix.lower() not in (".stl", ".obj"):
        raise InputError(f"link {shape.link}: cannot draw mesh {shape.mesh}", link=shape.link)
    loader = shapes.StlMeshGeometry if shape.mesh.suffix.lower() == ".stl" else shapes.ObjMeshGeometry
    return loader.from_file(str(shape.mesh))


def _placed(shape: PlacedShape) -> FloatArray:
    """Pose of meshcat's geometry for a shape: turned if a cylinder, scaled if a mesh."""
    if shape.kind == "cylinder":
        return np.asarray(shape.T_world_shape @ _Z_FROM_Y)
    if shape.kind == "mesh":
        return np.asarray(shape.T_world_shape @ np.diag([*shape.dimensions_m, 1.0]))
    return shape.T_world_shape


def _material(colour: int, opacity: float) -> shapes.Material:
    return shapes.MeshPhongMaterial(color=colour, opacity=opacity, transparent=opacity < 1.0)


def _hex(rgba: FloatArray) -> int:
    red, green, blue = (round(255 * float(value)) for value in rgba[:3])
    return (red << 16) + (green << 8) + blue


def _lifted(pose: Pose2, height_m: float) -> FloatArray:
    T = np.eye(4)
    T[:2, :2], T[:2, 3], T[2, 3] = pose.rotation, pose.translation_m, height_m
    return T


def _shifted(offset_m: FloatArray) -> FloatArray:
    T = np.eye(4)
    T[:3, 3] = offset_m
    return T
