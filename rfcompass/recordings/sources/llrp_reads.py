"""From a reader's tag report to a read in SI units, with the frequencies that this very reader states."""

import math
from dataclasses import dataclass

from llrpkit.protocol import impinj, messages, params

from rfcompass.errors import ReaderRefused
from rfcompass.types.reads import TagRead

# Octane LLRP: phase in 4096ths of a turn, power in hundredths of a dBm, Doppler shift in sixteenths of a hertz.
PHASE_STEP_RAD = 2.0 * math.pi / 4096.0
RSSI_STEP_DB = 0.01
DOPPLER_STEP_HZ = 1.0 / 16.0

NO_PHASE, NO_RSSI, NO_ANTENNA, NO_CHANNEL = "no_phase", "no_rssi", "no_antenna", "no_channel"
OUTSIDE_TABLE, NO_EPC = "channel_outside_table", "no_epc"


@dataclass(frozen=True, slots=True)
class _Fine:
    """What Impinj's extensions add to a report; None where it is absent."""

    phase_rad: float | None = None
    rssi_dbm: float | None = None
    doppler_hz: float | None = None


def frequency_table_hz(
    capabilities: messages.GET_READER_CAPABILITIES_RESPONSE, hop_table_id: int | None
) -> tuple[float, ...]:
    """Carrier of channel index 1, 2, … as the reader states it [Hz].

    Readers put their hop table in an order of their own, so that no channel plan can be assumed.

    Args:
        capabilities: The reader's answer.
        hop_table_id: Which hop table is in use; may be None if there is one, or if all are equal.

    Raises:
        ReaderRefused: If there is no table, or several and none was chosen; lists the `tables`.
    """
    regulatory = capabilities.regulatory_capabilities
    band = None if regulatory is None else regulatory.uhf_band_capabilities
    if band is None:
        raise ReaderRefused("the reader states no frequency table", tables=[])
    information = band.frequency_information
    if not information.hopping and information.fixed_frequency_table is not None:
        return _in_hz(information.fixed_frequency_table.frequency)
    tables = {table.hop_table_id: _in_hz(table.frequency) for table in information.frequency_hop_tables}
    if hop_table_id is not None and hop_table_id in tables:
        return tables[hop_table_id]
    if hop_table_id is None and len(set(tables.values())) == 1:
        return next(iter(tables.values()))
    known = sorted(tables)
    raise ReaderRefused(f"the reader has hop tables {known}: which is in use?", tables=known, asked=hop_table_id)


def _in_hz(frequencies_khz: list[int]) -> tuple[float, ...]:
    return tuple(1000.0 * khz for khz in frequencies_khz)


def read_of(report: params.TagReportData, frequencies_hz: tuple[float, ...], t_ns: int) -> TagRead | str:
    """Turn one report into a read.

    Power is Impinj's fine value where there is one, else the whole dBm of plain LLRP.

    Args:
        report: As decoded.
        frequencies_hz: Carrier of channel index 1, 2, … [Hz].
        t_ns: Host time of its arrival, UTC [ns].

    Returns:
        The read, or the reason why it is of no use.
    """
    fine, epc = _fine(report), _epc(report)
    if not epc:
        return NO_EPC
    if report.antenna_id is None:
        return NO_ANTENNA
    freq_hz = _carrier_hz(report, frequencies_hz)
    if isinstance(freq_hz, str):
        return freq_hz
    rssi_dbm = _rssi_dbm(report, fine)
    if fine.phase_rad is None or rssi_dbm is None:
        return NO_PHASE if fine.phase_rad is None else NO_RSSI
    return TagRead(
        epc=epc,
        antenna=report.antenna_id.antenna_id,
        freq_hz=freq_hz,
        rssi_dbm=rssi_dbm,
        phase_rad=fine.phase_rad,
        t_ns=t_ns,
        doppler_hz=fine.doppler_hz,
        t_reader_us=reader_clock_us(report),
        channel_index=None if report.channel_index is None else report.channel_index.channel_index,
    )


def _fine(report: params.TagReportData) -> _Fine:
    phase_rad = rssi_dbm = doppler_hz = None
    for extension in report.custom:
        match extension:
            case impinj.ImpinjRFPhaseAngle():
                phase_rad = (extension.phase_angle * PHASE_STEP_RAD) % (2.0 * math.pi)
            case impinj.ImpinjPeakRSSI():
                rssi_dbm = extension.rssi * RSSI_STEP_DB
            case impinj.ImpinjRFDopplerFrequency():
                doppler_hz = extension.doppler_frequency * DOPPLER_STEP_HZ
    return _Fine(phase_rad, rssi_dbm, doppler_hz)


def _epc(report: params.TagReportData) -> str:
    epc = report.epc_parameter
    return epc.epc.hex() if isinstance(epc, params.EPC_96) else epc.epc.data.hex()


def _carrier_hz(report: params.TagReportData, frequencies_hz: tuple[float, ...]) -> float | str:
    if report.channel_index is None:
        return NO_CHANNEL
    index = report.channel_index.channel_index
    freq_hz = frequencies_hz[index - 1] if 1 <= index <= len(frequencies_hz) else 0.0
    return freq_hz if freq_hz > 0.0 else OUTSIDE_TABLE


def _rssi_dbm(report: params.TagReportData, fine: _Fine) -> float | None:
    if fine.rssi_dbm is not None or report.peak_rssi is None:
        return fine.rssi_dbm
    return float(report.peak_rssi.peak_rssi)


def reader_clock_us(report: params.TagReportData) -> int | None:
    """When the reader last heard the tag: with one read in each report, the time of that read."""
    seen = report.last_seen_timestamp_utc or report.first_seen_timestamp_utc
    return None if seen is None else int(seen.microseconds)
