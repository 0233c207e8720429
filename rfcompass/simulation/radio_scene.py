"""A scene as waves meet it: what everybody may know about it, and the small things that nobody can. This is truth."""

from dataclasses import dataclass, field, replace

import numpy as np

from rfcompass.arrays import FloatArray, read_only
from rfcompass.errors import SceneError, ShapeError
from rfcompass.types.record import Record
from rfcompass.types.scene import Scene

# Share of a scatterer's field that comes back with its polarisation turned about a random axis; ours.
DEPOLARISATION = 0.3


@dataclass(frozen=True, slots=True)
class Scatterers(Record):
    """Things too small for walls, each of which sends what reaches it on to everywhere.

    The field e that meets one leaves as the dipole moment B e,

        B = sqrt(σ / 4π) e^{jψ} [(1 - κ) I + κ (2 a aᵀ - I)]:

    along e, and a share κ of it turned by π about an axis a. B is symmetric, so that forth and back are the same.

    Attributes:
        points_m: Places in the scene [m], shape (S, 3).
        cross_section_m2: Radar cross section σ [m²], shape (S,).
        phase_rad: Phase ψ of the reflection [rad], shape (S,).
        axes: Unit vectors a, shape (S, 3); z if left out.
        depolarisation: κ, between 0 and 1, shape (S,); 0 if left out.
    """

    points_m: FloatArray
    cross_section_m2: FloatArray
    phase_rad: FloatArray
    axes: FloatArray | None = None
    depolarisation: FloatArray | None = None

    def __post_init__(self) -> None:
        """Freeze the arrays and check that they belong together."""
        S, set_ = len(self.points_m), object.__setattr__
        axes = np.tile([0.0, 0.0, 1.0], (S, 1)) if self.axes is None else self.axes
        kappa = np.zeros(S) if self.depolarisation is None else self.depolarisation
        set_(self, "points_m", read_only(self.points_m, "Scatterers.points_m", (S, 3)))
        set_(self, "cross_section_m2", read_only(self.cross_section_m2, "Scatterers.cross_section_m2", (S,)))
        set_(self, "phase_rad", read_only(self.phase_rad, "Scatterers.phase_rad", (S,)))
        set_(self, "axes", read_only(axes, "Scatterers.axes", (S, 3)))
        set_(self, "depolarisation", read_only(kappa, "Scatterers.depolarisation", (S,)))
        if (self.cross_section_m2 < 0).any():
            raise ShapeError("Scatterers.cross_section_m2: a cross section is below 0", name="cross_section_m2")
        shares = np.asarray(self.depolarisation)
        if (shares < 0).any() or (shares > 1).any():
            raise ShapeError("Scatterers.depolarisation: a share is not in [0, 1]", name="depolarisation")
        if S and np.abs(np.linalg.norm(np.asarray(self.axes), axis=1) - 1).max() > 1e-9:
            raise ShapeError("Scatterers.axes: an axis is no unit vector", name="axes")

    def __len__(self) -> int:
        return len(self.points_m)

    @classmethod
    def none(cls) -> "Scatterers":
        """No scatterer at all."""
        return cls(np.empty((0, 3)), np.empty(0), np.empty(0))

    @classmethod
    def draw(
        cls, points_m: FloatArray, cross_section_m2: tuple[float, float], rng: np.random.Generator
    ) -> "Scatterers":
        """Draw cross sections (log-uniform), phases (uniform) and axes (uniform on the sphere) for given places.

        Args:
            points_m: Places in the scene [m], shape (S, 3).
            cross_section_m2: Smallest and largest σ [m²].
            rng: Source of everything.
        """
        S = len(points_m)
        low, high = np.log(cross_section_m2)
        sigma = np.exp(rng.uniform(low, high, S))
        axes = rng.normal(size=(S, 3))
        axes /= np.linalg.norm(axes, axis=1, keepdims=True)
        return cls(points_m, sigma, rng.uniform(0.0, 2.0 * np.pi, S), axes, np.full(S, DEPOLARISATION))

    def matrices(self) -> FloatArray:
        """Turn of the field, B without its size and phase, shape (S, 3, 3)."""
        a, kappa = np.asarray(self.axes), np.asarray(self.depolarisation)[:, None, None]
        return np.asarray((1.0 - 2.0 * kappa) * np.eye(3) + 2.0 * kappa * a[:, :, None] * a[:, None, :])

    def joined(self, extra: "Scatterers") -> "Scatterers":
        """Both together."""
        points_m, sigma, phase_rad, axes, kappa = (
            np.concatenate([getattr(self, name), getattr(extra, name)])
            for name in ("points_m", "cross_section_m2", "phase_rad", "axes", "depolarisation")
        )
        return Scatterers(points_m, sigma, phase_rad, axes, kappa)


@dataclass(frozen=True, slots=True)
class RadioScene(Record):
    """Everything that a wave meets. This record is truth.

    Attributes:
        scene: Room and obstacles.
        scatterers: Small things.
        order: Largest number of reflections at walls, floor and ceiling that is followed.
    """

    scene: Scene
    scatterers: Scatterers = field(default_factory=Scatterers.none)
    order: int = 2

    def __post_init__(self) -> None:
        """Check the order."""
        if self.order not in range(6):
            raise SceneError(f"RadioScene.order: {self.order} is not one of 0 to 5", key="order", got=self.order)

    def with_scatterers(self, extra: Scatterers) -> "RadioScene":
        """Return the scene with more scatterers, such as the metal body of the robot at this stop."""
        return replace(self, scatterers=self.scatterers.joined(extra))
