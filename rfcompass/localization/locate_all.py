"""Locate every tag of a scan; say how sure each place is, or why there is none [Boroushaki2023], section 4.2."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from rfcompass.errors import NoAnswer, TagNeverHeard
from rfcompass.localization.measure_more import MeasureMore, measure_more
from rfcompass.localization.sar import WRIST_SAR, SarSurveyor
from rfcompass.localization.search_volume import default_volume
from rfcompass.types.fixes import TagFix
from rfcompass.types.reads import Scan
from rfcompass.types.record import Record, frozen_mapping
from rfcompass.types.volumes import SearchVolume


@dataclass(frozen=True, slots=True)
class LocatedTags(Record):
    """Where the tags of a scan are. Every tag that was asked for is in `fixes` or in `refusals`.

    Attributes:
        fixes: Place of each tag that could be located, by EPC.
        refusals: Why a tag could not be located, by EPC.
        advice: What to measure for each fix that is not confident, by EPC.
    """

    fixes: Mapping[str, TagFix]
    refusals: Mapping[str, NoAnswer]
    advice: Mapping[str, MeasureMore]

    def __post_init__(self) -> None:
        """Freeze the mappings."""
        for name in ("fixes", "refusals", "advice"):
            object.__setattr__(self, name, frozen_mapping(getattr(self, name)))

    @property
    def confident(self) -> tuple[TagFix, ...]:
        """Fixes whose box is small enough: those that a map may rest on."""
        return tuple(fix for fix in self.fixes.values() if fix.confident)


def locate_all(
    scan: Scan,
    volume: SearchVolume | None = None,
    *,
    surveyor: SarSurveyor = WRIST_SAR,
    epcs: Sequence[str] | None = None,
) -> LocatedTags:
    """Locate the tags of a scan, each from its own reads, as [Boroushaki2023] extends Eq. 1-2 to many tags.

    A tag that cannot be located does not stop the others.

    Args:
        scan: Reads along one antenna path.
        volume: Where tags may be, in the scan's frame; see `default_volume` for the default.
        surveyor: How each is located.
        epcs: Tags to locate; by default every one that was heard.

    Raises:
        TagNeverHeard: If no tag was asked for and none was heard.
    """
    wanted = scan.epcs if epcs is None else tuple(epcs)
    if not wanted:
        raise TagNeverHeard("no tag was heard, so that there is nothing to locate", heard=[])
    if not scan.traces:
        return LocatedTags(
            {}, {epc: TagNeverHeard(f"tag {epc} was never heard", epc=epc, heard=[]) for epc in wanted}, {}
        )
    search = default_volume(scan) if volume is None else volume
    answers = {epc: _attempt(scan, epc, search, surveyor) for epc in wanted}
    fixes = {epc: answer for epc, answer in answers.items() if isinstance(answer, TagFix)}
    refusals = {epc: answer for epc, answer in answers.items() if isinstance(answer, NoAnswer)}
    advice = {epc: measure_more(scan.trace(epc), fix, search, surveyor) for epc, fix in fixes.items()}
    return LocatedTags(fixes, refusals, {epc: more for epc, more in advice.items() if more is not None})


def _attempt(scan: Scan, epc: str, search: SearchVolume, surveyor: SarSurveyor) -> TagFix | NoAnswer:
    try:
        return surveyor.locate(scan.trace(epc), search)
    except NoAnswer as refusal:
        return refusal
