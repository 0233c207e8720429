"""A table with things on it that fall, rest, are taken away and pushed: the truth of the pile search.

World frame: z up, the table is the plane z = 0.
"""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from rfcompass.arrays import FloatArray, IntArray
from rfcompass.errors import PileError, PileUnsettled
from rfcompass.simulation.piles.engine import (
    ROOT,
    PilePhysics,
    compile_pile,
    joint_order,
    load_mujoco,
    panel_order,
    quiet_mujoco,
)
from rfcompass.simulation.piles.items import PileItem
from rfcompass.types.record import Record

# At rest: in a quarter of a second nothing moves further than this. Ours.
QUIET_S, QUIET_M = 0.25, 1e-4
# Quiet spells in a row that count as rest; and how much finer time passes when a simulation has blown up.
_SPELLS, _FINER = 2, 4
# Speed of a push [m/s], and how often its force is set anew [s].
_PUSH_M_S, _PUSH_STEP_S = 0.1, 0.02


@dataclass(frozen=True, slots=True)
class Settling(Record):
    """How a pile came to rest.

    Attributes:
        passed_s: How long it took [s].
        moved_m: How far something still moved in the last quarter of a second [m].
        at_rest: Whether it counts as at rest; a pile that is not goes on to creep.
    """

    passed_s: float
    moved_m: float
    at_rest: bool


