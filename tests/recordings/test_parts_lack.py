"""The shipped table: the paper's dimensions and tag places, and a weight that follows from the walls."""

import numpy as np
import pytest

from rfcompass.recordings.parts.lack import BOARD_KG_M3, WALL_M, lack_table, table_leg


def test_the_product_lists_its_four_legs():
    table = lack_table()
    assert [assembly.name for assembly in table.assemblies] == ["LACK"]
    assert table.assemblies[0].part_ids == tuple(f"table_leg_{i}" for i in (1, 2, 3, 4))


@pytest.mark.parametrize(
    ("K", "spacing", "x_cm"),
    [
        (1, "ends", [0]),
        (2, "ends", [-20, 20]),
        (3, "ends", [-20, 0, 20]),
        (4, "ends", [-20, -20 / 3, 20 / 3, 20]),
        (4, "inset", [-15, -5, 5, 15]),
    ],
)
def test_tags_are_where_the_paper_has_them(K, spacing, x_cm):
    layout = table_leg(3).layout(K, spacing)
    assert np.allclose(layout.points_m, np.column_stack([np.array(x_cm) / 100, np.zeros((K, 2))]))
    assert np.array_equal(layout.dipoles, np.tile([0, 0, 1], (K, 1)))
    assert layout.with_role("part_end") == ((0, K - 1) if K > 1 else ())


def test_evenly_spaced_means_equal_gaps_in_both_readings():
    for spacing in ("ends", "inset"):
        gaps = np.diff(table_leg(1).layout(4, spacing).points_m[:, 0])
        assert np.allclose(gaps, gaps[0])


def test_each_hand_tag_belongs_to_a_nearest_tag_and_left_and_right_part_where_they_can():
    hand_tags_m = {"hand_left": np.array([0, 0.06, 0]), "hand_right": np.array([0, -0.06, 0])}
    leg = table_leg(2)
    for selection in leg.selections:
        layout = leg.layout(selection.K, selection.spacing)
        pairs = layout.counterparts[selection.K]
        assert set(pairs) == set(hand_tags_m)
        for role, hand_m in hand_tags_m.items():
            distances = np.linalg.norm(layout.points_m - hand_m, axis=1)
            assert np.isclose(distances[pairs[role]], distances.min())
        assert (pairs["hand_left"] != pairs["hand_right"]) == (selection.K % 2 == 0)


def test_a_leg_weighs_as_much_as_its_six_walls():
    leg, corners = table_leg(1), []
    for axis in range(3):  # two walls across each axis, without the corners that the former walls took
        size = leg.size_m - 2 * WALL_M * (np.arange(3) < axis)
        size[axis] = WALL_M
        corners.append(2 * np.prod(size))
    assert np.isclose(leg.mass_kg, BOARD_KG_M3 * sum(corners))
    assert leg.mass_kg < 0.5  # payload of the youBot


def test_a_leg_turns_harder_than_a_solid_one_of_its_weight():
    leg = table_leg(1)
    assert (np.diag(leg.inertia_kg_m2) > leg.mass_kg * np.diag(leg.shape.inertia_per_mass_m2)).all()


def test_no_epc_is_on_two_legs():
    epcs = [epc for leg in lack_table().parts for epc in leg.tags.epcs]
    assert len(set(epcs)) == len(epcs) == 36
