"""When the loop of a fetch does what."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

# Where the hand works best on the youBot, base frame [m], and the poses of the hand around it: x, y [m] and the
# heading of the jaws [rad]. Ours; chosen for unequal radii and directions, all within reach of the arm.
HAND_POINT_M = (0.42, 0.0)
HAND_SWEEP = ((0.0, 0.0, 0.0), (-0.02, -0.12, np.pi / 3), (0.02, 0.12, -np.pi / 3), (0.03, 0.0, np.pi / 2))


@dataclass(frozen=True, slots=True, kw_only=True)
class FetchRules:
    """When to do what. The paper prints D/2 and 0.6 m; everything else is ours.

    Attributes:
        reach_m: A part this far from the body's centre, or nearer, is in reach [m].
        tags_tell_reach: Ask the tags as well; False where no tag is heard, as with motion capture.
        max_moves: Base moves before giving up.
        hand_point_m: Where the part's centre should lie for the final stops, base frame [m].
        hand_height_m: Height of the tool over the floor at the final stops [m].
        hand_sweep: Offsets x, y [m] from `hand_point_m` and jaw heading [rad] of the final stops.
        lined_up_m: How far from `hand_point_m` the estimated centre may lie at the first final stop [m].
        max_line_ups: Base moves for lining up.
        max_step_m: Longest single drive [m]; the paper's window holds 2 m of travel.
        max_antenna_moves: How often the antenna's carrier may come nearer at one stop, each time with another scan.
        stand_off_m: A way around obstacles is planned up to this distance from the part [m], or half way if less.
        stops_anew: Hand stops after a failed try of the grasp, or after a drive to where it is in reach.
    """

    reach_m: float = 0.6
    tags_tell_reach: bool = True
    max_moves: int = 12
    hand_point_m: tuple[float, float] = HAND_POINT_M
    hand_height_m: float = 0.10
    hand_sweep: Sequence[tuple[float, float, float]] = HAND_SWEEP
    lined_up_m: float = 0.05
    max_line_ups: int = 3
    max_step_m: float = 2.0
    max_antenna_moves: int = 2
    stand_off_m: float = 0.5
    stops_anew: int = 3
