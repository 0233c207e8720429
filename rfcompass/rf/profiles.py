"""Multipath profiles: how much power reaches a sliding antenna from each angle to its track [PinIt2013].

B(θ) = Σ_f | Σ_l w_l h(l, f) exp(-j k_f g s_l cos θ) |²,

with positions s_l along the track, window w, wavenumber k_f and g = 2 for an antenna that sends and receives
(round trip), g = 1 if only the receiver moves. A tag ahead in path direction appears at θ = 0, abeam at π/2.
Channels are summed as power, since each has its own unknown phase constant.

Neither the window nor the scale of the profile is printed in [PinIt2013]; they are parameters, and no setting of them
is "the paper's".
"""

from dataclasses import dataclass
from typing import Literal

import numpy as np

from rfcompass.arrays import FloatArray
from rfcompass.errors import InputError
from rfcompass.rf.aperture import Aperture, straight_apertures
from rfcompass.rf.waves import wavenumber
from rfcompass.types.reads import ReadTrace


@dataclass(frozen=True, kw_only=True)
class AngularProfile:
    """How to compute multipath profiles.

    Attributes:
        angles: Number A of angles, evenly from 0 to π.
        window: Taper along the (sub-)aperture.
        sub_apertures: Number of equally long parts of each straight leg of the path, one profile each.
        quantity: Power B(θ) or amplitude √B(θ).
        phase_only: Give every cell the same amplitude.
        scale: Divide each profile by its mean over angles, by its peak, or not at all.
    """

    angles: int = 181
    window: Literal["none", "hann"] = "none"
    sub_apertures: int = 1
    quantity: Literal["power", "amplitude"] = "power"
    phase_only: bool = False
    scale: Literal["mean", "peak", "none"] = "mean"

    def angles_rad(self) -> FloatArray:
        """Angles θ to the path direction [rad], shape (A,)."""
        return np.linspace(0.0, np.pi, self.angles)

    def of(self, trace: ReadTrace) -> FloatArray:
        """Profiles of one tag.

        Returns:
            One row for each run, straight leg and sub-aperture, shape (S, A); NaN where a sub-aperture holds fewer
            than two reads.

        Raises:
            UnsuitablePath: If a run of the antenna is neither a straight line nor made of straight legs.
            InputError: If a parameter is none of those listed above, or there is no angle or no sub-aperture.
        """
        self._check()
        parts = [part for whole in straight_apertures(trace) for part in whole.split(self.sub_apertures)]
        return np.array([self._profile(part) for part in parts])

    def _check(self) -> None:
        if self.angles < 2 or self.sub_apertures < 1:
            message = f"profile: {self.angles} angles, {self.sub_apertures} sub-apertures: need at least 2 and 1"
            raise InputError(message, angles=self.angles, sub_apertures=self.sub_apertures)
        known = {"window": ("none", "hann"), "quantity": ("power", "amplitude"), "scale": ("mean", "peak", "none")}
        for name, values in known.items():
            if getattr(self, name) not in values:
                message = f"profile: {name} {getattr(self, name)!r} is unknown (known: {', '.join(values)})"
                raise InputError(message, name=name, known=values)

    def _profile(self, aperture: Aperture) -> FloatArray:
        if np.count_nonzero(aperture.channel) < 2:
            return np.full(self.angles, np.nan)
        h = aperture.channel * self._taper(aperture.offsets_m)[:, None]
        if self.phase_only:
            h = h / np.where(aperture.channel != 0, np.abs(aperture.channel), 1.0)
        path_m = aperture.legs * np.outer(np.cos(self.angles_rad()), aperture.offsets_m)
        power = np.zeros(self.angles)
        for f, k in enumerate(wavenumber(aperture.frequencies_hz)):
            power += np.abs(np.exp(-1j * k * path_m) @ h[:, f]) ** 2
        return self._scaled(np.sqrt(power) if self.quantity == "amplitude" else power)

    def _taper(self, offsets_m: FloatArray) -> FloatArray:
        if self.window == "none":
            return np.ones_like(offsets_m)
        centre, length = (offsets_m.max() + offsets_m.min()) / 2, np.ptp(offsets_m)
        return np.asarray(np.cos(np.pi * (offsets_m - centre) / (length * (1 + 1 / offsets_m.size))) ** 2)

    def _scaled(self, profile: FloatArray) -> FloatArray:
        if self.scale == "none":
            return profile
        return np.asarray(profile / (profile.mean() if self.scale == "mean" else profile.max()))
