"""A depth camera over a pile: what it hands out is noisy, and its pose is what the arm believes."""

from dataclasses import dataclass

import numpy as np

from rfcompass.arrays import BoolArray, FloatArray, IntArray
from rfcompass.errors import PileError
from rfcompass.simulation.piles.rays import D415, CameraModel, TrueImage, cast_image
from rfcompass.simulation.piles.world import PileWorld
from rfcompass.types.piles import DepthView, InstanceMasks
from rfcompass.types.record import Record

_TABLE_RGB, _NOTHING_RGB = (176, 158, 132), (20, 20, 24)
_AMBIENT = 0.35  # light that reaches a surface from anywhere, of all; the rest comes from the camera. Ours.


@dataclass(frozen=True, slots=True)
class DepthNoise(Record):
    """What a stereo depth camera gets wrong.

    The depth of a pixel scatters by σ = z² s / (f B), what an error s of the disparity d makes of z = f B / d [D400];
    0.7 mm at 0.7 m. It is white here; a real camera's is smooth over some pixels.

    Attributes:
        disparity_px: s, at the camera's full resolution; ours [pixel].
        focal_px: f at full resolution, 1280 columns over 65 degrees [pixel].
        baseline_m: B, of the D415 [m].
        least_m: Nearer than this it sees nothing [m].
        step_m: Depths are whole multiples of this [m]; 0 for none.
        edge_m: A step between neighbours that counts as an edge of an object [m]; ours.
        edge_lost: Share of the pixels beside an edge that are lost: one eye does not see them; ours.
        grazing: Cosine below which a surface is too slanted to be matched; ours.
        grazing_lost: Share of the pixels on such a surface that are lost; ours.
        lost: Share of all other pixels that are lost; ours.
    """

    disparity_px: float = 0.08
    focal_px: float = 1005.0
    baseline_m: float = 0.055
    least_m: float = 0.3
    step_m: float = 0.001
    edge_m: float = 0.015
    edge_lost: float = 0.5
    grazing: float = 0.17
    grazing_lost: float = 0.7
    lost: float = 0.002

    def __post_init__(self) -> None:
        """Check that nothing is negative, and shares are shares."""
        for name in self.__slots__:
            most = 1.0 if name in ("edge_lost", "grazing", "grazing_lost", "lost") else np.inf
            if not 0 <= (got := getattr(self, name)) <= most or not np.isfinite(got):
                raise PileError(f"depth noise: {name} is {got!r}, not in [0, {most:g}]", key=name, got=got)
        for name in ("focal_px", "baseline_m"):
            if not getattr(self, name) > 0:
                raise PileError(f"depth noise: {name} is 0", key=name, got=0.0)

    def sigma_m(self, depth_m: FloatArray) -> FloatArray:
        """Scatter at each depth [m], of the same shape."""
        return depth_m**2 * self.disparity_px / (self.focal_px * self.baseline_m)

    def spoil(self, image: TrueImage, rng: np.random.Generator) -> FloatArray:
        """Return the depth that the camera hands out, NaN where it sees nothing [m], shape (H, W)."""
        depth_m = image.depth_m + self.sigma_m(image.depth_m) * rng.normal(size=image.depth_m.shape)
        share = np.full(depth_m.shape, self.lost)
        share[image.facing < self.grazing] = self.grazing_lost
        share[beside_edges(image.depth_m, self.edge_m)] = self.edge_lost
        gone = (rng.random(depth_m.shape) < share) | ~(depth_m >= self.least_m)
        if self.step_m > 0:
            depth_m = np.round(depth_m / self.step_m) * self.step_m
        return np.where(gone, np.nan, depth_m)


NO_DEPTH_NOISE = DepthNoise(disparity_px=0.0, step_m=0.0, edge_lost=0.0, grazing_lost=0.0, lost=0.0)


@dataclass(frozen=True, slots=True)
class PoseNoise(Record):
    """How far the arm's belief is from where the camera is; all ours but the repeatability, the arm's 0.03 mm [UR5e].

    Attributes:
        hand_eye_m: Standard deviation of each axis of what the calibration got wrong, once for a camera [m].
        hand_eye_rad: The same of its rotation vector [rad].
        repeat_m: Standard deviation of each axis from view to view [m].
        repeat_rad: The same of the rotation vector [rad].
    """

    hand_eye_m: float = 0.001
    hand_eye_rad: float = 0.002
    repeat_m: float = 0.00003
    repeat_rad: float = 0.0001

    def __post_init__(self) -> None:
        """Check that nothing is negative."""
        for name in self.__slots__:
            if not (np.isfinite(got := getattr(self, name)) and got >= 0):
                raise PileError(f"pose noise: {name} is {got!r}, not a finite number >= 0", key=name, got=got)


NO_POSE_NOISE = PoseNoise(0.0, 0.0, 0.0, 0.0)


