"""A search in a pile as a film: arm, pile as it shrinks, map as it changes, objects by score, what was gone for.

The page's controls have a slider for the time; a legend shows and hides the layers.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from rfcompass.arrays import FloatArray, read_only
from rfcompass.errors import InputError
from rfcompass.robots import Robot
from rfcompass.types.configuration import Configuration
from rfcompass.types.piles import VoxelGrid
from rfcompass.types.placed_shape import PlacedShape
from rfcompass.types.record import Record
from rfcompass.viz.grasp_view import View
from rfcompass.viz.overlay import Layer, Overlay, StageMark
from rfcompass.viz.robot_scene import RobotScene
from rfcompass.viz.voxel_points import value_rgb, voxel_points

# Ours: where the camera stands, seen from the middle of the table [m]; voxels that are drawn of each map, and the share
# of the largest from which they are; colour of an object without a score, size of its points [m]; size and colours of
# the mark of a grasp.
_CAMERA_M, _MOST, _SHARE = np.array([0.9, 0.9, 0.8]), 4000, 0.25
_GREY, _POINT_M = 0.55, 0.004
_MARK_M, _HELD_RGBA, _FAILED_RGBA = (0.012, 0.085, 0.06), (0.1, 0.6, 0.25, 0.8), (0.85, 0.2, 0.1, 0.8)


@dataclass(frozen=True, slots=True)
class FilmedPile(Record):
    """What lies on the table from a moment on.

    Attributes:
        time_s: When [s].
        shapes: Everything, placed in the world.
    """

    time_s: float
    shapes: tuple[PlacedShape, ...]


@dataclass(frozen=True, slots=True)
class FilmedGrasp(Record):
    """One action.

    Attributes:
        time_s: When it was decided [s].
        until_s: When the hand was empty again [s].
        T_world_hand: Where the hand closed, shape (4, 4).
        grid: What was believed; None where there was no need to.
        outcome: What came of it.
        held: Whether something was taken.
        objects_m: Points that were seen on objects, in the world [m], shape (P, 3).
        scores: Score of the object that each is on, as a share of the best one's; negative where it has none,
            shape (P,).
    """

    time_s: float
    until_s: float
    T_world_hand: FloatArray
    grid: VoxelGrid | None
    outcome: str
    held: bool
    objects_m: FloatArray = field(default_factory=lambda: np.zeros((0, 3)))
    scores: FloatArray = field(default_factory=lambda: np.zeros(0))

    def __post_init__(self) -> None:
        """Freeze the points, a score for each."""
        object.__setattr__(self, "objects_m", read_only(self.objects_m, "FilmedGrasp.objects_m", (None, 3)))
        scores = read_only(self.scores, "FilmedGrasp.scores", (len(self.objects_m),))
        object.__setattr__(self, "scores", scores)


@dataclass(frozen=True, slots=True)
class FilmedCarry(Record):
    """What the hand carries away, as one with it.

    Attributes:
        times_s: When it is at each pose [s], rising; it is there from the first to the last (T).
        T_world_hand: The hand at each, shape (4, 4); at the first one it has just closed.
        shapes: What it holds, placed in the world as it lay at the first.
    """

    times_s: tuple[float, ...]
    T_world_hand: tuple[FloatArray, ...]
    shapes: tuple[PlacedShape, ...]


@dataclass(frozen=True, slots=True)
class SearchFilm(Record):
    """All that happened in a search, in the world frame.

    Attributes:
        T_world_base: Where the arm stands, shape (4, 4).
        times_s: When each picture of the arm is taken [s], rising (T).
        configurations: Joints in each (T).
        piles: The table, from one change to the next.
        grasps: Every action.
        carried: What is on its way to the drop zone.
    """

    T_world_base: FloatArray
    times_s: tuple[float, ...]
    configurations: tuple[Configuration, ...]
    piles: tuple[FilmedPile, ...]
    grasps: tuple[FilmedGrasp, ...]
    carried: tuple[FilmedCarry, ...] = ()


def draw_search(robot: Robot, film: SearchFilm, facts: Sequence[tuple[str, str]] = ()) -> View:
    """Draw a search.

    Args:
        robot: The arm.
        film: What happened.
        facts: What to say beside it: rows of name and value.

    Raises:
        InputError: If there is no picture of the arm, or none of the pile.
    """
    if not (film.times_s and film.piles):
        raise InputError("a film without a picture", pictures=len(film.times_s), piles=len(film.piles))
    scene = RobotScene()
    scene.look_at(np.array([0.0, 0.0, 0.1]), _CAMERA_M)
    scene.draw_robot([_placed(robot, film, at) for at in film.configurations], times_s=film.times_s)
    ends_s: list[float | None] = [pile.time_s for pile in film.piles[1:]]
    for n, (pile, end_s) in enumerate(zip(film.piles, [*ends_s, None], strict=True)):
        scene.draw_shapes(f"pile/at_{n}", pile.shapes)
        scene.show_between(f"pile/at_{n}", pile.time_s, end_s)
    for n, carry in enumerate(film.carried):
        _draw_carry(scene, f"pile/carried_{n}", carry)
    believed = [n for n, grasp in enumerate(film.grasps) if _draw_grasp(scene, n, grasp)]
    scene.play()
    layers = [
        Layer("arm", "robot", None),
        Layer("pile (simulated truth)", "pile", None, len(film.piles)),
        Layer("where the target may be", "belief", None, len(believed)),
        Layer("objects, redder with their score", "objects", None, sum(len(g.scores) > 0 for g in film.grasps)),
        Layer("grasps", "grasps", None, len(film.grasps)),
    ]
    marks = tuple(StageMark(f"{n + 1}: {grasp.outcome}", grasp.time_s) for n, grasp in enumerate(film.grasps))
    return View(scene.window, Overlay("A search in a pile", tuple(facts), tuple(layers), marks))


def _placed(robot: Robot, film: SearchFilm, at: Configuration) -> list[PlacedShape]:
    shapes = robot.visual_shapes(at)
    return [replace(shape, T_world_shape=film.T_world_base @ shape.T_world_shape) for shape in shapes]


def _draw_carry(scene: RobotScene, node: str, carry: FilmedCarry) -> None:
    """Let what is held go with the hand."""
    T_hand_world = np.linalg.inv(carry.T_world_hand[0])
    scene.draw_shapes(
        node, [replace(shape, T_world_shape=T_hand_world @ shape.T_world_shape) for shape in carry.shapes]
    )
    scene.move_part(carry.T_world_hand, carry.times_s, node)
    scene.show_between(node, carry.times_s[0], carry.times_s[-1])


def _draw_grasp(scene: RobotScene, number: int, grasp: FilmedGrasp) -> bool:
    """Draw what was believed and gone for, while it was; tell whether there was a map."""
    rgba = np.array(_HELD_RGBA if grasp.held else _FAILED_RGBA)
    mark = PlacedShape("hand", "box", np.array(_MARK_M), grasp.T_world_hand, rgba)
    scene.draw_shapes(f"grasps/{number}", [mark])
    scene.show_between(f"grasps/{number}", grasp.time_s, grasp.until_s)
    if len(grasp.scores):
        colours = np.where(grasp.scores[:, None] < 0, _GREY, value_rgb(np.maximum(grasp.scores, 0.0), 1.0))
        scene.draw_points(f"objects/{number}", grasp.objects_m, colours, _POINT_M)
        scene.show_between(f"objects/{number}", grasp.time_s, grasp.until_s)
    if grasp.grid is None or not grasp.grid.values.max() > 0:
        return False
    points = voxel_points(grasp.grid, _SHARE, _MOST)
    scene.draw_points(f"belief/{number}", points.points_m, points.rgb, 0.6 * grasp.grid.spacing_m)
    scene.show_between(f"belief/{number}", grasp.time_s, grasp.until_s)
    return True
