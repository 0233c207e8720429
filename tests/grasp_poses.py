"""Random poses of a hand over a part, for tests of grasps."""

import numpy as np
import pinocchio as pin
import shapely
import trimesh

from rfcompass.recordings.parts.mesh import part_from_mesh
from rfcompass.types import Failure


def over(x=0.0, y=0.0, z=-0.015, yaw=0.0):
    """The youBot's tool straight down over a part, jaws closing along y; `T_part_hand`."""
    closing, approach = np.array([-np.sin(yaw), np.cos(yaw), 0.0]), np.array([0.0, 0.0, -1.0])
    T = np.eye(4)
    T[:3, :3] = np.column_stack([np.cross(closing, approach), closing, approach])
    T[:3, 3] = x, y, z
    return T


def random_poses(rng, count, spread_m, yaw_rad=0.5, tilt_rad=0.0):
    """Poses over a part: off by up to spread_m (3,) along each axis, turned and tilted, (S, 4, 4)."""
    poses = []
    for _ in range(count):
        T = over(*rng.uniform(-1, 1, 3) * spread_m, yaw=rng.uniform(-yaw_rad, yaw_rad))
        T[:3, :3] = pin.exp3(rng.normal(0, tilt_rad, 3)) @ T[:3, :3]
        poses.append(T)
    return np.array(poses)


def kind(answer):
    return answer.kind if isinstance(answer, Failure) else "holds"


def turned_leg(folder):
    """A turned chair leg: rings and necks, concave, 0.3 m long, lying along x."""
    along = np.linspace(-0.15, 0.15, 25)
    radius = 0.016 + 0.006 * np.cos(along * 2 * np.pi / 0.06)
    outline = np.column_stack([[0, *radius, 0], [along[0], *along, along[-1]]])
    solid = trimesh.creation.revolve(outline, sections=24)
    return _part(solid, folder / "turned_leg.stl")


def channel(folder):
    """A channel: a U of walls 8 mm thick, 0.2 m long; its inside is as wide as a finger."""
    u = [
        (-0.03, -0.02),
        (0.03, -0.02),
        (0.03, 0.02),
        (0.022, 0.02),
        (0.022, -0.012),
        (-0.022, -0.012),
        (-0.022, 0.02),
        (-0.03, 0.02),
    ]
    return _part(trimesh.creation.extrude_polygon(shapely.Polygon(u), 0.2), folder / "channel.stl")


def _part(solid, path):
    solid.export(path)
    return part_from_mesh(path, path.stem, density_kg_m3=700.0)
