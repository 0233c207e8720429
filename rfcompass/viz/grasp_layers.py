"""What has a row in the legend of a grasp: candidates, what is known of the part, obstacles, reach."""

from collections.abc import Sequence

import numpy as np

from rfcompass.arrays import FloatArray
from rfcompass.geometry.pose2 import Pose2
from rfcompass.robots import Tool
from rfcompass.types.estimate import PartEstimate
from rfcompass.types.grasps import GraspCandidate, ReachMap, count_reasons
from rfcompass.types.world import World
from rfcompass.viz import colours
from rfcompass.viz.overlay import Layer
from rfcompass.viz.robot_scene import RobotScene
from rfcompass.viz.triangles import Triangles, ellipse, hand_glyph, join, needles

# Of a kind no more than this many are drawn, spread over all of them; the legend counts all. Ours.
MOST_DRAWN = 60
_NEEDLE_M, _CLOUD_HEIGHT_M = 0.05, 0.004
_ELLIPSE_HOLDS = 0.95
_REJECTED_OPACITY = 0.35


def draw_candidates(
    scene: RobotScene, tool: Tool, candidates: Sequence[GraspCandidate], T_world_part: FloatArray, *, shown: bool
) -> tuple[Layer, ...]:
    """Draw grasps as hands around the part: coloured by their chance, or greyed with the reason of their rejection.

    Args:
        scene: Where to draw.
        tool: Axes of the hand.
        candidates: What was looked at.
        T_world_part: Where the part is, homogeneous, shape (4, 4).
        shown: False to hide the rejected ones until asked for.

    Returns:
        Rows of the legend: one for those that were kept, one for each reason; node `candidates/rejected/REASON`.
    """
    layers = []
    if kept := [row for row in candidates if row.score is not None]:
        drawn = sorted(_spread(kept), key=lambda row: row.score or 0.0)
        hands = [_hand(row, tool, T_world_part) for row in drawn]
        chances = np.repeat([row.score or 0.0 for row in drawn], [len(hand.vertices_m) for hand in hands])
        scene.draw_markers("candidates/kept", join(hands), by_vertex=colours.success_rgb(chances))
        layers.append(Layer("grasps not ruled out", "candidates/kept", None, len(kept)))
    for index, (reason, count) in enumerate(count_reasons(candidates).items()):
        colour = colours.REJECTED[index % len(colours.REJECTED)]
        rows = [row for row in candidates if row.rejection is not None and row.rejection.kind == reason]
        node = f"candidates/rejected/{reason}"
        hands = [_hand(row, tool, T_world_part) for row in _spread(rows)]
        scene.draw_markers(node, join(hands), colour, opacity=_REJECTED_OPACITY)
        layers.append(Layer(f"rejected: {reason.replace('_', ' ')}", node, colour, count, shown))
    return tuple(layers)


def draw_chosen(scene: RobotScene, tool: Tool, aperture_m: float, T_world_hand: FloatArray) -> Layer:
    """Draw the hand that was chosen."""
    glyph = hand_glyph(aperture_m, tool.approach_axis, tool.closing_axis).placed(T_world_hand)
    scene.draw_markers("candidates/chosen", glyph, colours.CHOSEN)
    return Layer("the grasp that was chosen", "candidates/chosen", colours.CHOSEN)


def draw_belief(scene: RobotScene, estimate: PartEstimate) -> tuple[Layer, ...]:
    """Draw what is known of the part's pose: draws as needles along its x axis, else the ellipse of its centre."""
    layers = []
    if len(estimate.region_m) >= 3:
        scene.draw_region("estimate", estimate.region_m)
        layers.append(Layer("region of the part's centre", "region/estimate", colours.REGION))
    if len(estimate.samples):
        cloud = needles(estimate.samples, _NEEDLE_M, _CLOUD_HEIGHT_M)
        scene.draw_markers("belief/cloud", cloud, colours.CLOUD, opacity=0.6)
        layers.append(Layer("poses the part may have", "belief/cloud", colours.CLOUD, len(estimate.samples)))
    elif estimate.covariance is not None:
        outline_m = ellipse(estimate.centre_m, estimate.covariance[:2, :2], _ELLIPSE_HOLDS)
        scene.draw_region("ellipse", outline_m, _CLOUD_HEIGHT_M)
        layers.append(Layer(f"{_ELLIPSE_HOLDS:.0%} ellipse of its centre", "region/ellipse", colours.REGION))
    return tuple(layers)


def draw_obstacles(scene: RobotScene, world: World) -> tuple[Layer, ...]:
    """Draw the bodies that stand still."""
    scene.draw_world(world)
    still = sum(body.stands_still for body in world.bodies)
    return (Layer("obstacles", "world", colours.OBSTACLE, still),) if still else ()


def draw_reach_layer(scene: RobotScene, reach: ReachMap, T_world_base: Pose2, *, shown: bool) -> Layer:
    """Draw what the arm reaches from where the base stands at the grasp; hidden until asked for unless `shown`."""
    scene.draw_reach(reach, T_world_base)
    return Layer("places in reach", "reach", colours.REACH, int(reach.reachable.sum()), shown)


def _hand(row: GraspCandidate, tool: Tool, T_world_part: FloatArray) -> Triangles:
    glyph = hand_glyph(row.aperture_m, tool.approach_axis, tool.closing_axis)
    return glyph.placed(T_world_part @ row.T_part_hand)


def _spread(rows: Sequence[GraspCandidate]) -> list[GraspCandidate]:
    """At most `MOST_DRAWN` of them, evenly spread."""
    if len(rows) <= MOST_DRAWN:
        return list(rows)
    return [rows[index] for index in np.linspace(0, len(rows) - 1, MOST_DRAWN).round().astype(int)]
