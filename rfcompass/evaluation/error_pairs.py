"""Errors of an estimate, position and orientation kept together, to draw grasp attempts from [Wang2013], section 6.3.

A *draw* is the estimated pose of a part in the frame of the true one: where the hand believes the part to be. Three
things can be drawn from: stored errors, a family of distributions that fits printed medians, and a user's CSV.
"""

from dataclasses import dataclass
from pathlib import Path
from typing import Protocol, runtime_checkable

import numpy as np
from scipy.optimize import brentq
from scipy.special import gamma, ndtri

from rfcompass.arrays import FloatArray, read_only
from rfcompass.errors import ImportFormatError, InputError, ShapeError
from rfcompass.recordings.text_table import TextTable, read_text_table
from rfcompass.types.record import Record

RAYLEIGH_SHAPE = 2.0
# More than a whole turn is not an error in radians.
_WHOLE_TURN_RAD = 2.0 * np.pi
_VECTOR, _SIZE = ("x_error_m", "y_error_m"), "position_error_m"
_TURN = "theta_error_rad"


@dataclass(frozen=True, slots=True)
class Draws(Record):
    """Estimated poses of a part in the frame of the true one.

    Attributes:
        offset_m: Estimated centre [m], x along the part, shape (S, 2).
        theta_rad: Estimated orientation [rad], shape (S,).
    """

    offset_m: FloatArray
    theta_rad: FloatArray

    def __post_init__(self) -> None:
        """Freeze the arrays and check that they fit."""
        object.__setattr__(self, "offset_m", read_only(self.offset_m, "Draws.offset_m", (None, 2)))
        object.__setattr__(self, "theta_rad", read_only(self.theta_rad, "Draws.theta_rad", (len(self.offset_m),)))

    @property
    def distance_m(self) -> FloatArray:
        """Size of the position error [m], shape (S,)."""
        return np.asarray(np.hypot(*self.offset_m.T))

    def __len__(self) -> int:
        """Number of draws."""
        return len(self.theta_rad)


@runtime_checkable
class ErrorSource(Protocol):
    """What draws come from."""

    def draw(self, count: int, rng: np.random.Generator) -> Draws:
        """Draw independent errors; the first draws do not depend on how many follow."""
        ...

    def distance_quantile_m(self, share: float) -> float:
        """Position error that this share of the draws does not exceed [m]."""
        ...


@dataclass(frozen=True, slots=True, kw_only=True)
class ErrorPairs(Record):
    """Position and orientation errors of one trial each.

    Attributes:
        distance_m: Distance of the estimated centre from the true one [m], shape (P,).
        theta_rad: Orientation error [rad], shape (P,): with its sign if `heading_rad` is known, else its size.
        heading_rad: Direction of the offset in the frame of the true part [rad], shape (P,). None where only the size
            was kept: a draw then takes any direction and either sign of the turn, all equally likely.
        spread_m: What the estimator itself said of its position error, √ trace of its covariance [m], shape (P,), or
            None.
        incomplete: Trials that are left out, because they gave no place or no orientation.
    """

    distance_m: FloatArray
    theta_rad: FloatArray
    heading_rad: FloatArray | None = None
    spread_m: FloatArray | None = None
    incomplete: int = 0

    def __post_init__(self) -> None:
        """Freeze the arrays; sizes cannot be negative."""
        object.__setattr__(self, "distance_m", read_only(self.distance_m, "ErrorPairs.distance_m", (None,)))
        shape = self.distance_m.shape
        for name in ("theta_rad", "heading_rad", "spread_m"):
            if getattr(self, name) is not None:
                object.__setattr__(self, name, read_only(getattr(self, name), f"ErrorPairs.{name}", shape))
        if not len(self.distance_m):
            raise ShapeError("ErrorPairs: not a single pair", name="distance_m")
        sizes = ("distance_m",) if self.heading_rad is not None else ("distance_m", "theta_rad")
        for name in sizes:
            if (getattr(self, name) < 0.0).any():
                raise ShapeError(f"ErrorPairs.{name}: a size cannot be negative", name=name)

    def __len__(self) -> int:
        """Number of pairs."""
        return len(self.distance_m)

    @property
    def complete_share(self) -> float:
        """Share of the trials that gave a pair."""
        return len(self) / (len(self) + self.incomplete)

    def draw(self, count: int, rng: np.random.Generator) -> Draws:
        """Draw pairs with replacement, each as likely as any other [Wang2013], section 6.3."""
        u = rng.random((count, 4))
        row = np.minimum((u[:, 0] * len(self)).astype(np.int64), len(self) - 1)
        return self.turned(row, u[:, 1], u[:, 2] < 0.5)

    def turned(self, row: np.ndarray, turn: FloatArray, flip: np.ndarray) -> Draws:
        """Draws of given rows; where no direction is known, with this one.

        Args:
            row: Which pair, shape (S,).
            turn: Direction as a share of a whole turn, shape (S,).
            flip: Whether the orientation error is negative, shape (S,).
        """
        if self.heading_rad is not None:
            return _draws(self.distance_m[row], self.heading_rad[row], self.theta_rad[row])
        theta_rad = np.where(flip, -self.theta_rad[row], self.theta_rad[row])
        return _draws(self.distance_m[row], _WHOLE_TURN_RAD * turn, theta_rad)

    def distance_quantile_m(self, share: float) -> float:
        """Smallest position error that this share of the pairs does not exceed [m]."""
        return float(np.quantile(self.distance_m, share, method="inverted_cdf"))

    def surest(self, share: float = 0.5) -> "ErrorPairs":
        """The pairs of which the estimator itself was surest: what is left if it measures again until it is so sure.

        Raises:
            InputError: If the estimator's own spread was not kept.
        """
        if self.spread_m is None:
            raise InputError("how sure the estimator was is not known of these pairs", name="spread_m")
        kept = self.spread_m <= np.quantile(self.spread_m, share)
        heading_rad = None if self.heading_rad is None else self.heading_rad[kept]
        return ErrorPairs(
            distance_m=self.distance_m[kept], theta_rad=self.theta_rad[kept], heading_rad=heading_rad,
            spread_m=self.spread_m[kept], incomplete=self.incomplete,
        )  # fmt: skip


