"""What a reader makes of a channel: thermal noise, its own carrier, phase noise, half turns, outliers, rounding.

Constants are marked measured where a recording stands behind them, ours where none does.
"""

from dataclasses import dataclass

import numpy as np

from rfcompass.arrays import ComplexArray, FloatArray
from rfcompass.errors import InputError
from rfcompass.types.record import Record


@dataclass(frozen=True, slots=True, kw_only=True)
class NoiseModel(Record):
    """How badly a reader hears, for each read on its own.

    Attributes:
        phase_rad: Standard deviation of the phase, whatever the power [rad].
        flip_probability: Chance of a half turn.
        outlier_probability: Chance that the phase is anything.
        thermal_dbm: Noise of the receiver, kTB and noise figure; -inf for none [dBm].
        self_jammer_dbm: What is left of the reader's own carrier; -inf for none [dBm].
        decode_snr_db: Signal to noise ratio below which no answer is decoded; -inf decodes everything [dB].
        rssi_db: Standard deviation of the reported power [dB].
        phase_step_rad: Rounding of the reported phase; 0 for none [rad].
        rssi_step_db: Rounding of the reported power; 0 for none [dB].
        half_turns: Whether the phase is known up to half a turn only, as the trace must then say.
        reports_iq: Whether the reader reports the complex channel too.
    """

    phase_rad: float = 0.0
    flip_probability: float = 0.0
    outlier_probability: float = 0.0
    thermal_dbm: float = -np.inf
    self_jammer_dbm: float = -np.inf
    decode_snr_db: float = -np.inf
    rssi_db: float = 0.0
    phase_step_rad: float = 0.0
    rssi_step_db: float = 0.0
    half_turns: bool = False
    reports_iq: bool = False

    def __post_init__(self) -> None:
        """Check the numbers."""
        for key in ("phase_rad", "rssi_db", "phase_step_rad", "rssi_step_db"):
            if not (np.isfinite(value := getattr(self, key)) and value >= 0):
                raise InputError(f"NoiseModel.{key}: {value} is not a finite number >= 0", key=key, got=value)
        for key in ("flip_probability", "outlier_probability"):
            if not 0 <= (value := getattr(self, key)) <= 1:
                raise InputError(f"NoiseModel.{key}: {value} is not in [0, 1]", key=key, got=value)
        for key in ("thermal_dbm", "self_jammer_dbm", "decode_snr_db"):
            if not (value := getattr(self, key)) < np.inf:
                raise InputError(f"NoiseModel.{key}: {value} is not a number below infinity", key=key, got=value)

    @property
    def floor_dbm(self) -> float:
        """Thermal noise and self-jammer together [dBm]."""
        total_mw = 10.0 ** (self.thermal_dbm / 10.0) + 10.0 ** (self.self_jammer_dbm / 10.0)
        return float(10.0 * np.log10(total_mw)) if total_mw > 0 else -np.inf

    @property
    def sensitivity_dbm(self) -> float:
        """Weakest echo that is decoded [dBm]."""
        return -np.inf if -np.inf in (self.floor_dbm, self.decode_snr_db) else self.floor_dbm + self.decode_snr_db

    def heard(self, h: ComplexArray, rng: np.random.Generator) -> ComplexArray:
        """Return one noisy sample for each channel; all draws are made whatever the model, so that seeds compare.

        Args:
            h: Channel [√mW], any shape.
            rng: Source of the noise.
        """
        sigma = np.sqrt(10.0 ** (self.floor_dbm / 10.0) / 2.0)
        noise = rng.normal(0.0, 1.0, (2, *h.shape)) * sigma
        turn = rng.normal(0.0, 1.0, h.shape) * self.phase_rad
        turn += np.pi * (rng.random(h.shape) < self.flip_probability)
        anything = rng.uniform(0.0, 2.0 * np.pi, h.shape)
        turn = np.where(rng.random(h.shape) < self.outlier_probability, anything, turn)
        size = 10.0 ** (rng.normal(0.0, 1.0, h.shape) * self.rssi_db / 20.0)
        return np.asarray((h + noise[0] + 1j * noise[1]) * size * np.exp(1j * turn))

    def reported_phase_rad(self, h: ComplexArray) -> FloatArray:
        """Raw phase as reported, -arg h (phase_sign +1), rounded, in [0, 2π) [rad]."""
        raw = np.mod(-np.angle(h), 2.0 * np.pi)
        if self.phase_step_rad > 0:
            raw = np.round(raw / self.phase_step_rad) * self.phase_step_rad
        return np.asarray(np.where(raw >= 2.0 * np.pi - 1e-12, 0.0, raw))

    def reported_rssi_dbm(self, h: ComplexArray) -> FloatArray:
        """Power as reported, rounded [dBm]."""
        dbm = 20.0 * np.log10(np.maximum(np.abs(h), 1e-15))
        return np.asarray(np.round(dbm / self.rssi_step_db) * self.rssi_step_db if self.rssi_step_db > 0 else dbm)


# No noise at all.
NOISE_NONE = NoiseModel(reports_iq=True)
# Software radio: 0.1 rad, no half turns. Noise over 640 kHz with a noise figure of 10 dB is -106 dBm; what is left of
# the carrier and the ratio that a decoder needs are ours.
NOISE_USRP = NoiseModel(
    phase_rad=0.1, thermal_dbm=-106.0, self_jammer_dbm=-95.0, decode_snr_db=10.0, rssi_db=0.3, reports_iq=True
)
# Commercial reader. 0.16 rad and 0.75 dB are measured (recordings of an R420 that stands still). Outliers of 10 % and
# half turns of 5 % for each read are fitted to the same recordings: 18 % of all pairs of reads of one tag, antenna and
# channel differ by more than π/2, 7 % lie within 0.3 rad of π. Sensitivity -84 dBm (data sheet of its kind of chip,
# with a carrier of +10 dBm at its input), split into floor and ratio by us. Steps: 2π/4096 and 0.01 dB, as in LLRP.
NOISE_R420 = NoiseModel(
    phase_rad=0.16,
    flip_probability=0.05,
    outlier_probability=0.10,
    thermal_dbm=-106.0,
    self_jammer_dbm=-94.0,
    decode_snr_db=10.0,
    rssi_db=0.75,
    phase_step_rad=float(2.0 * np.pi / 4096.0),
    rssi_step_db=0.01,
    half_turns=True,
)
# A bad reader in a bad place: 0.4 rad, 20 % outliers, 0.5 dB steps. Ours.
NOISE_BAD = NoiseModel(
    phase_rad=0.4,
    flip_probability=0.10,
    outlier_probability=0.20,
    thermal_dbm=-106.0,
    self_jammer_dbm=-90.0,
    decode_snr_db=10.0,
    rssi_db=1.5,
    phase_step_rad=float(2.0 * np.pi / 4096.0),
    rssi_step_db=0.5,
    half_turns=True,
)
NOISES = {"none": NOISE_NONE, "usrp": NOISE_USRP, "r420": NOISE_R420, "bad": NOISE_BAD}
