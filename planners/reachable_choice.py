"""Choose again while the arm cannot go to what was chosen: other grasps first, then other objects; ours."""

from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import TypeVar

import numpy as np

from planners.extraction.candidates import failed_object, tried_before
from planners.extraction.projection import check_same_image
from planners.target_grasp import ChosenGrasp, without_near
from rfcompass.arrays import FloatArray
from rfcompass.errors import InputError, NothingToGrasp
from rfcompass.mapping.camera import points_image
from rfcompass.types import DepthView, ExtractionAction, GraspMaps, InstanceMasks
from rfcompass.types.record import Record

# Ours: how often another grasp is chosen because the arm cannot go there, and how often on one object.
_MOST_ELSEWHERE, _OF_ONE = 16, 2
# Ours: grasps so near to one that was chosen, seen from above, tell what it promises [m].
_SAME_M = 0.02

Choice = TypeVar("Choice", ChosenGrasp, ChosenGrasp | None)


@dataclass(frozen=True, slots=True)
class Offer(Record):
    """What a choice is made from.

    Attributes:
        view: The image.
        masks: Objects in it that can be chosen.
        grasps: The best grasp at each pixel.
        failed_m: Where grasps have failed, in the world [m], shape (3,) each.

    Raises:
        InputError: If masks or grasps are something else, as those of a segmenter that answers with None.
        ShapeError: If the images differ in size.
    """

    view: DepthView
    masks: InstanceMasks
    grasps: GraspMaps
    failed_m: Sequence[FloatArray] = ()

    def __post_init__(self) -> None:
        """Check that masks and grasps are what they should be, and of this view."""
        for name, kind in (("masks", InstanceMasks), ("grasps", GraspMaps)):
            _check_kind(getattr(self, name), name, kind)
        check_same_image(self.view, self.masks.labels, "masks")
        check_same_image(self.view, self.grasps.quality, "grasps")

    def without_grasps_near(self, action: ExtractionAction) -> "Offer":
        """The same without grasps at some place."""
        return replace(self, grasps=without_near(self.view, self.grasps, action.T_world_hand[:3, 3]))

    def without_object(self, label: int) -> "Offer":
        """The same without an object. What failed on it still counts, but for no other object."""
        points_m = points_image(self.view)
        nowhere = np.full(3, np.inf)
        failed_m = [
            nowhere if failed_object(points_m, self.masks, place_m) == label else place_m for place_m in self.failed_m
        ]
        masks = InstanceMasks(np.where(self.masks.labels == label, 0, self.masks.labels))
        return replace(self, masks=masks, failed_m=tuple(failed_m))

    def chance_of(self, action: ExtractionAction) -> float:
        """What is promised of a grasp: the best within 2 cm on its object, after what has failed there, or 0.

        Raises:
            InputError: If it is none, as that of a policy that answers with None.
        """
        _check_kind(action, "action", ExtractionAction)
        points_m = points_image(self.view)
        off_m = np.linalg.norm(points_m[..., :2] - action.T_world_hand[:2, 3], axis=2)
        near = (off_m < _SAME_M) & (self.masks.labels == action.mask_label)
        quality = self.grasps.quality * tried_before(points_m, self.masks, self.failed_m)
        return float(np.max(quality, where=near, initial=0.0))


def _check_kind(value: object, name: str, kind: type) -> None:
    if not isinstance(value, kind):
        got = type(value).__name__
        raise InputError(f"{name}: {got} where {kind.__name__} is expected", name=name, got=got)


def choose_within_reach(
    offer: Offer,
    choose: Callable[[Offer], Choice],
    reaches: Callable[[ExtractionAction], bool],
    *,
    objects: bool = True,
) -> Choice:
    """Choose; as long as the arm cannot go there, choose again without the grasps about it.

    Args:
        offer: What there is.
        choose: Chooses a grasp from it.
        reaches: Asks the arm.
        objects: Leave out an object, too, when the arm could not go to two grasps on it; off for a choice that is of
            one object anyway.

    Returns:
        The first choice that the arm reaches. If there is none, the last one, which then says so and promises nothing.

    Raises:
        NothingToGrasp: If there is nothing to choose at the start.
    """
    chosen, refused = choose(offer), Counter[int]()
    for _ in range(_MOST_ELSEWHERE):
        if chosen is None or reaches(chosen.action):
            return chosen
        label = chosen.action.mask_label
        refused[label] += 1
        offer = offer.without_grasps_near(chosen.action)
        if objects and not chosen.on_target and refused[label] >= _OF_ONE:
            offer = offer.without_object(label)
        try:
            other = choose(offer)
        except NothingToGrasp:  # all that is in sight is out of reach
            break
        if other is None:
            return other
        chosen = other
    if chosen is None or reaches(chosen.action):
        return chosen
    return replace(chosen, chance=0.0, reached=False)
