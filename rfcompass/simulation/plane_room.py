"""Where robot and part truly are: poses on the floor of a room."""

from dataclasses import dataclass

import numpy as np

from rfcompass.errors import InputError
from rfcompass.geometry.pose2 import Pose2

AREA_M = ((0.5, 0.5), (5.5, 4.5))  # ours: the paper's 6 x 5 m, half a metre from the walls


@dataclass(frozen=True, slots=True, kw_only=True)
class PlaneRoom:
    """Where everything truly is at the start. This record is truth.

    Attributes:
        T_room_base: Pose of the robot's base.
        T_room_part: Pose of the part, which lies on the floor.
    """

    T_room_base: Pose2
    T_room_part: Pose2

    @classmethod
    def draw(
        cls,
        rng: np.random.Generator,
        distance_m: tuple[float, float] = (2.0, 6.0),
        area_m: tuple[tuple[float, float], tuple[float, float]] = AREA_M,
    ) -> "PlaneRoom":
        """Draw start and part in the paper's 6 x 5 m area, as far apart as its runs were (2 to 6 m).

        Args:
            rng: Source of both poses.
            distance_m: Smallest and largest distance between them [m].
            area_m: Lower and upper corner of where they may be [m].

        Raises:
            InputError: If no two places of the area are that far apart.
        """
        lower_m, upper_m = np.array(area_m)
        if (diagonal_m := float(np.linalg.norm(upper_m - lower_m))) <= distance_m[0]:
            message = f"no two places of an area {diagonal_m:.2f} m across are {distance_m[0]:.2f} m apart"
            raise InputError(message, diagonal_m=diagonal_m, distance_m=distance_m[0])
        while True:
            x, y = rng.uniform(lower_m, upper_m, (2, 2)).T
            if distance_m[0] <= np.hypot(np.diff(x), np.diff(y))[0] <= distance_m[1]:
                headings = rng.uniform(-np.pi, np.pi, 2)
                return cls(
                    T_room_base=Pose2(x[0], y[0], headings[0]), T_room_part=Pose2(x[1], y[1], headings[1])
                )  # fmt: skip
