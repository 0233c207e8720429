"""A reader that is none: any source of reads behind an LLRP server, for tests, demonstrations and rehearsals.

The protocol is llrpkit's emulator, taught what real readers do and clients rely on: to take the order to enable events
without an answer, to delete all specs at once, to start on an immediate trigger, and to state a frequency table.
What it reports is not made up: it is what the source hands out, in units of the Octane reports.
"""

import asyncio
import threading
import time
from collections.abc import Coroutine, Iterator, Sequence
from concurrent.futures import Future
from types import TracebackType
from typing import Any, Self

import numpy as np
from llrpkit.emulator import LLRPEmulator
from llrpkit.protocol import BitStr, LLRPMessage, enums, impinj, messages, params

from rfcompass.errors import InputError, ReaderError
from rfcompass.interfaces import ReadSource
from rfcompass.recordings.sources.llrp_reads import DOPPLER_STEP_HZ, PHASE_STEP_RAD, RSSI_STEP_DB
from rfcompass.types.reads import TagRead

FCC_HZ = tuple(902.75e6 + 0.5e6 * k for k in range(50))
"""The 50 channels of the USA."""

_START_S = 10.0


class EmulatedReader:
    """Serves the reads of a source on a TCP port, to one client at a time, in a thread of its own.

    A read goes out once: a client that comes back gets what comes next, and no read is taken from the source while
    nobody listens. Reads of ports that the client did not ask for are skipped. pose_id does not travel: LLRP has no
    word for it.

    Args:
        reads: Where the reads come from; iterated once.
        host: Address to listen on.
        port: TCP port; any free one if 0.
        antennas: Number of ports.
        frequencies_hz: Carriers of its table, in whole kHz [Hz]. A read on another carrier is sent with index 0.
        rng: Shuffles the table, as readers do; None keeps the order.
        extensions: Whether phase, Doppler and fine power are reported on request, as by Impinj's readers.
    """

    def __init__(
        self,
        reads: ReadSource,
        *,
        host: str = "127.0.0.1",
        port: int = 0,
        antennas: int = 4,
        frequencies_hz: Sequence[float] = FCC_HZ,
        rng: np.random.Generator | None = None,
        extensions: bool = True,
    ) -> None:
        self._outlet = _Outlet(reads)
        self._emulator = _Emulator(self._outlet, host, port, antennas)
        self._emulator.table_khz = _table_khz(frequencies_hz, rng)
        self._emulator.extensions = extensions
        self._thread: threading.Thread | None = None
        self._loop: asyncio.AbstractEventLoop | None = None
        self._quit: asyncio.Event | None = None

    @property
    def host(self) -> str:
        """Address that it listens on."""
        return str(self._emulator.host)

    @property
    def port(self) -> int:
        """TCP port; known once it has started, and kept when it starts again."""
        return int(self._emulator.port)

    @property
    def frequencies_hz(self) -> tuple[float, ...]:
        """Its table: carrier of channel index 1, 2, … [Hz]."""
        return tuple(1000.0 * khz for khz in self._emulator.table_khz)

    @property
    def sent(self) -> int:
        """Number of reads that went out."""
        return self._outlet.sent

    @property
    def exhausted(self) -> bool:
        """True once the source has no more reads."""
        return self._outlet.exhausted

    def start(self) -> None:
        """Listen.

        Raises:
            ReaderError: If the port cannot be had.
        """
        started: Future[None] = Future()
        self._thread = threading.Thread(target=lambda: asyncio.run(self._serve(started)), daemon=True)
        self._thread.start()
        try:
            started.result(_START_S)
        except (OSError, TimeoutError) as cause:
            self._thread.join(_START_S)
            message = f"{self.host}:{self.port} cannot be listened on: {cause}"
            raise ReaderError(message, host=self.host, port=self.port) from cause

    def stop(self) -> None:
        """Hang up and stop listening; harmless if it does not listen. `start` goes on where it stopped.

        Raises:
            Exception: What the source raised, if it failed.
        """
        if self._thread is None or self._loop is None or self._quit is None:
            return
        self._loop.call_soon_threadsafe(self._quit.set)
        self._thread.join()
        self._thread = self._loop = None
        if (failure := self._outlet.failure) is not None:
            self._outlet.failure = None
            raise failure

    def send_bytes(self, content: bytes) -> None:
        """Write bytes to the client as they are: a way to misbehave, for tests."""
        self._within(self._emulator.send_bytes(content))

    def __enter__(self) -> Self:
        """Listen."""
        self.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Stop."""
        self.stop()

    def _within(self, coroutine: Coroutine[Any, Any, None]) -> None:
        if self._loop is None:
            coroutine.close()
            raise ReaderError("the emulated reader does not listen", host=self.host, port=self.port)
        asyncio.run_coroutine_threadsafe(coroutine, self._loop).result(_START_S)

    async def _serve(self, started: "Future[None]") -> None:
        self._loop, self._quit = asyncio.get_running_loop(), asyncio.Event()
        try:
            await self._emulator.start()
        except OSError as error:
            started.set_exception(error)
            return
        started.set_result(None)
        await self._quit.wait()
        await self._emulator.stop()


def _table_khz(frequencies_hz: Sequence[float], rng: np.random.Generator | None) -> list[int]:
    table_khz = [round(freq_hz / 1000.0) for freq_hz in frequencies_hz]
    for freq_hz, khz in zip(frequencies_hz, table_khz, strict=True):
        if freq_hz <= 0 or abs(1000.0 * khz - freq_hz) > 1.0:
            raise InputError(f"{freq_hz} Hz is no carrier in whole kHz", freq_hz=freq_hz)
    return table_khz if rng is None else rng.permutation(table_khz).tolist()


class _Outlet:
    """Hands out the reads of a source one by one, over all connections together."""

    def __init__(self, source: ReadSource) -> None:
        self.sent = 0
        self.exhausted = False
        self.failure: Exception | None = None
        self._batches: Iterator[Sequence[TagRead]] = iter(source)
        self._waiting: list[TagRead] = []
        self._pulling = threading.Lock()

    async def next(self) -> TagRead | None:
        """The next read, which stays the next one until `take`; None once there is none."""
        while not self._waiting and not self.exhausted:
            await asyncio.to_thread(self._pull)
        return self._waiting[-1] if self._waiting else None

    def take(self, *, sent: bool) -> None:
        """Be done with a read."""
        self._waiting.pop()
        self.sent += sent

    def _pull(self) -> None:
        """Get the next batch, in a thread of its own: a source may sleep, as a live one does; the server must not.

        The client may hang up meanwhile, so that nobody waits for this any more; the batch is kept for the next one.
        """
        with self._pulling:
            if self._waiting or self.exhausted:
                return
            try:
                batch = next(self._batches, None)
            except Exception as error:
                self.failure, batch = error, None
            self._waiting = list(reversed(batch or ()))
            self.exhausted = batch is None


class _Emulator(LLRPEmulator):
    """llrpkit's emulator with a source of reads; overrides private methods of llrpkit 0.3."""

    def __init__(self, outlet: _Outlet, host: str, port: int, antennas: int) -> None:
        super().__init__(host=host, port=port, antenna_count=antennas, firmware="rfcompass emulated reader")
        self._outlet = outlet
        self.table_khz: list[int] = []
        self.extensions = True

    async def send_bytes(self, content: bytes) -> None:
        """Write to the client, whatever it is."""
        if self._writer is not None:
            self._writer.write(content)
            await self._writer.drain()

    async def _handle_message(self, msg: LLRPMessage) -> None:
        match msg:
            case messages.ENABLE_EVENTS_AND_REPORTS():
                return  # has no answer
            case messages.DELETE_ROSPEC(ro_spec_id=0):
                self._rospecs.clear()
                self._sync_reporting()
                answer = messages.DELETE_ROSPEC_RESPONSE(llrp_status=self._status_ok())
                await self._send(answer, message_id=msg.message_id)
            case _:
                await super()._handle_message(msg)
                if isinstance(msg, messages.ENABLE_ROSPEC):
                    self._start_at_once(msg.ro_spec_id)

    def _start_at_once(self, ro_spec_id: int) -> None:
        spec, state = self._rospecs.get(ro_spec_id, (None, ""))
        if spec is None or state != "Enabled":
            return
        trigger = spec.ro_boundary_spec.ro_spec_start_trigger.ro_spec_start_trigger_type
        if trigger == enums.ROSpecStartTriggerType.Immediate:
            self._rospecs[ro_spec_id] = (spec, "Active")
            self._sync_reporting()

    def _capabilities_response(self) -> messages.GET_READER_CAPABILITIES_RESPONSE:
        response = super()._capabilities_response()
        if not self.extensions and response.general_device_capabilities is not None:
            response.general_device_capabilities.device_manufacturer_name = 0
        regulatory = response.regulatory_capabilities
        if regulatory is not None and regulatory.uhf_band_capabilities is not None:
            table = params.FrequencyHopTable(hop_table_id=1, frequency=self.table_khz)
            regulatory.uhf_band_capabilities.frequency_information.frequency_hop_tables = [table]
        return response

    async def _report_loop(self) -> None:
        profile = self._scan_profile()
        index_of = {khz: index for index, khz in enumerate(self.table_khz, start=1)}
        while (read := await self._outlet.next()) is not None:
            asked = read.antenna in profile.antennas
            if asked and self._writer is not None:
                report = _report(read, index_of.get(round(read.freq_hz / 1000.0), 0), profile.content)
                # Writing and counting are one step: a read is either not out yet, or out and never out again.
                self._writer.write(messages.RO_ACCESS_REPORT(tag_report_datas=[report]).to_bytes(message_id=0))
            self._outlet.take(sent=asked)
            await self._drain()

    async def _drain(self) -> None:
        """Let the client catch up, and others run."""
        await asyncio.sleep(0)
        if self._writer is not None:
            try:
                await self._writer.drain()
            except OSError:
                self._stop_reporting()


