"""Survey a scan: the position of every tag from the reads along a known antenna path."""

import logging
from collections.abc import Sequence

from rfcompass.errors import InputError, TagNeverHeard, TooFewReads
from rfcompass.interfaces import Surveyor
from rfcompass.localization.hyperbolic import HyperbolicSurveyor
from rfcompass.localization.reads_needed import require_reads
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
    """Locate the tags of a scan.

    The hyperbolic fit takes three or more tags together, since they share the reader; see `HyperbolicSurveyor`. Its
    answers do not depend on which of the tags are asked for. The matched filter takes each on its own.

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
    asked = [scan.trace(epc).epc for epc in (scan.epcs if epcs is None else epcs)]
    volume = default_volume(scan) if search is None else search
    refused = _refused(scan, asked)
    if refused and (epcs is not None or len(refused) == len(asked)):
        raise refused[0]
    for refusal in refused:
        logger.warning("left out: %s", refusal.message)
    unheard = {refusal.numbers["epc"] for refusal in refused}
    return _locate(surveyor, scan, [epc for epc in asked if epc not in unheard], volume)


def _refused(scan: Scan, epcs: Sequence[str]) -> list[TooFewReads]:
    """Why tags have too few reads to be located, of those that have."""
    refused: list[TooFewReads] = []
    for epc in epcs:
        try:
            require_reads(scan.trace(epc))
        except TooFewReads as error:
            refused.append(error)
    return refused


def _locate(surveyor: Surveyor, scan: Scan, epcs: Sequence[str], volume: SearchVolume) -> tuple[TagFix, ...]:
    """Each tag on its own, or with all others that were heard, so that the answers do not depend on what was asked."""
    if not isinstance(surveyor, HyperbolicSurveyor):
        return tuple(surveyor.locate(scan.trace(epc), volume) for epc in epcs)
    few = {refusal.numbers["epc"] for refusal in _refused(scan, scan.epcs)}
    heard = [scan.trace(epc) for epc in scan.epcs if epc not in few]
    fixes = {fix.epc: fix for fix in surveyor.locate_together(heard, volume)}
    return tuple(fixes[epc] for epc in epcs)


def _surveyor(method: str | Surveyor) -> Surveyor:
    if not isinstance(method, str):
        return method
    if method not in SURVEYORS:
        known = ", ".join(SURVEYORS)
        raise InputError(f"no survey method {method!r}; known: {known}", method=method, known=list(SURVEYORS))
    return SURVEYORS[method]
