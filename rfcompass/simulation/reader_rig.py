"""A reader as a rig: which antennas, which carriers, how much power, how much noise."""

from dataclasses import dataclass, field, replace
from typing import TypeAlias

import numpy as np
import numpy.typing as npt

from rfcompass.arrays import FloatArray, read_only
from rfcompass.errors import InputError
from rfcompass.simulation.antennas import LOG_PERIODIC, PATCH_CIRCULAR, VERT900, AntennaModel, look_along
from rfcompass.simulation.gen2 import Gen2Slots
from rfcompass.simulation.reader_noise import NOISE_R420, NOISE_USRP, NoiseModel
from rfcompass.simulation.tracks import AntennaTrack
from rfcompass.types.record import Record

FCC_HZ: FloatArray = np.linspace(902.75e6, 927.25e6, 50)
ETSI_HZ: FloatArray = np.linspace(865.7e6, 867.5e6, 4)


@dataclass(frozen=True, slots=True)
class FixedTransmitters(Record):
    """Antennas that stand still and power the tags, one after the other, while another one listens.

    Attributes:
        positions_m: Phase centres in the scene [m], shape (X, 3).
        rotations: R_scene_antenna, shape (X, 3, 3).
        model: Their type.
        first_port: Reader port of the first one; the others follow. They must differ from the receiver's.
    """

    positions_m: FloatArray
    rotations: FloatArray
    model: AntennaModel
    first_port: int = 101

    def __post_init__(self) -> None:
        """Freeze the arrays and check that there is one at least."""
        X = len(self.positions_m)
        if not X:
            raise InputError("FixedTransmitters: at least one is needed", key="positions_m")
        positions_m = read_only(self.positions_m, "FixedTransmitters.positions_m", (X, 3))
        object.__setattr__(self, "positions_m", positions_m)
        object.__setattr__(self, "rotations", read_only(self.rotations, "FixedTransmitters.rotations", (X, 3, 3)))

    @classmethod
    def looking_at(
        cls, positions_m: npt.ArrayLike, target_m: npt.ArrayLike, model: AntennaModel
    ) -> "FixedTransmitters":
        """Point every transmitter at one place [m], shape (3,)."""
        places = read_only(positions_m, "FixedTransmitters.positions_m", (None, 3))
        return cls(places, np.array([look_along(np.asarray(target_m) - place) for place in places]), model)

    @property
    def ports(self) -> tuple[int, ...]:
        """Reader ports of all of them."""
        return tuple(range(self.first_port, self.first_port + len(self.positions_m)))


@dataclass(frozen=True, slots=True)
class WristTransmitter(Record):
    """A second antenna on the same carrier: the round trip is d_tx + d_rx [Boroushaki2023].

    Attributes:
        offset_m: Its phase centre in the frame of the receiving antenna [m], shape (3,).
        model: Its type; it looks where the receiver looks.
        port: Its reader port; must differ from the receiver's.
    """

    offset_m: FloatArray
    model: AntennaModel
    port: int = 2

    def __post_init__(self) -> None:
        """Freeze the offset."""
        object.__setattr__(self, "offset_m", read_only(self.offset_m, "WristTransmitter.offset_m", (3,)))

    def places(self, track: AntennaTrack) -> FloatArray:
        """Where it is when the receiver goes along `track` [m], shape (M, 3)."""
        return np.asarray(track.positions_m + track.rotations @ self.offset_m)


Transmitters: TypeAlias = FixedTransmitters | WristTransmitter | None


