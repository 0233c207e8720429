"""What comes back from a tag: down to it, through its chip, and up again."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from rfcompass.arrays import BoolArray, ComplexArray, FloatArray, read_only
from rfcompass.simulation.field import one_way_field
from rfcompass.simulation.placed_tags import PlacedTags
from rfcompass.simulation.radio_scene import RadioScene
from rfcompass.simulation.reader_rig import FixedTransmitters, ReaderRig, WristTransmitter
from rfcompass.simulation.tracks import AntennaTrack
from rfcompass.types.record import Record


@dataclass(frozen=True, slots=True)
class Backscatter(Record):
    """Noise-free channels of all tags and transmitters (X; one if it moves along or is the receiver). This is truth.

    Attributes:
        channel: h, |h|² the received power [√mW], shape (X, M, T, F).
        tag_power_dbm: Power at the chip [dBm], shape (X, M, T, F).
        powered: Whether that is enough, shape (X, M, T, F).
    """

    channel: ComplexArray
    tag_power_dbm: FloatArray
    powered: BoolArray

    @classmethod
    def joined(cls, groups: Sequence["Backscatter"]) -> "Backscatter":
        """Echoes of several groups of tags at the same places of the same reader, as one."""
        names = ("channel", "tag_power_dbm", "powered")
        return cls(*(np.concatenate([getattr(group, name) for group in groups], axis=2) for name in names))

    def __post_init__(self) -> None:
        """Freeze the arrays."""
        shape, set_ = np.shape(self.channel), object.__setattr__
        set_(self, "channel", read_only(self.channel, "Backscatter.channel", shape, np.complex128))
        power = read_only(self.tag_power_dbm, "Backscatter.tag_power_dbm", shape, finite=False)
        set_(self, "tag_power_dbm", power)  # a dipole that looks at the antenna end on gets -inf dBm
        set_(self, "powered", read_only(self.powered, "Backscatter.powered", shape, np.bool_))


def backscatter(radio_scene: RadioScene, rig: ReaderRig, track: AntennaTrack, tags: PlacedTags) -> Backscatter:
    """Compute every tag's channel at every place of the receiver.

        h = √P Σ_p h_down,p e^{jφ_p} h_up,p · 10^(-loss/20) · e^{jφ_tag} · e^{-j o(f)},

    P the power into the transmitting antenna, φ_p the phase of port p, o(f) the channel offset; monostatic h_down =
    h_up. The chip gets P Σ_p |h_down,p|².

    Args:
        radio_scene: What is in between.
        rig: Antennas, carriers and power; its noise is left out.
        track: Where the receiver is.
        tags: Where the tags are.

    Raises:
        InputError: If an antenna or a tag is outside the room, or both are in one place.
    """
    up = one_way_field(
        radio_scene, track.positions_m, track.rotations, rig.rx, tags, rig.frequencies_hz, track.ports
    )[None]  # fmt: skip
    down = up if rig.tx is None else _down(radio_scene, rig.tx, track, tags, rig.frequencies_hz)
    model, P_mw = tags.model, 10.0 ** (rig.transmit_dbm / 10.0)
    port = np.exp(1j * model.port_phase_rad * np.arange(up.shape[3]))
    constant = np.exp(1j * tags.phase_rad) * 10.0 ** (-model.backscatter_loss_db / 20.0)
    offsets = 1.0 if rig.channel_offsets_rad is None else np.exp(-1j * rig.channel_offsets_rad)
    h = np.sqrt(P_mw) * np.einsum("xmtpf,xmtpf,p->xmtf", *np.broadcast_arrays(down, up), port)
    with np.errstate(divide="ignore"):
        power_dbm = rig.transmit_dbm + 10.0 * np.log10((np.abs(down) ** 2).sum(axis=3))
    power_dbm = np.broadcast_to(power_dbm, h.shape)
    return Backscatter(h * constant[:, None] * offsets, power_dbm, power_dbm >= model.sensitivity_dbm)


def _down(
    radio_scene: RadioScene,
    tx: FixedTransmitters | WristTransmitter,
    track: AntennaTrack,
    tags: PlacedTags,
    f_hz: FloatArray,
) -> ComplexArray:
    """Field of the transmitters at the tags, (X, 1, T, P, F) if they stand still, (1, M, T, P, F) on the wrist."""
    if isinstance(tx, FixedTransmitters):
        return one_way_field(radio_scene, tx.positions_m, tx.rotations, tx.model, tags, f_hz)[:, None]
    return one_way_field(radio_scene, tx.places(track), track.rotations, tx.model, tags, f_hz)[None]
