"""The studies that the command line knows, by name."""

from importlib import import_module

from rfcompass.errors import StudyError
from rfcompass.studies.study import Study

# "module:attribute" of each study; its module is imported when the registry is asked, not before.
STUDIES: tuple[str, ...] = (
    "rfcompass.studies.measured:MEASURED_SURVEY",
    "rfcompass.studies.measured:MEASURED_PROXIMITY",
    "rfcompass.studies.comparisons:COMPARISONS",
    "rfcompass.studies.fetches:FETCHES",
    "rfcompass.studies.fetches:FETCHES_ON_A_MAP",
    "rfcompass.studies.path_ratio:PATH_RATIO",
    "rfcompass.studies.measured_target:MEASURED_TARGET",
    "rfcompass.studies.resolution:RESOLUTION",
    "rfcompass.studies.accuracy:ACCURACY",
    "rfcompass.studies.polarisation:POLARISATION",
    "rfcompass.studies.fusebot:FUSEBOT_LOCALISATION",
    "rfcompass.studies.pile_tags:PILE_TAGS",
    "rfcompass.studies.map_quality:MAP_QUALITY",
    "rfcompass.studies.searches:SEARCHES",
    "rfcompass.studies.search_confirm:SEARCH_CONFIRM",
    "rfcompass.studies.search_figures:SEARCH_LEVELS",
    "rfcompass.studies.search_figures:SEARCH_TAGS",
    "rfcompass.studies.search_kernels:SEARCH_KERNELS",
    "rfcompass.studies.search_classes:SEARCH_CLASSES",
    "rfcompass.studies.grasp_trials:GRASP_TRIALS",
)


def all_studies() -> dict[str, Study]:
    """Return every study by its name, in the order of the registry.

    Raises:
        StudyError: If two studies have one name.
    """
    studies: dict[str, Study] = {}
    for place in STUDIES:
        module, attribute = place.split(":")
        study = getattr(import_module(module), attribute)
        if study.name in studies:
            raise StudyError(f"two studies are named {study.name}", name=study.name)
        studies[study.name] = study
    return studies


def study(name: str) -> Study:
    """Return a study by its name.

    Raises:
        StudyError: If there is none; lists those that exist.
    """
    studies = all_studies()
    if name not in studies:
        known = ", ".join(studies) or "none"
        raise StudyError(f"no study {name!r}; known: {known}", name=name, known=list(studies))
    return studies[name]
