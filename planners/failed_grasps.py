"""Where grasps have failed in a search, and for how long that is remembered; ours."""

from dataclasses import dataclass, field

import numpy as np

from rfcompass.arrays import FloatArray

MOVED_M = 0.15  # ours: what is so near to a grasp that took something may have moved


@dataclass(eq=False)
class FailedGrasps:
    """Places of failed grasps in the world [m], shape (3,) each.

    Args:
        remembers: Keep those from before the last success, too, until something within 15 cm of them is taken.
        recent_m: Those since the last success, in order.
    """

    remembers: bool
    recent_m: list[FloatArray] = field(default_factory=list)
    _older_m: list[FloatArray] = field(default_factory=list)

    @property
    def in_a_row(self) -> int:
        """How many since the last success."""
        return len(self.recent_m)

    @property
    def tried_m(self) -> tuple[FloatArray, ...]:
        """All that are remembered."""
        return (*(self._older_m if self.remembers else ()), *self.recent_m)

    def failed(self, point_m: FloatArray) -> None:
        """One more failed."""
        self.recent_m.append(point_m)

    def succeeded(self, point_m: FloatArray) -> None:
        """Something was taken here: the count begins anew, and what was tried about it is another place now."""
        self._older_m = [place_m for place_m in self.tried_m if np.linalg.norm(place_m - point_m) > MOVED_M]
        self.recent_m.clear()
