"""What the pages on searching, choosing and grasping show works as it stands: their code is taken from the pages.

Where a page has a whole pile of a family, a small one stands in for it.
"""

import re
from pathlib import Path

import numpy as np
import pytest
from box_scenes import looking_down, see
from extraction_scenes import THREE, question

from planners.extraction import FuseBotPolicy
from rfcompass.errors import NothingToGrasp
from rfcompass.interfaces import ExtractionPolicy
from rfcompass.mapping.camera import points_image
from rfcompass.simulation import piles
from rfcompass.studies import pile_scenes
from rfcompass.types import InstanceMasks

DOCS = Path(__file__).parents[2] / "docs"


def run_page(page, names):
    """Run all Python of a page in its order; what it defines is among the names then."""
    text = (DOCS / page).read_text(encoding="utf-8")
    for block in re.findall(r"```python\n(.*?)```", text, re.DOTALL):
        exec(block, names)
    return names


def test_the_page_on_searching_searches_and_compares_a_policy_of_ones_own(monkeypatch, capsys, tmp_path):
    from simulation.pile_scenes import tiny  # noqa: PLC0415 - skips where MuJoCo is not installed

    asked = []

    def pile(family, seed, target_class="hidden"):
        asked.append((piles.family(family).name, seed, target_class))
        return tiny(target_class)

    monkeypatch.setattr(piles, "make_pile", pile, raising=False)
    monkeypatch.setattr(pile_scenes, "pile_scene", pile)
    names = run_page("search.md", {})
    result = names["result"]
    assert capsys.readouterr().out.split()[:2] == [result.outcome, str(result.actions)]
    names["compare"](FuseBotPolicy(), seeds=[1])
    compared = [line.split() for line in capsys.readouterr().out.splitlines()]
    assert [name for _, name, _ in compared] == ["mine", "ours_plain", "fusebot", "xray_views"]
    assert all(seed == "1" and 1 <= int(actions) <= 15 for seed, _, actions in compared)
    assert asked == [("covered_1p10", 3, "hidden"), ("covered_1p10", 1, "hidden")]
    tags = names["tagged_items_of"](scene := tiny(), "any", 0, 1)
    run = names["SearchRun"].of(names["SearchTask"](scene, tags, 1), names["search_method"]("xray", tags.target_size))
    names["show"](run, run.run(), tmp_path)
    assert {path.name for path in tmp_path.iterdir()} == {"film.html", "report.html"}


def test_the_page_on_choosing_asks_a_policy_and_makes_one():
    names, asked = run_page("extraction.md", {}), question()
    assert names["next_removal"](*asked.parts()).mask_label == FuseBotPolicy().choose(*asked.parts()).mask_label
    policy = names["Highest"]()
    assert isinstance(policy, ExtractionPolicy)
    action = policy.choose(*asked.parts())
    highest = max(range(3), key=lambda k: THREE[k].centre_m[2] + THREE[k].size_m[2] / 2)
    assert action.mask_label == highest + 1
    assert action.score == pytest.approx(THREE[highest].centre_m[2] + THREE[highest].size_m[2] / 2, abs=1e-6)
    assert np.linalg.norm(action.T_world_hand[:2, 3] - THREE[highest].centre_m[:2]) < 0.05
    with pytest.raises(NothingToGrasp):
        policy.choose(asked.grid, asked.view, InstanceMasks(np.zeros_like(asked.masks.labels)), asked.grasps)


def test_the_page_on_grasps_finds_the_best_one_and_takes_a_network():
    names = run_page("grasp_quality.md", {})
    view, labels = see(THREE, looking_down(height_m=0.7), shape=(120, 160))
    T_world_hand, opening_m = names["best_grasp"](view)
    assert 0 < opening_m <= 0.085
    off_m = np.linalg.norm(points_image(view)[..., :2] - T_world_hand[:2, 3], axis=2)
    assert labels.ravel()[off_m.argmin()] > 0
    assert names["best_grasp"](see([], looking_down(height_m=0.7))[0]) is None

    def forward(image):
        assert image.shape == (300, 300)
        return [np.full(image.shape, value) for value in (0.5, 1.0, 0.0, 0.2)]

    maps = names["mine"].quality(view)
    assert (maps.quality[labels > 0].max(), maps.quality[labels == 0].max()) == (0.5, 0.0)
    maps = names["from_ggcnn"](forward).quality(view)
    assert (maps.quality[labels > 0].max(), maps.quality[labels == 0].max()) == (pytest.approx(0.5), 0.0)