class PileWorld:
    """Items on a table, and the physics between them.

    Not a record: it changes. `states` say all there is to know of a world at rest.

    Args:
        items: What there is, each with its own number.
        states: Place, quaternion (w, x, y, z) and hinges or slide of each, shape (7 + joints,) [m, -, rad or m], by
            number; see `engine.ROOT`.
        physics: Constants.

    Raises:
        PileError: If two items have one number, a state is missing, or has another shape, or is not finite.
        MissingExtra: If MuJoCo is not installed.
    """

    def __init__(
        self,
        items: Sequence[PileItem] = (),
        states: Mapping[int, FloatArray] | None = None,
        physics: PilePhysics | None = None,
    ) -> None:
        """Build the model and put everything in its place, at rest."""
        self.physics = PilePhysics() if physics is None else physics
        self._engine = load_mujoco()
        self._fill(tuple(items), {} if states is None else states, {})

    @property
    def items(self) -> tuple[PileItem, ...]:
        """What is on the table, in the order of numbers."""
        return self._items

    @property
    def states(self) -> dict[int, FloatArray]:
        """State of each item by number, shape (7 + joints,) each."""
        return self.states_in(self.data)

    def states_in(self, data: Any) -> dict[int, FloatArray]:  # noqa: ANN401 - an object of MuJoCo
        """State of each item by number in other data of the same items, perhaps with a hand after them."""
        return {item.number: self._gathered(item, data.qpos, ROOT) for item in self._items}

    def become(self, states: Mapping[int, FloatArray], without: Collection[int] = ()) -> None:
        """Put every item into a new state, at rest, and take some away.

        Raises:
            PileError: If a state is missing or has a wrong shape.
        """
        self._fill(tuple(item for item in self._items if item.number not in without), states, {})

    @property
    def geom_numbers(self) -> IntArray:
        """Number of the item that each geom of the model belongs to; 0 for the table, shape (G,)."""
        return self._geom_numbers

    def item(self, number: int) -> PileItem:
        """Return an item by its number.

        Raises:
            PileError: If it is not on the table.
        """
        for item in self._items:
            if item.number == number:
                return item
        there = [item.number for item in self._items]
        raise PileError(f"item {number} is not in the pile; there are {there}", key="number", got=number, there=there)

    def pose(self, number: int) -> FloatArray:
        """Pose of an item, of a cover's middle panel, of a cushion's lower half, in the world, homogeneous, (4, 4)."""
        return self._panel_pose(self._first_geom(number))

    def panel_poses(self, number: int) -> list[FloatArray]:
        """Poses of a cover's panels from -x to +x, a cushion's halves upwards, or an item in one piece, (4, 4) each."""
        first, order = self._first_geom(number), panel_order(self.item(number))
        return [self._panel_pose(first + order.index(panel)) for panel in sorted(order)]

    def corners_m(self, number: int) -> FloatArray:
        """Corners of the boxes about an item's panels, in the world [m], shape (8 P, 3)."""
        half_m = self.item(number).panel_size_m / 2
        signs = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)])
        return np.concatenate([(signs * half_m) @ T[:3, :3].T + T[:3, 3] for T in self.panel_poses(number)])

    def touching(self, number: int) -> set[int]:
        """Numbers of the items in contact with an item."""
        self.item(number)
        pairs = self._geom_numbers[self.data.contact.geom.reshape(-1, 2)]
        near = {int(n) for pair in pairs if number in pair for n in pair}
        return near - {0, number}

    def add(self, item: PileItem, state: FloatArray) -> None:
        """Put one more item somewhere, at rest; all else keeps its speed.

        Raises:
            PileError: If its number is taken, or its state has a wrong shape.
        """
        speeds = self._speeds()
        self._fill((*self._items, item), {**self.states, item.number: state}, speeds)

    def remove(self, number: int) -> PileItem:
        """Take an item away at once, as if lifted straight out; what leaned on it falls with `settle`.

        Raises:
            PileError: If it is not on the table.
        """
        taken, speeds = self.item(number), self._speeds()
        self._fill(tuple(item for item in self._items if item.number != number), self.states, speeds)
        return taken

    def step(self, duration_s: float, forces_n: Mapping[int, FloatArray] | None = None) -> None:
        """Let time pass; once more in finer steps if the simulation blows up.

        Args:
            duration_s: How long [s].
            forces_n: Constant force on the centre of each body of an item, in the world, by number, shape (3,).

        Raises:
            PileUnsettled: If the simulation blew up twice.
        """
        self._push_with({} if forces_n is None else forces_n)
        states, speeds, damping = self.states, self._speeds(), self.model.dof_damping.copy()
        for finer in (1, _FINER):
            if self._steps(duration_s, self.physics.timestep_s / finer):
                return
            self._fill(self._items, states, speeds)
            self.model.dof_damping[:] = damping
            self._push_with({} if forces_n is None else forces_n)
        message = f"the simulation of {len(self._items)} items blew up"
        raise PileUnsettled(message, simulated_s=duration_s, creep_m=float("inf"))

    def _push_with(self, forces_n: Mapping[int, FloatArray]) -> None:
        self.data.xfrc_applied[:] = 0.0
        for number, force_n in forces_n.items():
            first = self._first_geom(number)  # geom g belongs to body g: both count the table as 0
            self.data.xfrc_applied[first : first + len(panel_order(self.item(number))), :3] = force_n

    def _steps(self, duration_s: float, timestep_s: float) -> bool:
        """Let time pass; tell whether the simulation stayed sane."""
        self.model.opt.timestep = timestep_s
        began_s = self.data.time
        with quiet_mujoco():
            for _ in range(round(duration_s / timestep_s)):
                self._engine.mj_step(self.model, self.data)
                if self.data.time < began_s:  # MuJoCo has begun anew, with everything in one place
                    break
        self._engine.mj_forward(self.model, self.data)
        self.model.opt.timestep = self.physics.timestep_s
        warned = sum(int(self.data.warning[kind].number) for kind in range(len(self.data.warning)))
        return not warned and bool(np.isfinite(self.data.qpos).all())

    def push(self, number: int, way_m: FloatArray, most_n: float = 10.0) -> float:
        """Push an item along the table by a force through its centre; return how far it went along the way [m].

        Args:
            number: The item.
            way_m: Where to, x and y [m], shape (2,). At 0.1 m/s until it is there, at most half as long again.
            most_n: Greatest force of the push [N]; what is jammed stays.

        Raises:
            PileError: If it is not on the table, or the way has no length or is not finite.
            PileUnsettled: If the simulation blew up.
        """
        way, mass_kg = np.append(np.asarray(way_m, dtype=np.float64).reshape(-1), 0.0), self.item(number).mass_kg
        length_m = float(np.linalg.norm(way))
        if way.shape != (3,) or not (np.isfinite(length_m) and length_m > 0):
            raise PileError(f"item {number}: {way_m!r} is no way along the table", key="way_m", got=way_m)
        along, panels = way / length_m, len(panel_order(self.item(number)))
        start_m, gone_m, force_n = self.pose(number)[:3, 3], 0.0, 0.0
        for _ in range(round(1.5 * length_m / (_PUSH_M_S * _PUSH_STEP_S))):
            self.step(_PUSH_STEP_S, {number: along * force_n / panels})
            before_m, gone_m = gone_m, float((self.pose(number)[:3, 3] - start_m) @ along)
            if gone_m >= length_m:
                break
            missing_m_s = _PUSH_M_S - (gone_m - before_m) / _PUSH_STEP_S
            force_n = float(np.clip(force_n + mass_kg * missing_m_s / _PUSH_STEP_S, -most_n, most_n))
        return gone_m

    def settle(self, longest_s: float = 6.0) -> Settling:
        """Let time pass until nothing moves, or until it has been long enough; then stop what speed is left.

        At rest means: in each of two quarters of a second no corner of any item's box moved further than 0.1 mm.

        Args:
            longest_s: Give up after that [s].

        Raises:
            PileUnsettled: If the simulation blew up.
        """
        quiet, passed_s, moved_m = 0, 0.0, 0.0
        while quiet < _SPELLS and passed_s < longest_s:
            moved_m = max(self._moves_in(QUIET_S), default=0.0)
            self.data.qvel[:] = 0.0  # what rocks or rolls on is stopped here and now
            quiet, passed_s = (quiet + 1 if moved_m <= QUIET_M else 0), passed_s + QUIET_S
        self._fill(self._items, self.states, {})
        return Settling(passed_s, moved_m, quiet == _SPELLS)

    def drag(self, rate_per_s: float) -> None:
        """Slow every free motion, as a thick fluid would, until the next item is added or removed.

        The force is mass times speed times the rate [1/s], implicit in the integrator, so that it cannot blow up.
        """
        for item in self._items:
            dofs = self._slots(item, ROOT - 1)[: ROOT - 1]
            self.model.dof_damping[dofs] = rate_per_s * self.model.dof_M0[dofs]

    def creep_m(self, duration_s: float = 2.0) -> dict[int, float]:
        """How far the furthest corner of each item moves in a while if nobody does anything [m], by number.

        The world itself stays as it is.
        """
        twin = PileWorld(self._items, self.states, self.physics)
        return dict(zip((item.number for item in self._items), twin._moves_in(duration_s), strict=True))

    def _moves_in(self, duration_s: float) -> list[float]:
        before = [self.corners_m(item.number) for item in self._items]
        self.step(duration_s)
        after = [self.corners_m(item.number) for item in self._items]
        return [float(np.linalg.norm(b - a, axis=1).max()) for a, b in zip(before, after, strict=True)]

    def _fill(self, items: tuple[PileItem, ...], states: Mapping[int, FloatArray], speeds: dict[int, Any]) -> None:
        items = tuple(sorted(items, key=lambda item: item.number))
        for item in items:
            _check_state(item, items, states)
        self._items = items
        self.model = compile_pile(items, self.physics)
        self.data = self._engine.MjData(self.model)
        numbers = [item.number for item in items for _ in panel_order(item)]
        self._geom_numbers = np.array([0, *numbers], dtype=np.int64)
        for item in items:
            self._scatter(item, self.data.qpos, ROOT, states[item.number])
            if item.number in speeds:
                self._scatter(item, self.data.qvel, ROOT - 1, speeds[item.number])
        self._engine.mj_forward(self.model, self.data)

    def _speeds(self) -> dict[int, FloatArray]:
        return {item.number: self._gathered(item, self.data.qvel, ROOT - 1) for item in self._items}

    def _first_geom(self, number: int) -> int:
        self.item(number)
        return int(np.argmax(self._geom_numbers == number))

    def _panel_pose(self, geom: int) -> FloatArray:
        T = np.eye(4)
        T[:3, :3], T[:3, 3] = self.data.geom_xmat[geom].reshape(3, 3), self.data.geom_xpos[geom]
        return T

    def _slots(self, item: PileItem, root: int) -> IntArray:
        """Where the numbers of an item's state are among all: the root's, then the hinges from -x to +x."""
        before = sum(root + other.joints for other in self._items if other.number < item.number)
        hinges = [before + root + joint_order(item).index(h) for h in range(item.joints)]
        return np.array([*range(before, before + root), *hinges], dtype=np.int64)

    def _gathered(self, item: PileItem, source: FloatArray, root: int) -> FloatArray:
        return np.array(source[self._slots(item, root)])

    def _scatter(self, item: PileItem, target: FloatArray, root: int, values: FloatArray) -> None:
        target[self._slots(item, root)] = values


def _check_state(item: PileItem, items: Sequence[PileItem], states: Mapping[int, FloatArray]) -> None:
    if sum(other.number == item.number for other in items) > 1:
        raise PileError(f"two items have the number {item.number}", key="number", got=item.number)
    if item.number not in states:
        raise PileError(f"{item.name}: has no state", key="states", got=item.number)
    state = np.asarray(states[item.number], dtype=np.float64)
    if state.shape != (ROOT + item.joints,) or not np.isfinite(state).all():
        message = f"{item.name}: its state is of shape {state.shape}, not {ROOT + item.joints} finite numbers"
        raise PileError(message, key="states", got=state.tolist(), number=item.number)
    if abs(np.linalg.norm(state[3:ROOT]) - 1) > 1e-6:
        raise PileError(f"{item.name}: its quaternion {state[3:ROOT].tolist()} is not of length 1", key="states")