@dataclass(frozen=True, slots=True, kw_only=True)
class ErrorFamily(Record):
    """Errors with given medians: a Weibull distance of any direction, and a half-normal turn that knows nothing of it.

        P(distance <= d) = 1 - exp(-ln 2 (d / median)^shape)

    Attributes:
        median_m: Median of the distance [m].
        theta_median_rad: Median size of the turn [rad].
        shape: 2 is a Rayleigh distribution; a larger one is narrower.
    """

    median_m: float
    theta_median_rad: float
    shape: float = RAYLEIGH_SHAPE

    def __post_init__(self) -> None:
        """Check the parameters."""
        for name in ("median_m", "theta_median_rad", "shape"):
            if not (np.isfinite(getattr(self, name)) and getattr(self, name) > 0.0):
                raise InputError(f"ErrorFamily.{name}: {getattr(self, name)} is not above 0", name=name)

    def draw(self, count: int, rng: np.random.Generator) -> Draws:
        """Draw independent errors, by inverting the distributions."""
        u = rng.random((count, 4))
        distance_m = self.median_m * (-np.log1p(-u[:, 0]) / np.log(2.0)) ** (1.0 / self.shape)
        size_rad = self.theta_median_rad * ndtri(0.5 + u[:, 3] / 2.0) / ndtri(0.75)
        return _draws(distance_m, _WHOLE_TURN_RAD * u[:, 1], np.where(u[:, 2] < 0.5, -size_rad, size_rad))

    def distance_quantile_m(self, share: float) -> float:
        """Distance that is not exceeded with this probability [m]."""
        return float(self.median_m * (-np.log1p(-share) / np.log(2.0)) ** (1.0 / self.shape))


def weibull_shape(sd_over_median: float) -> float:
    """Shape of the Weibull distribution with this ratio of standard deviation to median; a Rayleigh's is 0.556.

        sd / median = √(Γ(1 + 2/k) - Γ(1 + 1/k)²) / (ln 2)^(1/k)

    Raises:
        InputError: If the ratio is not between 0.02 and 5.
    """
    if not 0.02 <= sd_over_median <= 5.0:
        raise InputError(f"standard deviation over median of {sd_over_median}: 0.02 to 5", got=sd_over_median)
    return float(brentq(lambda k: _sd_over_median(k) - sd_over_median, 0.3, 100.0, xtol=1e-12))


def read_error_csv(path: Path | str) -> ErrorPairs:
    """Read errors from a CSV file with a header and one row for each trial; other columns are left alone.

    Columns: `theta_error_rad`, and either `position_error_m` (its size: then only the size of the turn counts, and
    direction and sign are drawn) or `x_error_m` and `y_error_m` (estimated less true centre in the frame of the true
    part, x along it: then both keep their signs). `spread_m`, the estimator's own √ trace, may be there.

    Raises:
        ImportFormatError: If a column is missing, or a cell is no finite number, or one that cannot be; names file,
            column and row (from 0, without the header).
    """
    table = read_text_table(Path(path), ImportFormatError)
    if table.rows == 0:
        raise ImportFormatError(f"{table.file}: has a header but no row", file=table.file)
    theta_rad = table.floats(_TURN)
    _refuse(table, _TURN, np.abs(theta_rad) > _WHOLE_TURN_RAD, "is more than a whole turn; degrees?")
    spread_m = _sizes(table, "spread_m") if "spread_m" in table.columns else None
    if any(name in table.columns for name in _VECTOR):
        if _SIZE in table.columns:
            message = f"{table.file}: {_SIZE} beside {' and '.join(_VECTOR)}: which one counts?"
            raise ImportFormatError(message, file=table.file, column=_SIZE)
        x_m, y_m = (table.floats(name) for name in _VECTOR)
        return ErrorPairs(
            distance_m=np.hypot(x_m, y_m), theta_rad=theta_rad, heading_rad=np.arctan2(y_m, x_m), spread_m=spread_m
        )
    return ErrorPairs(distance_m=_sizes(table, _SIZE), theta_rad=np.abs(theta_rad), spread_m=spread_m)


def _sizes(table: TextTable, column: str) -> FloatArray:
    values = table.floats(column)
    _refuse(table, column, values < 0.0, "is negative")
    return values


def _refuse(table: TextTable, column: str, bad: np.ndarray, why: str) -> None:
    if bad.any():
        row = int(np.argmax(bad))
        message = f"{table.file}, column {column}, row {row}: {table.columns[column][row]} {why}"
        raise ImportFormatError(message, file=table.file, column=column, row=row)


def _draws(distance_m: FloatArray, heading_rad: FloatArray, theta_rad: FloatArray) -> Draws:
    offset_m = distance_m[:, None] * np.column_stack([np.cos(heading_rad), np.sin(heading_rad)])
    return Draws(offset_m, theta_rad)


def _sd_over_median(k: float) -> float:
    variance = gamma(1.0 + 2.0 / k) - gamma(1.0 + 1.0 / k) ** 2
    return float(np.sqrt(variance) / np.log(2.0) ** (1.0 / k))