@dataclass(frozen=True, slots=True, kw_only=True)
class ReaderRig(Record):
    """A reader with its antennas.

    Attributes:
        rx: Antenna that moves along the track and listens.
        tx: Who powers the tags; None if it is the same antenna (monostatic).
        frequencies_hz: Carriers, ascending [Hz], shape (F,).
        eirp_dbm: Radiated power at boresight [dBm].
        noise: What the receiver adds.
        slots: Times of the inventory.
        dwell_s: Time at each position of the track, shared by the fixed transmitters [s].
        hop_s: Time on each carrier; None if every read is made at all carriers, as a software radio does [s].
        channel_offsets_rad: What cables and reader add to the raw phase at each carrier [rad], shape (F,); None
            for nothing.
    """

    rx: AntennaModel
    tx: Transmitters = None
    frequencies_hz: FloatArray
    eirp_dbm: float = 36.0
    noise: NoiseModel = field(default_factory=NoiseModel)
    slots: Gen2Slots = field(default_factory=Gen2Slots)
    dwell_s: float = 0.2
    hop_s: float | None = None
    channel_offsets_rad: FloatArray | None = None

    def __post_init__(self) -> None:
        """Freeze the arrays and check the numbers."""
        f_hz = read_only(self.frequencies_hz, "ReaderRig.frequencies_hz", (None,))
        if not f_hz.size or (f_hz <= 0).any() or (np.diff(f_hz) <= 0).any():
            raise InputError("ReaderRig.frequencies_hz: must be positive and ascending", key="frequencies_hz")
        object.__setattr__(self, "frequencies_hz", f_hz)
        if self.channel_offsets_rad is not None:
            offsets = read_only(self.channel_offsets_rad, "ReaderRig.channel_offsets_rad", (f_hz.size,))
            object.__setattr__(self, "channel_offsets_rad", offsets)
        if not np.isfinite(self.eirp_dbm):
            raise InputError(f"ReaderRig.eirp_dbm: {self.eirp_dbm} is not finite", key="eirp_dbm")
        for key in ("dwell_s", "hop_s"):
            value = getattr(self, key)
            if value is not None and not (np.isfinite(value) and value > 0):
                raise InputError(f"ReaderRig.{key}: {value} is not a duration above 0 s", key=key, got=value)

    @property
    def transmit_dbm(self) -> float:
        """Power into the transmitting antenna: EIRP less its gain [dBm]."""
        return self.eirp_dbm - (self.rx if self.tx is None else self.tx.model).gain_dbi

    @property
    def tx_ports(self) -> tuple[int | None, ...]:
        """Reader port of each transmitter; (None,) when monostatic."""
        if isinstance(self.tx, FixedTransmitters):
            return self.tx.ports
        return (None if self.tx is None else self.tx.port,)

    def with_channel_offsets(self, rng: np.random.Generator, *, slope_rad_per_hz: float = -4e-7) -> "ReaderRig":
        """Return the rig with a cable's slope over the carriers and a random constant, one draw for each rig.

        Args:
            rng: Source of the constant.
            slope_rad_per_hz: Slope of the raw phase; -0.2 rad for each 0.5 MHz is measured on two rigs [rad/Hz].
        """
        ramp = slope_rad_per_hz * (self.frequencies_hz - self.frequencies_hz[0])
        return replace(self, channel_offsets_rad=np.mod(ramp + rng.uniform(0.0, 2.0 * np.pi), 2.0 * np.pi))


# RF-Compass: a whip that moves and listens at 920 MHz, circular panels that stand still and send [Wang2013]. Their
# places, in the middle of two walls of the 6 x 5 m room at 1.6 m, and that there are two of them, are ours.
RIG_PAPER = ReaderRig(
    rx=VERT900,
    tx=FixedTransmitters.looking_at([[0.2, 2.5, 1.6], [3.0, 4.8, 1.6]], [3.0, 2.5, 0.2], PATCH_CIRCULAR),
    frequencies_hz=np.array([920e6]),
    noise=NOISE_USRP,
)
# A commercial reader with one circular panel for both ways, hopping through the 50 channels of the FCC.
RIG_R420 = ReaderRig(rx=PATCH_CIRCULAR, frequencies_hz=FCC_HZ, noise=NOISE_R420, hop_s=0.2)
# The same in Europe: four channels; 2 W ERP are 35.2 dBm EIRP.
RIG_R420_ETSI = ReaderRig(rx=PATCH_CIRCULAR, frequencies_hz=ETSI_HZ, eirp_dbm=35.2, noise=NOISE_R420, hop_s=1.0)
# FuseBot's wrist: two linear log-periodic cards [Boroushaki2023]. 200 MHz about 900 MHz and 10 cm apart are ours.
RIG_WRIST = ReaderRig(
    rx=LOG_PERIODIC,
    tx=WristTransmitter(np.array([0.0, 0.10, 0.0]), LOG_PERIODIC),
    frequencies_hz=np.linspace(800e6, 1000e6, 17),
    noise=NOISE_USRP,
)
