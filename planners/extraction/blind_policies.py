"""Policies that do not use the map: a random object, the largest one."""

import hashlib
from dataclasses import dataclass

import numpy as np

from planners.extraction.mask_policy import MaskPolicy, Scene
from rfcompass.arrays import FloatArray
from rfcompass.types.counts import check_count


@dataclass(frozen=True, slots=True, kw_only=True)
class RandomPolicy(MaskPolicy):
    """Takes any object, each as likely as the others.

    The draw comes from the seed, the depth image and the number of failures: it keeps no memory, and equal questions
    have equal answers.

    Attributes:
        seed: Of the draw.
    """

    seed: int = 0

    def __post_init__(self) -> None:
        """Check τ and the seed."""
        MaskPolicy.__post_init__(self)
        check_count(self.seed, "RandomPolicy.seed")

    def values(self, scene: Scene) -> FloatArray:
        """A number in (0, 1] for each candidate, shape (K,)."""
        seen = hashlib.blake2b(scene.view.depth_m.tobytes(), digest_size=8).digest()
        rng = np.random.default_rng([self.seed, scene.failures, int.from_bytes(seen, "little")])
        return np.asarray(1.0 - rng.random(len(scene.candidates.labels)))


@dataclass(frozen=True, slots=True, kw_only=True)
class LargestMaskPolicy(MaskPolicy):
    """Takes the object with the most pixels."""

    def values(self, scene: Scene) -> FloatArray:
        """Pixels of each candidate, shape (K,)."""
        labels = scene.masks.labels
        return np.array([(labels == label).sum() for label in scene.candidates.labels], dtype=np.float64)