class PileCamera:
    """A depth camera on an arm's wrist; a `DepthSource`, and the only one that knows what its pixels show.

    Args:
        world: The pile; what happens to it is seen at the next view.
        rng: Source of all noise.
        camera: Pixels and field of view.
        depth_noise: Of depths.
        pose_noise: Of the pose.
    """

    def __init__(
        self,
        world: PileWorld,
        rng: np.random.Generator,
        camera: CameraModel = D415,
        depth_noise: DepthNoise | None = None,
        pose_noise: PoseNoise | None = None,
    ) -> None:
        """Draw what the calibration got wrong, and look down from 0.7 m over the middle of the table."""
        self._world, self._rng, self._camera = world, rng, camera
        self._depth_noise = DepthNoise() if depth_noise is None else depth_noise
        self._pose_noise = PoseNoise() if pose_noise is None else pose_noise
        self._T_hand_eye = _small_motion(self._pose_noise.hand_eye_m, self._pose_noise.hand_eye_rad, rng)
        self._T_believed = look_down(0.0, 0.0, 0.7)

    def move_to(self, T_world_camera: FloatArray) -> None:
        """Send the camera to a pose, as the arm believes, homogeneous, shape (4, 4)."""
        self._T_believed = np.array(T_world_camera, dtype=np.float64)

    def view(self) -> DepthView:
        """Take one image where the camera is now."""
        return self.view_and_masks()[0]

    def view_and_masks(self) -> tuple[DepthView, InstanceMasks]:
        """Take one image, and tell which item each of its pixels shows: 0 for the table, else its number.

        The masks are truth. A search may be handed them only where a study says that it uses true masks.
        """
        noise = self._pose_noise
        wobble = _small_motion(noise.repeat_m, noise.repeat_rad, self._rng)
        image = cast_image(self._world, self._camera, self._T_believed @ self._T_hand_eye @ wobble)
        depth_m = self._depth_noise.spoil(image, self._rng)
        view = DepthView(depth_m, self._camera.intrinsics, self._T_believed, _colours(self._world, image))
        return view, InstanceMasks(np.maximum(image.numbers, 0))


def look_down(x_m: float, y_m: float, z_m: float) -> FloatArray:
    """Pose of a camera that looks straight down, its rows along the world's x [m], shape (4, 4)."""
    T = np.diag([1.0, -1.0, -1.0, 1.0])
    T[:3, 3] = x_m, y_m, z_m
    return T


def scan_poses(centre_m: tuple[float, float] = (0.0, 0.0), half_m: float = 0.22, height_m: float = 0.70) -> FloatArray:
    """Poses on a square about a centre: its corners and the middles of its sides, in a round; ours, shape (8, 4, 4).

    Args:
        centre_m: Middle of the square, x and y in the world [m].
        half_m: Half its side [m].
        height_m: Height over the table [m].
    """
    round_trip = ((1, -1), (1, 0), (1, 1), (0, 1), (-1, 1), (-1, 0), (-1, -1), (0, -1))
    return np.array([look_down(centre_m[0] + half_m * a, centre_m[1] + half_m * b, height_m) for a, b in round_trip])


def beside_edges(depth_m: FloatArray, edge_m: float) -> BoolArray:
    """True for each pixel that has a neighbour, above, below, left or right, further off than `edge_m`; (H, W)."""
    found = np.zeros(depth_m.shape, dtype=bool)
    known = np.nan_to_num(depth_m, nan=1e3)
    for axis in (0, 1):
        jump = np.abs(np.diff(known, axis=axis)) > edge_m
        wide = [(0, 0), (0, 0)]
        for side in ((0, 1), (1, 0)):
            wide[axis] = side
            found |= np.pad(jump, wide)
    return found


def _colours(world: PileWorld, image: TrueImage) -> IntArray:
    """Colour of each pixel in the light of a lamp at the camera, shape (H, W, 3)."""
    numbers = [-1, 0, *(item.number for item in world.items)]
    colours = np.array([_NOTHING_RGB, _TABLE_RGB, *(item.rgb for item in world.items)])
    flat = colours[np.searchsorted(numbers, image.numbers)]
    light = _AMBIENT + (1 - _AMBIENT) * image.facing
    return np.round(flat * light[..., None]).astype(np.int64)


def _small_motion(sigma_m: float, sigma_rad: float, rng: np.random.Generator) -> FloatArray:
    """Draw a rigid motion near none, shape (4, 4)."""
    turn, shift = rng.normal(size=3) * sigma_rad, rng.normal(size=3) * sigma_m
    T = np.eye(4)
    T[:3, :3], T[:3, 3] = rotation_of(turn), shift
    return T


def rotation_of(vector_rad: FloatArray) -> FloatArray:
    """Rotation by a vector: about its direction, by its length [rad] (Rodrigues' formula), shape (3,) to (3, 3)."""
    angle = float(np.linalg.norm(vector_rad))
    if angle < 1e-12:
        return np.eye(3)
    x, y, z = vector_rad / angle
    K = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + np.sin(angle) * K + (1 - np.cos(angle)) * K @ K
