"""The kernel of one tagged item: where its tag says that the target is not [Boroushaki2023], sections 4.3 and 4.5.3.

With q = p - p_RFID, all kernels have the form

    m(p) = peak · exp(-Σ_a w_a q_a²) within ‖q‖ ≤ reach, else 0.

A rigid item may lie any way round its tag: w is the same along all axes. A deformable one, pressed from above to a
share α of its height, is flat: σ_x = σ_y = (2 - α) d_s/2 and σ_z = α d_s/2.
"""

from dataclasses import dataclass, replace

import numba
import numpy as np

from rfcompass.arrays import FloatArray, IntArray, read_only
from rfcompass.errors import InputError
from rfcompass.mapping.readings import reading_called
from rfcompass.types.piles import VoxelGrid
from rfcompass.types.record import Record
from rfcompass.types.shapes import positive
from rfcompass.types.workspace import Workspace


@dataclass(frozen=True, slots=True)
class TagKernel(Record):
    """What is added to the map about one tag.

    Attributes:
        peak: Value at the tag.
        weights: w along x, y and z [1/m²], shape (3,); negative for a kernel that grows outwards.
        reach_m: Radius of the ball outside which it is zero [m].
    """

    peak: float
    weights: FloatArray
    reach_m: float

    def __post_init__(self) -> None:
        """Freeze the weights."""
        object.__setattr__(self, "weights", read_only(self.weights, "TagKernel.weights", (3,)))

    @property
    def sigmas_m(self) -> FloatArray:
        """Standard deviation along x, y and z [m], shape (3,); NaN for a kernel that grows."""
        with np.errstate(invalid="ignore"):
            return np.sqrt(0.5 / self.weights)

    def sampled(self, half_m: float, spacing_m: float) -> VoxelGrid:
        """Sample the kernel on a cube about the tag at the origin, for a picture.

        Args:
            half_m: Half the edge of the cube [m].
            spacing_m: Edge of a voxel [m].
        """
        n = int(half_m / spacing_m + 1e-9)
        cube = Workspace(np.full(3, -(n + 0.5) * spacing_m), (2 * n + 1,) * 3, spacing_m)
        values = np.zeros(cube.shape)
        add_kernel(values, self, np.zeros(3), cube)
        return cube.grid(values)


def rigid_kernel(
    shortest_m: float, longest_m: float, *, reading: str = "consistent", amplitude: float = 1.0
) -> TagKernel:
    """Kernel m of an item that keeps its shape.

    Args:
        shortest_m: d_s [m].
        longest_m: d_l [m].
        reading: See `rfcompass.mapping.readings`.
        amplitude: How much the tag itself takes away, in (0, 1]; only for the reading `consistent`. Ours.

    Raises:
        InputError: If a length or the amplitude is out of range, or the reading unknown.
    """
    same = deformable_kernel(shortest_m, longest_m, 1.0, reading=reading, amplitude=amplitude)
    if (unit_m := reading_called(reading).unit_m) is None:
        return same
    d_s = positive(shortest_m, "shortest_m")
    # Printed, m and m_d have the same exponent at α = 1, but not the same factor before it.
    return replace(same, peak=float(np.copysign(1.0 / np.sqrt(np.pi * d_s / unit_m), same.peak)))


def deformable_kernel(
    shortest_m: float, longest_m: float, alpha: float, *, reading: str = "consistent", amplitude: float = 1.0
) -> TagKernel:
    """Kernel m_d of an item that is pressed to a share `alpha` of its height.

    With α = 1 it is the kernel of a rigid item, exactly so in the reading `consistent`. The printed normalisers
    differ: literally m_d is then 2 / d_s times m, a factor of 20 for 10 cm in metres and of 0.2 in centimetres.

    Args:
        shortest_m: d_s [m].
        longest_m: d_l [m].
        alpha: α, in (0, 1].
        reading: See `rfcompass.mapping.readings`.
        amplitude: As for `rigid_kernel`.

    Raises:
        InputError: If a length, α or the amplitude is out of range, or the reading unknown.
    """
    d_s, d_l = positive(shortest_m, "shortest_m"), positive(longest_m, "longest_m")
    for name, share in (("alpha", alpha), ("amplitude", amplitude)):
        if not 0.0 < share <= 1.0:
            raise InputError(f"{name} is {share}, not in (0, 1]", name=name, got=share)
    sigmas_m = np.array([2.0 - alpha, 2.0 - alpha, alpha]) * (d_s / 2)
    unit_m = reading_called(reading).unit_m
    if unit_m is None:
        return TagKernel(-amplitude, 0.5 / sigmas_m**2, d_l)
    peak = 1.0 / np.sqrt(2.0 * np.pi * np.prod(sigmas_m / unit_m))
    return _signed(float(peak), 0.5 / (unit_m * sigmas_m), d_l, reading)


def _signed(peak: float, weights: FloatArray, longest_m: float, reading: str) -> TagKernel:
    """Put signs and mask as the reading has them; the peak is what R gets."""
    unit_m, printed = reading_called(reading)
    if printed and unit_m is not None:
        return TagKernel(float(peak), -weights, float(np.sqrt(longest_m * unit_m)))
    return TagKernel(-float(peak), weights, longest_m)


def add_kernel(values: FloatArray, kernel: TagKernel, point_m: FloatArray, workspace: Workspace) -> None:
    """Add a kernel about a point to the values of a workspace's voxels.

    Args:
        values: Changed in place, shape (X, Y, Z).
        kernel: What to add.
        point_m: Its middle, in the world frame [m], shape (3,); may lie outside.
        workspace: Where the voxels are.
    """
    h = workspace.spacing_m
    place = (point_m - workspace.origin_m) / h
    reach = kernel.reach_m / h
    low = np.clip(np.ceil(place - reach - 1e-9), 0, workspace.shape).astype(np.int64)
    high = np.clip(np.floor(place + reach + 1e-9) + 1, 0, workspace.shape).astype(np.int64)
    if (high > low).all():
        _add_ball(values, np.stack([low, high], axis=1), place, kernel.weights * h**2, reach**2, kernel.peak)


@numba.njit(cache=True)
def _add_ball(
    values: FloatArray, window: IntArray, place: FloatArray, weights: FloatArray, reach2: float, peak: float
) -> None:
    """Add peak · Π exp(-w q²) where Σ q² ≤ reach2; lengths in voxels, so that axes can be tabulated."""
    z = np.arange(window[2, 0], window[2, 1]) - place[2]
    z2 = z**2
    along_z = np.exp(-weights[2] * z2)
    for i in range(window[0, 0], window[0, 1]):
        x2 = (i - place[0]) ** 2
        along_x = peak * np.exp(-weights[0] * x2)
        for j in range(window[1, 0], window[1, 1]):
            y2 = (j - place[1]) ** 2
            left = reach2 * (1.0 + 1e-12) - x2 - y2
            if left < 0.0:
                continue
            along_xy = along_x * np.exp(-weights[1] * y2)
            for k in range(z2.size):
                if z2[k] <= left:
                    values[i, j, window[2, 0] + k] += along_xy * along_z[k]
