r"""Through how many things one has to take out before a hidden one comes to light; ours.

The target's top is d below the surface of the thing on it. That thing is T thick, exponentially with mean τ, and not in
the target: T < d. Between the two lie K more things, Poisson with one for each s of height:

    P(K < r | d) = E[ Σ_{k<r} Pois(k; (d - T) / s) | T < d ]

For r = 1 this falls much as γ^(d / 2.5 cm) of Eq. 4 does; there is no such rule for r > 1.
"""

from dataclasses import dataclass

import numpy as np
from scipy import special

from rfcompass.arrays import FloatArray
from rfcompass.errors import InputError
from rfcompass.types.record import Record

_STEPS = 64  # of the mean over T


@dataclass(frozen=True, slots=True, kw_only=True)
class LayerRules(Record):
    """How things lie on each other. Ours, chosen on piles of seeds below 1000 for the choice they lead to.

    As lengths they are too small: what showed after one removal fits 2 or 3 cm for both. But the choice is better if
    more is made of what lies near the surface (`docs/extraction.md`).

    Attributes:
        thickness_m: τ, mean thickness of what is seen [m].
        spacing_m: s, height for each hidden thing [m].
    """

    thickness_m: float = 0.01
    spacing_m: float = 0.01

    def __post_init__(self) -> None:
        """Both are lengths."""
        if not (self.thickness_m > 0 and self.spacing_m > 0):
            raise InputError(f"{self}: not above 0", got=[self.thickness_m, self.spacing_m])


def chance_in_sight(depths_m: FloatArray, removals: int, rules: LayerRules) -> FloatArray:
    """Chance that so many removals at a place bring a target to light.

    Args:
        depths_m: Of its top under the surface [m], shape (D,); below 0 counts as 0.
        removals: R, the most removals that are asked for.
        rules: How things lie.

    Returns:
        For 1, 2, ... R removals, growing along the first axis, shape (R, D).
    """
    depths_m = np.maximum(depths_m, 0.0)
    # Quantiles of T given T < d, so that the mean is plain.
    share = (np.arange(_STEPS) + 0.5) / _STEPS
    below = -np.expm1(-depths_m / rules.thickness_m)
    thick_m = -rules.thickness_m * np.log1p(-share[:, None] * below)
    expected = np.maximum(depths_m - thick_m, 0.0) / rules.spacing_m
    return np.stack([special.pdtr(r, expected).mean(axis=0) for r in range(removals)])
