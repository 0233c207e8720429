"""Pile scenes of studies: made once, kept as files where a folder is named, so that two studies share them."""

import os
from pathlib import Path

from rfcompass.simulation.piles import PileScene, make_pile, open_pile, write_pile

# A folder that holds scene files, or gets them; scenes are made anew in every trial if it is not set.
FOLDER_VARIABLE = "RFCOMPASS_PILE_SCENES"
# Families of the studies: one pile with ten distractors, and three with the paper's 25. Poured scenes of more piles are
# left out: now and then a seed takes minutes until something is hidden.
FAMILIES = ("covered_1p10", "poured_1p10", "covered_3p25")
HIDDEN = "hidden"


def pile_scene(family: str, seed: int, target_class: str = HIDDEN) -> PileScene:
    """The scene of a family, a seed and a class of target: one that is hidden from all scan views, if none is named.

    A file is taken at its word only where it states this family, seed and class; contents are checked against their
    hash. Each class has files of its own.

    Args:
        family: Name of a family that is shipped.
        seed: Of the pile.
        target_class: `"hidden"`, `"partly"` or `"open"`.

    Raises:
        NoPile: If no try gave such a scene.
        PileError: If a file in the folder is broken.
    """
    folder = os.environ.get(FOLDER_VARIABLE)
    if not folder:
        return make_pile(family, seed, target_class)
    kind = family if target_class == HIDDEN else f"{family}_{target_class}"
    file = Path(folder) / f"{kind}_{seed}.json"
    if file.exists():
        scene = open_pile(file)
        if (scene.family, scene.seed, scene.target_class) == (family, seed, target_class):
            return scene
    scene = make_pile(family, seed, target_class)
    file.parent.mkdir(parents=True, exist_ok=True)
    write_pile(scene, file)
    return scene
