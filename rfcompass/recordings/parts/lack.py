"""The part that [Wang2013] grasps: the legs of the IKEA Lack table, 0.40 x 0.05 x 0.05 m.

Printed are the size, one tag in the middle (K = 1), tags at both ends (K = 2) and "four evenly spaced tags"
(K = 4), which may or may not include the ends: both readings are here, `"ends"` (±0.2, ±0.0667 m) and `"inset"`
(±0.15, ±0.05 m). K = 3 (both ends and the middle) is ours. Nine tags cover all of them.

Ours as well, since the paper does not say:

- Mass and inertia: a closed box of particle board, 700 kg/m³, with walls of 3 mm; the paper honeycomb that
  fills it is neglected. That makes 0.166 kg. A solid leg would weigh 0.7 kg, more than the youBot may carry.
- Orientation of the tags: they stand, electrical axis along z, because the robot's tags and the reader's antenna
  stand too, and a tag across the field is not heard. A common tag is about 95 mm long and cannot stand on a
  leg 50 mm high; it can only lie along the leg. What can stand is a card of about 44 x 44 mm. The end tags are
  such cards on the end faces, the others stand upright inside, in the plane y = 0 of the 44 mm cavity. Roll the
  leg by a quarter turn and the electrical axis is horizontal again, unless the card has two crossed dipoles.
- Counterparts: with the hand over the middle and the jaws closing across the leg, both hand tags are equally
  far from the tags at +x and -x. Each hand tag belongs to a nearest tag: the middle one if there is one, else
  the left hand tag to the one at +x, the right hand tag to the one at -x.
"""

import numpy as np

from rfcompass.recordings.parts.exchange import PartCollection
from rfcompass.types.parts import PART_FRAME, Assembly, Part, TagSelection
from rfcompass.types.shapes import Box
from rfcompass.types.tags import TagLayout

LEGS = 4
LEG_SIZE_M = (0.40, 0.05, 0.05)
WALL_M = 0.003
BOARD_KG_M3 = 700.0

HALF_M = LEG_SIZE_M[0] / 2
TAG_X_M = (-HALF_M, -0.15, -HALF_M / 3, -0.05, 0.0, 0.05, HALF_M / 3, 0.15, HALF_M)
END_TAGS = (1, 2, 8, 9)  # outermost tags of a layout, counted from 1 as in the EPC

# Tags in use by (K, spacing), and the counterparts of the left and right hand tag.
SELECTIONS = {
    (1, "ends"): ((5,), (5, 5)),
    (2, "ends"): ((1, 9), (9, 1)),
    (3, "ends"): ((1, 5, 9), (5, 5)),
    (4, "ends"): ((1, 3, 7, 9), (7, 3)),
    (4, "inset"): ((2, 4, 6, 8), (6, 4)),
}


def lack_table() -> PartCollection:
    """Return the legs `table_leg_1` to `table_leg_4` and the assembly `LACK` that lists them."""
    legs = tuple(table_leg(number) for number in range(1, LEGS + 1))
    return PartCollection(legs, (Assembly("LACK", tuple(leg.part_id for leg in legs)),))


def table_leg(number: int) -> Part:
    """Return one leg.

    Args:
        number: Which leg, counted from 1; part of its id and of its EPCs.
    """
    part_id = f"table_leg_{number}"
    outside = Box(np.array(LEG_SIZE_M))
    inside = Box(outside.size_m - 2 * WALL_M)
    outside_kg, inside_kg = BOARD_KG_M3 * outside.volume_m3, BOARD_KG_M3 * inside.volume_m3
    return Part(
        part_id=part_id,
        shape=outside,
        mass_kg=outside_kg - inside_kg,
        inertia_kg_m2=outside_kg * outside.inertia_per_mass_m2 - inside_kg * inside.inertia_per_mass_m2,
        grasp_width_m=LEG_SIZE_M[1],
        tags=_tags(part_id, number),
        selections=tuple(_selection(number, spacing, *tags) for (_, spacing), tags in SELECTIONS.items()),
        material="particle board, hollow",
    )


def leg_epc(leg: int, tag: int) -> str:
    """EPC of a tag on a leg, both counted from 1. A laboratory code: 1a is the header of no product code we know."""
    return f"1ac0{leg:016d}{tag:04d}"


def _tags(part_id: str, leg: int) -> TagLayout:
    N = len(TAG_X_M)
    return TagLayout(
        body=part_id,
        epcs=tuple(leg_epc(leg, tag) for tag in range(1, N + 1)),
        frames=(PART_FRAME,) * N,
        points_m=np.array([(x_m, 0.0, 0.0) for x_m in TAG_X_M]),
        dipoles=np.tile([0.0, 0.0, 1.0], (N, 1)),
        roles=tuple("part_end" if tag in END_TAGS else "part" for tag in range(1, N + 1)),
    )


def _selection(leg: int, spacing: str, tags: tuple[int, ...], counterparts: tuple[int, int]) -> TagSelection:
    left, right = counterparts
    return TagSelection(
        epcs=tuple(leg_epc(leg, tag) for tag in tags),
        spacing=spacing,
        counterparts={"hand_left": leg_epc(leg, left), "hand_right": leg_epc(leg, right)},
    )
