"""One stop of a simulated reader: what it reports, and why it missed what it missed."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from rfcompass.arrays import BoolArray, ComplexArray, FloatArray, IntArray, read_only
from rfcompass.errors import InputError, ShapeError
from rfcompass.simulation.echoes import Backscatter, backscatter
from rfcompass.simulation.gen2 import SlotLog, run_slots
from rfcompass.simulation.placed_tags import PlacedTags
from rfcompass.simulation.radio_scene import RadioScene
from rfcompass.simulation.reader_rig import FixedTransmitters, ReaderRig, WristTransmitter
from rfcompass.simulation.tracks import AntennaTrack
from rfcompass.types.reads import TagRead
from rfcompass.types.record import Record
from rfcompass.types.tags import check_distinct


class AntennaRow(NamedTuple):
    """Where one antenna was believed to be at one pose: a line of `antenna_poses.csv`."""

    pose_id: int
    antenna: int
    position_m: FloatArray
    rotation: FloatArray


@dataclass(frozen=True, slots=True)
class Misses(Record):
    """Why tags were not read more often, in windows of time (position, transmitter and carrier). This is truth.

    Attributes:
        windows: How many windows there were.
        not_powered: Windows in which a tag had too little power, shape (T,).
        below_floor: Windows in which it had power, but its echo was too weak, shape (T,).
        collided: Answers that were lost in a collision, shape (T,).
    """

    windows: int
    not_powered: IntArray
    below_floor: IntArray
    collided: IntArray

    def __post_init__(self) -> None:
        """Freeze the arrays."""
        for name in ("not_powered", "below_floor", "collided"):
            value = read_only(getattr(self, name), f"Misses.{name}", np.shape(self.not_powered), np.int64)
            object.__setattr__(self, name, value)


@dataclass(frozen=True, slots=True)
class Inventory(Record):
    """Everything a reader reported at one stop (R samples), where it believed its antennas to be, and what it missed.

    Attributes:
        rig: The reader.
        nominal_track: Where the carrier believed the receiving antenna to be.
        epcs: EPC of each tag in reach, heard or not (T).
        poses: Position on the track of each sample, shape (R,).
        tags: Tag of each sample, shape (R,).
        transmitters: Transmitter of each sample, from 0, shape (R,).
        channels: Carrier of each sample, from 0, shape (R,).
        times_s: When, from the start of the stop, ascending [s], shape (R,).
        heard: Noisy complex channel [√mW], shape (R,).
        powered: Whether a tag had power at any time, shape (T,).
        misses: Why tags were not read more often.
    """

    rig: ReaderRig
    nominal_track: AntennaTrack
    epcs: tuple[str, ...]
    poses: IntArray
    tags: IntArray
    transmitters: IntArray
    channels: IntArray
    times_s: FloatArray
    heard: ComplexArray = field(repr=False)
    powered: BoolArray
    misses: Misses

    def __post_init__(self) -> None:
        """Freeze the arrays."""
        R, set_ = len(self.poses), object.__setattr__
        for name in ("poses", "tags", "transmitters", "channels"):
            set_(self, name, read_only(getattr(self, name), f"Inventory.{name}", (R,), np.int64))
        set_(self, "times_s", read_only(self.times_s, "Inventory.times_s", (R,)))
        set_(self, "heard", read_only(self.heard, "Inventory.heard", (R,), np.complex128))
        set_(self, "powered", read_only(self.powered, "Inventory.powered", (len(self.epcs),), np.bool_))

    def __len__(self) -> int:
        return len(self.poses)

    @property
    def antenna_positions_m(self) -> FloatArray:
        """Where the receiving antenna was believed to be [m], shape (M, 3)."""
        return self.nominal_track.positions_m

    @property
    def half_turns(self) -> bool:
        """Whether phases are known up to half a turn only (`phase_modulus` of a trace: `"pi"`)."""
        return self.rig.noise.half_turns

    @property
    def reads_per_tag(self) -> IntArray:
        """Samples of each tag, shape (T,)."""
        return np.bincount(self.tags, minlength=len(self.epcs)).astype(np.int64)

    def reads(self, *, first_pose_id: int = 0, start_ns: int = 0) -> tuple[TagRead, ...]:
        """Return what the reader reports, in the order of time.

        The raw phase follows phase_sign = +1, -arg h. A rig that reports I/Q gives the complex channel as well.

        Args:
            first_pose_id: Number of the first position of the track.
            start_ns: Host time at the start of the stop, UTC [ns].
        """
        noise, f_hz = self.rig.noise, self.rig.frequencies_hz
        rssi_dbm, phase_rad = noise.reported_rssi_dbm(self.heard), noise.reported_phase_rad(self.heard)
        t_us = np.round(self.times_s * 1e6).astype(np.int64)
        samples = zip(
            self.tags.tolist(), self.poses.tolist(), self.transmitters.tolist(), self.channels.tolist(), strict=True
        )
        columns = zip(samples, rssi_dbm.tolist(), phase_rad.tolist(), t_us.tolist(), self.heard.tolist(), strict=True)
        ports, tx_ports, epcs = self.nominal_track.ports.tolist(), self.rig.tx_ports, self.epcs
        return tuple(
            TagRead(
                epc=epcs[tag],
                antenna=ports[pose],
                freq_hz=float(f_hz[channel]),
                rssi_dbm=dbm,
                phase_rad=phase,
                pose_id=first_pose_id + pose,
                t_ns=start_ns + 1000 * us,
                tx_antenna=tx_ports[tx],
                i=h.real if noise.reports_iq else None,
                q=h.imag if noise.reports_iq else None,
                t_reader_us=start_ns // 1000 + us,
                channel_index=channel + 1,
            )
            for (tag, pose, tx, channel), dbm, phase, us, h in columns
        )

    def antenna_rows(self, *, first_pose_id: int = 0) -> Iterator[AntennaRow]:
        """Yield where every antenna was believed to be at every pose, transmitters included.

        Args:
            first_pose_id: Number of the first position of the track.
        """
        track, tx = self.nominal_track, self.rig.tx
        wrist_m = tx.places(track) if isinstance(tx, WristTransmitter) else track.positions_m
        for m, port in enumerate(track.ports.tolist()):
            yield AntennaRow(first_pose_id + m, port, track.positions_m[m], track.rotations[m])
            if isinstance(tx, WristTransmitter):
                yield AntennaRow(first_pose_id + m, tx.port, wrist_m[m], track.rotations[m])
            elif isinstance(tx, FixedTransmitters):
                for x, tx_port in enumerate(tx.ports):
                    yield AntennaRow(first_pose_id + m, tx_port, tx.positions_m[x], tx.rotations[x])


class _Windows(NamedTuple):
    """Stretches of time with one position, transmitter and carrier, shape (W,); `starts_s` has the end as well."""

    starts_s: FloatArray
    poses: IntArray
    transmitters: IntArray
    channels: IntArray


def simulate_inventory(
    radio_scene: RadioScene,
    rig: ReaderRig,
    track: AntennaTrack,
    tags: PlacedTags | Sequence[PlacedTags],
    rng: np.random.Generator,
    *,
    nominal_track: AntennaTrack | None = None,
) -> Inventory:
    """Let a reader take the inventory along a track.

    A tag answers in a window of time if its chip has power and its echo is strong enough; slotted ALOHA decides when.
    Every read adds its own noise.

    Args:
        radio_scene: What is in between.
        rig: The reader.
        track: Where the receiving antenna truly goes.
        tags: Where the tags truly are; several groups where they are of several types.
        rng: Source of slots, hops and noise.
        nominal_track: Where its carrier believes that it goes; the true track if left out.

    Raises:
        ShapeError: If the two tracks do not have the same positions and ports.
        InputError: If an antenna or a tag is outside the room, both are in one place, or a port sends and receives.
        DuplicateEpc: If two tags have one EPC.
    """
    groups = (tags,) if isinstance(tags, PlacedTags) else tuple(tags)
    epcs = check_distinct([epc for group in groups for epc in group.epcs], "simulate_inventory")
    believed = track if nominal_track is None else nominal_track
    if len(believed) != len(track) or (believed.ports != track.ports).any():
        raise ShapeError(
            f"nominal_track: {len(believed)} positions, true {len(track)}, or other ports", got=len(believed)
        )
    if shared := set(track.ports.tolist()) & set(rig.tx_ports):
        raise InputError(f"ports {sorted(map(str, shared))} both send and receive in a bistatic rig", got=list(shared))
    air = Backscatter.joined([backscatter(radio_scene, rig, track, group) for group in groups])
    windows = _windows(rig, len(track))
    if rig.hop_s is not None:
        windows = _cut_at_hops(windows, rig.hop_s, len(rig.frequencies_hz), rng)
    powered, h = _at(air, windows)
    with np.errstate(divide="ignore"):
        echo_dbm = 20.0 * np.log10(np.abs(h))
    strong = echo_dbm >= rig.noise.sensitivity_dbm
    log = run_slots(rig.slots, windows.starts_s, echo_dbm, powered & strong, rng)
    misses = Misses(
        len(windows.poses), (~powered).sum(axis=0), (powered & ~strong).sum(axis=0), log.collided.sum(axis=0)
    )
    return _report(rig, believed, epcs, (air, windows, log), (np.asarray(powered.any(axis=0)), misses), rng)


def _windows(rig: ReaderRig, M: int) -> _Windows:
    """One window for each position and transmitter; the carrier in the middle of the band powers the tags."""
    X, F = len(rig.tx_ports), len(rig.frequencies_hz)
    starts_s = np.linspace(0.0, M * rig.dwell_s, M * X + 1)
    poses, transmitters = np.divmod(np.arange(M * X), X)
    return _Windows(starts_s, poses, transmitters, np.full(M * X, F // 2))


def _cut_at_hops(still: _Windows, hop_s: float, F: int, rng: np.random.Generator) -> _Windows:
    """Cut windows where the carrier changes; hops go through random orders of all F carriers."""
    hops = int(np.ceil(still.starts_s[-1] / hop_s))
    order = np.concatenate([rng.permutation(F) for _ in range(hops // F + 1)])
    cuts_s = np.unique(np.concatenate([still.starts_s, np.arange(hops) * hop_s]))
    cuts_s = cuts_s[np.concatenate([[True], np.diff(cuts_s) > 1e-9])]
    middle_s = (cuts_s[1:] + cuts_s[:-1]) / 2.0
    window = np.searchsorted(still.starts_s, middle_s, side="right") - 1
    channels = order[(middle_s / hop_s).astype(np.int64)]
    return _Windows(cuts_s, still.poses[window], still.transmitters[window], channels)


def _at(air: Backscatter, windows: _Windows) -> tuple[BoolArray, ComplexArray]:
    """Power and channel of each tag in each window, (W, T)."""
    place = windows.transmitters, windows.poses, slice(None), windows.channels
    return air.powered[place], air.channel[place]


def _report(
    rig: ReaderRig,
    believed: AntennaTrack,
    epcs: tuple[str, ...],
    run: tuple[Backscatter, _Windows, SlotLog],
    verdict: tuple[BoolArray, Misses],
    rng: np.random.Generator,
) -> Inventory:
    """Sample the channel at every read; without hops each read is made at all carriers."""
    air, windows, log = run
    each = 1 if rig.hop_s is not None else len(rig.frequencies_hz)
    w, t = np.repeat(log.windows, each), np.repeat(log.tags, each)
    channels = windows.channels[w] if rig.hop_s is not None else np.tile(np.arange(each), len(log.windows))
    poses, transmitters = windows.poses[w], windows.transmitters[w]
    heard = rig.noise.heard(air.channel[transmitters, poses, t, channels], rng)
    times_s = np.repeat(log.times_s, each)
    return Inventory(rig, believed, epcs, poses, t, transmitters, channels, times_s, heard, *verdict)
