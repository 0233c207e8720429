"""The extraction policy of FuseBot [Boroushaki2023], section 5."""

from dataclasses import dataclass

from planners.extraction.mask_policy import MaskPolicy, Scene
from planners.extraction.projection import project_masks
from planners.extraction.scores import GAMMA, mask_scores
from rfcompass.arrays import FloatArray
from rfcompass.errors import InputError


@dataclass(frozen=True, slots=True, kw_only=True)
class FuseBotPolicy(MaskPolicy):
    """Takes the object with the largest Eq. 4 among those whose Eq. 5 is above τ, or among all if there is none.

    Attributes:
        gamma: Discount of the map for each 2.5 cm under an object's surface; ours.
        per_column: Measure depth under the surface of each column, not under an object's highest point.
    """

    gamma: float = GAMMA
    per_column: bool = False

    def __post_init__(self) -> None:
        """Check τ and γ."""
        MaskPolicy.__post_init__(self)
        if not 0 < self.gamma <= 1:
            raise InputError(f"FuseBotPolicy.gamma: {self.gamma} is not in (0, 1]", got=self.gamma)

    def values(self, scene: Scene) -> FloatArray:
        """s_i of each candidate, shape (K,)."""
        columns = project_masks(scene.grid, scene.view, scene.masks, scene.points_m)
        return mask_scores(scene.grid, columns, scene.candidates.labels, self.gamma, per_column=self.per_column)
