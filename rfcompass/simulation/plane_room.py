"""Where robot and part truly are: poses on the floor of a room."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from rfcompass.arrays import FloatArray
from rfcompass.errors import InputError, SceneError
from rfcompass.geometry.pose2 import Pose2
from rfcompass.types.parts import Part
from rfcompass.types.tags import TagLayout

AREA_M = ((0.5, 0.5), (5.5, 4.5))  # ours: the paper's 6 x 5 m, half a metre from the walls
APART_M = 0.8  # ours: two legs that lie so far apart leave room for a hand between them
_TRIES = 1000


@dataclass(frozen=True, slots=True)
class LyingPart:
    """One more part on the floor. This record is truth.

    Attributes:
        part: What it is.
        layout: Which of its tags are on.
        T_room_part: Where it lies.
    """

    part: Part
    layout: TagLayout
    T_room_part: Pose2


@dataclass(frozen=True, slots=True, kw_only=True)
class PlaneRoom:
    """Where everything truly is at the start. This record is truth.

    Attributes:
        T_room_base: Pose of the robot's base.
        T_room_part: Pose of the part, which lies on the floor.
        others: More parts that the robot may be sent for.
    """

    T_room_base: Pose2
    T_room_part: Pose2
    others: tuple[LyingPart, ...] = ()

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

    def with_others(
        self,
        parts: Sequence[tuple[Part, TagLayout]],
        rng: np.random.Generator,
        area_m: tuple[tuple[float, float], tuple[float, float]] = AREA_M,
        apart_m: float = APART_M,
    ) -> "PlaneRoom":
        """Let more parts lie in the area; without any, nothing is drawn.

        Args:
            parts: Each part, and which of its tags are on.
            rng: Source of their poses.
            area_m: Lower and upper corner of where they may be [m].
            apart_m: Smallest distance of the centres of two parts, and of a part and the robot [m].

        Raises:
            SceneError: If one of them finds no room.
        """
        taken_m = [self.T_room_base.translation_m, self.T_room_part.translation_m]
        taken_m += [one.T_room_part.translation_m for one in self.others]
        lying = list(self.others)
        for part, layout in parts:
            x_m, y_m = _clear_m(np.array(taken_m), np.array(area_m), apart_m, rng)
            pose = Pose2(x_m, y_m, float(rng.uniform(-np.pi, np.pi)))
            taken_m.append(pose.translation_m)
            lying.append(LyingPart(part, layout, pose))
        return replace(self, others=tuple(lying))


def _clear_m(taken_m: FloatArray, area_m: FloatArray, apart_m: float, rng: np.random.Generator) -> tuple[float, float]:
    """A place of the area that is far enough from all that are taken, shape (N, 2)."""
    for _ in range(_TRIES):
        point_m = rng.uniform(area_m[0], area_m[1], 2)
        if (np.linalg.norm(taken_m - point_m, axis=1) >= apart_m).all():
            return float(point_m[0]), float(point_m[1])
    message = f"no place {apart_m:.2f} m from {len(taken_m)} others in an area of {area_m.tolist()} m"
    raise SceneError(message, apart_m=apart_m, taken=len(taken_m))
