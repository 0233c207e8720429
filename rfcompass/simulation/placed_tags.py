"""Tags where they truly are, with the constants that differ from one tag to the next. This is truth."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from rfcompass.arrays import FloatArray, read_only
from rfcompass.errors import InputError, ShapeError
from rfcompass.types.record import Record
from rfcompass.types.tags import check_distinct

PORTS = {"dipole": 1, "dual_dipole": 2}


@dataclass(frozen=True, slots=True, kw_only=True)
class TagModel(Record):
    """One tag type.

    A tag with two ports has crossed dipoles. The chip takes the sum of their powers, and answers through both: the
    echo is h₁² + e^{jφ} h₂², φ the `port_phase_rad`. With φ = 0 a circular antenna that hears its own hand cancels it.

    Attributes:
        gain_dbi: Gain across the dipole [dB].
        sensitivity_dbm: Power that the chip needs to answer [dBm].
        backscatter_loss_db: What modulation takes from the echo [dB].
        ports: `"dipole"` or `"dual_dipole"`.
        port_phase_rad: Phase of the second port's echo against the first [rad].
        gain_spread_db: Standard deviation of the gain between tags of this type [dB].
    """

    gain_dbi: float = 1.07  # 1.28, as the whip: conservative; ours
    sensitivity_dbm: float = -18.0  # Higgs-3, as its data sheet is quoted
    backscatter_loss_db: float = 6.0  # 4 to 8 dB are usual; ours
    ports: str = "dipole"
    port_phase_rad: float = 0.0
    gain_spread_db: float = 1.0  # ours

    def __post_init__(self) -> None:
        """Check names and numbers."""
        if self.ports not in PORTS:
            raise InputError(f"TagModel.ports: {self.ports!r} is none of {', '.join(PORTS)}", got=self.ports)
        for key in ("gain_dbi", "sensitivity_dbm", "backscatter_loss_db", "port_phase_rad", "gain_spread_db"):
            if not np.isfinite(value := getattr(self, key)):
                raise InputError(f"TagModel.{key}: {value} is not finite", key=key, got=value)
        if self.gain_spread_db < 0:
            raise InputError(f"TagModel.gain_spread_db: {self.gain_spread_db} is below 0", key="gain_spread_db")


# The paper's Alien Squiggle, of the Higgs-2 or Higgs-3 era; the poorer of the two figures would be -11 dBm.
SQUIGGLE = TagModel()
# Small tag with two ports, insensitive to its turn: the same chip; a mutual phase of a quarter turn is ours.
DUAL_DIPOLE = TagModel(gain_dbi=0.0, ports="dual_dipole", port_phase_rad=float(np.pi / 2))


@dataclass(frozen=True, slots=True)
class PlacedTags(Record):
    """Tags of one type, where they are.

    Attributes:
        epcs: EPC of each tag (T).
        points_m: Places in the scene [m], shape (T, 3).
        dipoles: Electrical axis of each tag in the scene, unit vectors, shape (T, 3).
        model: Type of all of them.
        phase_rad: Constant that each tag adds to the phase of its echo [rad], shape (T,).
        gain_db: How much better its antenna is than the model's; counts on the way in and out [dB], shape (T,).
        crossed: Axis of the second dipole, across the first, shape (T, 3); horizontal if left out.
    """

    epcs: tuple[str, ...]
    points_m: FloatArray
    dipoles: FloatArray
    model: TagModel
    phase_rad: FloatArray
    gain_db: FloatArray
    crossed: FloatArray | None = None

    def __post_init__(self) -> None:
        """Freeze, bring the axes to unit length and check that everything belongs together."""
        T, set_ = len(self.epcs), object.__setattr__
        set_(self, "epcs", check_distinct(self.epcs, "PlacedTags"))
        set_(self, "points_m", read_only(self.points_m, "PlacedTags.points_m", (T, 3)))
        set_(self, "dipoles", _unit(read_only(self.dipoles, "PlacedTags.dipoles", (T, 3)), "dipoles"))
        set_(self, "phase_rad", read_only(self.phase_rad, "PlacedTags.phase_rad", (T,)))
        set_(self, "gain_db", read_only(self.gain_db, "PlacedTags.gain_db", (T,)))
        crossed = _across(self.dipoles) if self.crossed is None else self.crossed
        set_(self, "crossed", _unit(read_only(crossed, "PlacedTags.crossed", (T, 3)), "crossed"))
        if T and np.abs(np.einsum("ti,ti->t", self.dipoles, np.asarray(self.crossed))).max() > 1e-6:
            raise ShapeError("PlacedTags.crossed: a second dipole is not across the first", name="crossed")

    def __len__(self) -> int:
        return len(self.epcs)

    @classmethod
    def draw(
        cls,
        epcs: Sequence[str],
        points_m: FloatArray,
        dipoles: FloatArray,
        model: TagModel,
        rng: np.random.Generator,
    ) -> "PlacedTags":
        """Draw each tag's own phase (uniform) and gain (normal, `gain_spread_db`).

        Args:
            epcs: EPC of each tag (T).
            points_m: Places in the scene [m], shape (T, 3).
            dipoles: Electrical axes in the scene, shape (T, 3).
            model: Type of all of them.
            rng: Source of the constants.
        """
        T = len(epcs)
        phase_rad, gain_db = rng.uniform(0.0, 2.0 * np.pi, T), rng.normal(0.0, model.gain_spread_db, T)
        return cls(tuple(epcs), points_m, dipoles, model, phase_rad, gain_db)

    def moved(self, points_m: FloatArray, dipoles: FloatArray, crossed: FloatArray | None = None) -> "PlacedTags":
        """Return the same tags, with their own constants, at another place."""
        return replace(self, points_m=points_m, dipoles=dipoles, crossed=crossed)

    def axes(self) -> FloatArray:
        """Axis of the dipole at each port, shape (T, P, 3)."""
        axes = [self.dipoles, np.asarray(self.crossed)]
        return np.stack(axes[: PORTS[self.model.ports]], axis=1)


def _unit(vectors: FloatArray, name: str) -> FloatArray:
    lengths = np.linalg.norm(vectors, axis=1, keepdims=True)
    if (lengths == 0).any():
        raise ShapeError(f"PlacedTags.{name}: a direction has length zero", name=name)
    near = np.abs(lengths - 1.0) < 1e-12  # a unit vector survives copying to the last bit
    return read_only(np.where(near, vectors, vectors / lengths), f"PlacedTags.{name}", vectors.shape)


def _across(dipoles: FloatArray) -> FloatArray:
    """A horizontal direction across each dipole: z x u, or y for an upright one."""
    across = np.cross([0.0, 0.0, 1.0], dipoles).reshape(-1, 3)
    upright = np.linalg.norm(across, axis=1) < 1e-9
    across[upright] = [0.0, 1.0, 0.0]
    upright_dipoles = dipoles[upright]
    across[upright] -= np.einsum("ti,ti->t", across[upright], upright_dipoles)[:, None] * upright_dipoles
    return across
