"""Pile scenes of studies: made once, kept as files where a folder is named, so that two studies share them."""

import os
from pathlib import Path

from rfcompass.simulation.piles import PileScene, make_pile, open_pile, write_pile

# A folder that holds scene files, or gets them; scenes are made anew in every trial if it is not set.
FOLDER_VARIABLE = "RFCOMPASS_PILE_SCENES"
# Families of the studies: one pile with ten distractors, and three with the paper's 25. Poured scenes of more piles are
# left out: now and then a seed takes minutes until something is hidden.
FAMILIES = ("covered_1p10", "poured_1p10", "covered_3p25")


def pile_scene(family: str, seed: int) -> PileScene:
    """The scene of a family and a seed whose target is hidden from all scan views.

    A file is taken at its word only where it states this family and seed; contents are checked against their hash.

    Raises:
        NoPile: If no try gave such a scene.
        PileError: If a file in the folder is broken.
    """
    folder = os.environ.get(FOLDER_VARIABLE)
    if not folder:
        return make_pile(family, seed, "hidden")
    file = Path(folder) / f"{family}_{seed}.json"
    if file.exists():
        scene = open_pile(file)
        if (scene.family, scene.seed, scene.target_class) == (family, seed, "hidden"):
            return scene
    scene = make_pile(family, seed, "hidden")
    file.parent.mkdir(parents=True, exist_ok=True)
    write_pile(scene, file)
    return scene
