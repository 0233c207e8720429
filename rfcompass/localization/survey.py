"""Survey a scan: the position of every tag from its own reads along a known antenna path."""

import logging
from collections.abc import Sequence

from rfcompass.errors import InputError, TagNeverHeard, TooFewReads
from rfcompass.interfaces import Surveyor
from rfcompass.localization.hyperbolic import HyperbolicSurveyor
from rfcompass.localization.sar import SarSurveyor
from rfcompass.localization.search_volume import default_volume
from rfcompass.types.fixes import TagFix
from rfcompass.types.reads import Scan
from rfcompass.types.volumes import SearchVolume

SURVEYORS: dict[str, Surveyor] = {"hyperbolic": HyperbolicSurveyor(), "sar": SarSurveyor()}

logger = logging.getLogger(__name__)


def survey(
    scan: Scan,
    method: str | Surveyor = "hyperbolic",
    search: SearchVolume | None = None,
    *,
    epcs: Sequence[str] | None = None,
) -> tuple[TagFix, ...]:
    """Locate the tags of a scan, each on its own.

    Args:
        scan: Reads along one antenna path.
        method: `"hyperbolic"`, `"sar"`, or a surveyor with parameters of your choice.
        search: Where the tags may be, in the scan's frame; see `default_volume` for the default.
        epcs: Tags to locate. By default every tag that was heard; those with too few reads are left out and logged.

    Returns:
        One fix for each tag, in the order asked for or by EPC.

    Raises:
        InputError: If there is no method of that name.
        TagNeverHeard: If a tag that was asked for was never heard, or none at all.
        TooFewReads: If a tag that was asked for, or every tag, has too few reads.
    """
    surveyor = _surveyor(method)
    if not scan.traces:
        raise TagNeverHeard("no tag was heard, so that there is nothing to survey", heard=[])
    traces = [scan.trace(epc) for epc in (scan.epcs if epcs is None else epcs)]
    volume = default_volume(scan) if search is None else search
    fixes: list[TagFix] = []
    refused: list[TooFewReads] = []
    for trace in traces:
        try:
            fixes.append(surveyor.locate(trace, volume))
        except TooFewReads as error:
            refused.append(error)
    if refused and (epcs is not None or not fixes):
        raise refused[0]
    for refusal in refused:
        logger.warning("left out: %s", refusal.message)
    return tuple(fixes)


def _surveyor(method: str | Surveyor) -> Surveyor:
    if not isinstance(method, str):
        return method
    if method not in SURVEYORS:
        known = ", ".join(SURVEYORS)
        raise InputError(f"no survey method {method!r}; known: {known}", method=method, known=list(SURVEYORS))
    return SURVEYORS[method]
