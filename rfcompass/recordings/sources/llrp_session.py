"""What is said on a fresh LLRP connection: who are you, report everything, start; and in the end stop."""

from dataclasses import dataclass

from llrpkit.constants import IMPINJ_PEN
from llrpkit.exceptions import CapabilityError
from llrpkit.inventory import build_rospec
from llrpkit.protocol import enums, impinj, messages, params
from llrpkit.reader import ReaderCapabilities

from rfcompass.errors import InputError, ReaderError, ReaderRefused
from rfcompass.recordings.sources.llrp_link import LlrpLink
from rfcompass.recordings.sources.llrp_reads import frequency_table_hz
from rfcompass.types.record import Record

_ROSPEC_ID = 1
_ALL = 0  # LLRP's number for "all of them"

# How often a reader that has nothing to report shows that it is alive; three misses are a broken link (ours).
KEEPALIVE_S = 2.0
SILENCE_S = 3.0 * KEEPALIVE_S


@dataclass(frozen=True, slots=True, kw_only=True)
class InventorySettings(Record):
    """How the reader is asked to read.

    Attributes:
        tx_power_dbm: Transmit power, rounded down to the reader's table [dBm]; the reader's own choice if None.
        session: Gen2 session, 0 to 3.
        search_mode: Impinj search mode; 2, dual target, reads every tag again and again, as a sweep needs.
        mode_index: RF mode by the reader's number; its own choice if None.
        tag_population: Expected number of tags.
        hop_table_id: Which hop table is in use, for readers that have several.
    """

    tx_power_dbm: float | None = None
    session: int = 1
    search_mode: int | None = 2
    mode_index: int | None = None
    tag_population: int = 32
    hop_table_id: int | None = None

    def __post_init__(self) -> None:
        """Check what no reader could do."""
        if self.session not in range(4):
            raise InputError(f"InventorySettings.session: {self.session} is none of 0 to 3", session=self.session)
        if self.tag_population < 1:
            raise InputError(
                f"InventorySettings.tag_population: {self.tag_population}", tag_population=self.tag_population
            )


@dataclass(frozen=True, slots=True)
class ReaderInfo(Record):
    """What a reader says about itself.

    Attributes:
        description: Make, model and firmware.
        frequencies_hz: Carrier of channel index 1, 2, … [Hz].
        antennas: Number of its ports.
    """

    description: str
    frequencies_hz: tuple[float, ...]
    antennas: int


def prepare_inventory(link: LlrpLink, settings: InventorySettings, antennas: tuple[int, ...]) -> ReaderInfo:
    """Learn what the reader can do, make it forget what it was told before, and tell it to report each read.

    Whatever reports arrive up to here belong to somebody else's inventory.

    Args:
        link: A fresh connection.
        settings: How to read.
        antennas: Ports to read from; all of them if empty.

    Raises:
        LinkLost: If the connection breaks.
        ReaderRefused: If the reader refuses a request or states no frequencies.
    """
    answer = link.request(messages.GET_READER_CAPABILITIES(requested_data=_ALL))
    if not isinstance(answer, messages.GET_READER_CAPABILITIES_RESPONSE):
        raise ReaderRefused(f"the reader answers a request for its capabilities with {type(answer).__name__}")
    capabilities = ReaderCapabilities(answer)
    if capabilities.is_impinj:
        link.request(impinj.IMPINJ_ENABLE_EXTENSIONS())
    link.request(_configuration())
    link.request(messages.DELETE_ROSPEC(ro_spec_id=_ALL))
    link.request(messages.ADD_ROSPEC(ro_spec=_rospec(capabilities, settings, antennas)))
    link.request(messages.ENABLE_ROSPEC(ro_spec_id=_ROSPEC_ID))
    return _info(capabilities, frequency_table_hz(answer, settings.hop_table_id))


def start_inventory(link: LlrpLink) -> None:
    """Start reading.

    Raises:
        ReaderError: If the connection breaks or the reader refuses.
    """
    link.request(messages.START_ROSPEC(ro_spec_id=_ROSPEC_ID))


def stop_inventory(link: LlrpLink) -> None:
    """Stop reading and say goodbye; reports that are still on their way are left for `link.receive`.

    Raises:
        ReaderError: If the connection breaks or the reader refuses.
    """
    link.request(messages.STOP_ROSPEC(ro_spec_id=_ROSPEC_ID))
    link.request(messages.DELETE_ROSPEC(ro_spec_id=_ROSPEC_ID))
    link.request(messages.CLOSE_CONNECTION())


def try_to_stop(link: LlrpLink) -> None:
    """Stop reading if the reader will have it; a reader that is gone has stopped for us anyway."""
    try:
        stop_inventory(link)
    except ReaderError:
        return


def _configuration() -> messages.SET_READER_CONFIG:
    periodic = params.KeepaliveSpec(
        keepalive_trigger_type=enums.KeepaliveTriggerType.Periodic, periodic_trigger_value=int(1000 * KEEPALIVE_S)
    )
    # Reports held back for a client that comes again would be mixed with those of another inventory.
    held = params.EventsAndReports(hold_events_and_reports_upon_reconnect=False)
    return messages.SET_READER_CONFIG(keepalive_spec=periodic, events_and_reports=held)


def _rospec(capabilities: ReaderCapabilities, settings: InventorySettings, antennas: tuple[int, ...]) -> params.ROSpec:
    power_dbm, octane = settings.tx_power_dbm, capabilities.is_impinj
    return build_rospec(
        ro_spec_id=_ROSPEC_ID,
        antennas=antennas,
        session=settings.session,
        search_mode=settings.search_mode if octane else None,
        mode_index=settings.mode_index,
        transmit_power_index=None if power_dbm is None else _power_index(capabilities, power_dbm),
        hop_table_id=settings.hop_table_id or 1,
        tag_population=settings.tag_population,
        report_every_n=1,
        enable_impinj_reports=octane,
        include_phase=True,
        include_doppler=True,
    )


def _power_index(capabilities: ReaderCapabilities, power_dbm: float) -> int:
    try:
        return capabilities.power_index_for_dbm(power_dbm)
    except CapabilityError as cause:
        powers_dbm = sorted(capabilities.transmit_powers.values())
        raise ReaderRefused(f"{power_dbm} dBm: {cause}", power_dbm=power_dbm, powers_dbm=powers_dbm) from cause


def _info(capabilities: ReaderCapabilities, frequencies_hz: tuple[float, ...]) -> ReaderInfo:
    make = "Impinj" if capabilities.manufacturer == IMPINJ_PEN else f"manufacturer {capabilities.manufacturer}"
    text = f"{make} model {capabilities.model_number}, firmware {capabilities.firmware or 'not stated'}, LLRP"
    return ReaderInfo(text, frequencies_hz, capabilities.max_antennas)