def _report(read: TagRead, channel_index: int, content: set[str]) -> params.TagReportData:
    """One read as a reader with Octane extensions reports it."""
    epc = bytes.fromhex(read.epc)
    now_us = read.t_reader_us if read.t_reader_us is not None else time.time_ns() // 1000
    report = params.TagReportData(
        epc_parameter=params.EPC_96(epc=epc) if len(epc) == 12 else params.EPCData(epc=BitStr.from_bytes(epc)),
        antenna_id=params.AntennaID(antenna_id=read.antenna),
        peak_rssi=params.PeakRSSI(peak_rssi=_clipped(read.rssi_dbm, 1.0, 7)),
        channel_index=params.ChannelIndex(channel_index=channel_index),
        first_seen_timestamp_utc=params.FirstSeenTimestampUTC(microseconds=now_us),
        last_seen_timestamp_utc=params.LastSeenTimestampUTC(microseconds=now_us),
        tag_seen_count=params.TagSeenCount(tag_count=1),
    )
    if "rssi" in content:
        report.custom.append(impinj.ImpinjPeakRSSI(rssi=_clipped(read.rssi_dbm, RSSI_STEP_DB, 15)))
    if "phase" in content:
        report.custom.append(impinj.ImpinjRFPhaseAngle(phase_angle=round(read.phase_rad / PHASE_STEP_RAD) % 4096))
    if "doppler" in content and read.doppler_hz is not None:
        shift = _clipped(read.doppler_hz, DOPPLER_STEP_HZ, 15)
        report.custom.append(impinj.ImpinjRFDopplerFrequency(doppler_frequency=shift))
    return report


def _clipped(value: float, step: float, bits: int) -> int:
    return max(-(1 << bits), min((1 << bits) - 1, round(value / step)))
