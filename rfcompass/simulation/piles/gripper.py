"""A two-finger hand that goes straight down into a pile, closes, and lifts: executed grasps.

What the hand is: `hand`.

Cloth is not gripped at its sides but pinched. Covers are stiff plates here, so that pinching is a stated surrogate: if
one tip presses on a cover, and the other does too or has it close below (cloth would give way under the first), or if
both jaws touch it while they close, then it is tied to the hand there, until more than a limit pulls at it.
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from rfcompass.arrays import FloatArray
from rfcompass.errors import PileError, PileUnsettled
from rfcompass.simulation.piles.engine import compile_pile, load_mujoco, quiet_mujoco
from rfcompass.simulation.piles.hand import FINGER_HALF_M, GEOMS_OF_BODY, TIP_M, PileHand, hand_xml
from rfcompass.simulation.piles.items import PANELS
from rfcompass.simulation.piles.world import PileWorld
from rfcompass.types.record import Record
from rfcompass.types.search import BLOCKED, HELD, MISSED, SLIPPED

# All numbers of this file are ours.
# A hand nearer than this to closed has nothing between its jaws [m].
_CLOSED_M = 0.002


class _Try(NamedTuple):
    """How to simulate: how much finer than the pile's steps are, and how the contacts are solved."""

    finer: int
    iterations: int = 100
    slow: bool = False


# Tries, one after the other while the simulation blows up. Pads need half the pile's step. Where light panels are
# jammed between stiff things, Newton's method diverges in any step; conjugate gradients do not, and are slow.
_TRIES = (_Try(2), _Try(4), _Try(8), _Try(4, 500, slow=True), _Try(8, 500, slow=True))
# Nothing in a pile falls so fast [m/s], or is thrown so far while all comes to rest [m]: such a simulation blew up,
# whatever its numbers look like.
_TOO_FAST_M_S, _TOO_FAR_M = 5.0, 1.0
# The descent begins so far above the highest thing so near to the hand's axis.
_ABOVE_M, _AROUND_M = 0.02, 0.09
# What is further from the hand's axis than this, and does not hang together with anything nearer, stays at rest.
_MOVABLE_M = 0.15
_RETREAT_M = 0.02  # of a hand that was blocked
# A cover that is pinched at its end is lifted on by so much, so often, until it touches nothing any more.
_CLEARING_M, _MOST_CLEARING = 0.02, 12
# The jaws are driven shut; how often they are looked at, how long after one another, from which look on they count as
# closed, and where they move less than that between two looks.
_SHUT_M, _MOST_LOOKS, _LOOK_S, _CLOSING, _STILL_M = -0.02, 15, 0.05, 5, 5e-4
_AT_REST_S, _HELD_S = 0.1, 0.2  # how long the hand stands when it is down, and when it has lifted
_INSIDE_M = 0.001  # rays start so far inside a tip, which they do not see
_SETTLE_S = 2.0  # what still creeps then is stopped, as every pile is before it is looked at


@dataclass(frozen=True, slots=True)
class ExecutedGrasp(Record):
    """What came of a grasp: truth.

    Attributes:
        outcome: `held`, `slipped`, `missed` or `blocked`, as in `GraspAttempt`.
        taken: Numbers of the items in the hand at the end, which are no longer on the table.
        gap_m: Distance of the jaws when they had closed; as they were open where the hand was blocked [m].
        force_n: Largest vertical force on the way down [N].
        pinched: Whether a cover was pinched.
    """

    outcome: str
    taken: tuple[int, ...]
    gap_m: float
    force_n: float
    pinched: bool


def grasp_item(
    world: PileWorld, T_world_hand: FloatArray, aperture_m: float, hand: PileHand | None = None
) -> ExecutedGrasp:
    """Grasp straight down, lift, and carry away; everything else moves as it must and comes to rest.

    Args:
        world: The pile; changed.
        T_world_hand: Tool frame at the grasp, its z downwards, homogeneous, shape (4, 4).
        aperture_m: Opening of the jaws on the way down [m].
        hand: The hand's numbers.

    Raises:
        PileError: If the tool does not point straight down, or the opening is not one of the hand.
        PileUnsettled: If the simulation blew up, in finer steps too; the pile is then as it was.
    """
    hand = PileHand() if hand is None else hand
    T = np.asarray(T_world_hand, dtype=np.float64)
    if T.shape != (4, 4) or not np.isfinite(T).all() or T[2, 2] > -0.9999:
        raise PileError("the tool does not point straight down", key="T_world_hand", got=T.tolist())
    if not 0 < aperture_m <= hand.opening_m + 1e-9:
        message = f"jaws {aperture_m} m apart: they open to {hand.opening_m} m"
        raise PileError(message, key="aperture_m", got=aperture_m)
    near = _about(world, T[:2, 3])
    done, after = _simulated(near, T, aperture_m, hand)
    whole = PileWorld(world.items, world.states, world.physics)
    whole.become({**world.states, **after.states}, without=done.taken)
    if _meet(whole, after):  # something was pushed into what was left out, which would have held it back
        done, whole = _simulated(world, T, aperture_m, hand)
    world.become(whole.states, without=done.taken)
    return done


def _simulated(world: PileWorld, T: FloatArray, aperture_m: float, hand: PileHand) -> tuple[ExecutedGrasp, PileWorld]:
    """Grasp in a copy of a pile; what came of it, and the copy, at rest."""
    for how in _TRIES:
        run = _Run(world, T, aperture_m, hand, how)
        done = run.grasp()
        if done is None:
            continue
        after = PileWorld(world.items, world.states, world.physics)
        after.become(run.states, without=done.taken)
        if _comes_to_rest(after):
            return done, after
    raise PileUnsettled("the simulation of a grasp blew up", simulated_s=run.passed_s, creep_m=float("inf"))


def _comes_to_rest(world: PileWorld) -> bool:
    """Let everything settle; tell whether it stayed where things can be."""
    before = world.states
    try:
        world.settle(_SETTLE_S)
    except PileUnsettled:
        return False
    return all(np.linalg.norm(world.states[n][:3] - state[:3]) < _TOO_FAR_M for n, state in before.items())


class _BlewUp(Exception):
    """The simulation of a grasp is no longer one."""


class _Run:
    """One grasp in a copy of the pile."""

    def __init__(self, world: PileWorld, T: FloatArray, aperture_m: float, hand: PileHand, how: _Try) -> None:
        self._world, self._hand, self._engine = world, hand, load_mujoco()
        self._covers = [(item.number, panel) for item in world.items if item.kind == "cover" for panel in range(PANELS)]
        start_m = max(_top_about(world, T[:2, 3]) + TIP_M + _ABOVE_M, float(T[2, 3]))
        self._down_m = start_m - float(T[2, 3])
        xml = hand_xml(T, start_m, hand, self._covers)
        self.model = compile_pile(world.items, world.physics, xml)
        self.data = self._engine.MjData(self.model)
        states = world.data.qpos
        self.data.qpos[: len(states)] = states
        self.data.qpos[-2:] = aperture_m / 2
        self.model.opt.timestep = world.physics.timestep_s / how.finer
        first = len(world.geom_numbers)
        self._left, self._right = first + GEOMS_OF_BODY, first + GEOMS_OF_BODY + 1
        self._dof = self.model.nv - 3
        self.data.ctrl[:] = 0.0, aperture_m / 2, aperture_m / 2
        self.passed_s, self.force_n, self._tied = 0.0, 0.0, False
        free = self.model.jnt_dofadr[self.model.jnt_type == self._engine.mjtJoint.mjJNT_FREE]
        self._ways = (free[:, None] + np.arange(3)).ravel()
        self._engine.mj_forward(self.model, self.data)
        # Only now: the first contacts are solved as they were when the pile came to rest.
        self.model.opt.iterations, self.model.opt.ls_iterations = how.iterations, how.iterations // 2
        if how.slow:
            self.model.opt.solver = self._engine.mjtSolver.mjSOL_CG

    @property
    def states(self) -> dict[int, FloatArray]:
        """Where everything is now."""
        return self._world.states_in(self.data)

    def grasp(self) -> ExecutedGrasp | None:
        """Go down, close, lift; None if the simulation blew up."""
        try:
            return self._grasped()
        except _BlewUp:
            return None

    def _grasped(self) -> ExecutedGrasp | None:
        with quiet_mujoco():
            reached = self._descend()
            if not reached:
                self._go(_RETREAT_M)
                return self._sane(ExecutedGrasp(BLOCKED, (), self._gap_m(), self.force_n, False))
            if not self._tied:
                self._close()
            had, gap_m, before_m = self._between(_LOOK_S), self._gap_m(), self._heights_m()
            self._go(self._hand.lift_m)
            self._lift_clear()
            after = self._between(_HELD_S)  # what is tied is in the hand, though the middle of a cover hangs low
            held = {n for n in after if self._tied or self._heights_m()[n] - before_m[n] > self._hand.lift_m / 2}
        outcome = HELD if held else (SLIPPED if had else MISSED)
        return self._sane(ExecutedGrasp(outcome, tuple(sorted(held)), gap_m, self.force_n, self._tied))

    def _sane(self, done: ExecutedGrasp) -> ExecutedGrasp | None:
        warned = sum(int(self.data.warning[kind].number) for kind in range(len(self.data.warning)))
        return None if warned or not np.isfinite(self.data.qpos).all() else done

    def _descend(self) -> bool:
        """Go down to the grasp; stop where a cover is pinched, or something is in the way."""
        target_m = 0.0
        while target_m > -self._down_m:
            target_m = max(-self._down_m, target_m - self._hand.speed_m_s * self.model.opt.timestep)
            self._step(target_m)
            up_n = float(self.data.qfrc_constraint[self._dof])
            self.force_n = max(self.force_n, up_n)
            if up_n > self._hand.pinch_n and self._pinch():
                return True
            if up_n > self._hand.blocked_n:
                return False
        self._wait(_AT_REST_S)
        self._pinch()
        return True

    def _pinch(self) -> bool:
        """Tie the cover that a tip presses on, if the other tip has it too; the panels in question."""
        left, right = self._touching(self._left), self._touching(self._right)
        if not (left or right):
            return False
        left, right = left or self._below(self._left), right or self._below(self._right)
        both = {n for n in self._numbers(left) & self._numbers(right) if (n, 0) in self._covers}
        if not both:
            return False
        mine = [[geom for geom in sorted(side) if self._numbers({geom}) == {min(both)}] for side in (left, right)]
        for geom in {side[0] for side in mine}:  # more would tie hinges stiff, and blow up
            self._tie(geom)
        self._tied = True
        return True

    def _below(self, finger: int) -> set[int]:
        """The geom of an item straight below a tip, if it is so near that cloth would reach it; one or none."""
        tip_m = self.data.geom_xpos[finger] - np.array([0.0, 0.0, FINGER_HALF_M[2] - _INSIDE_M])
        met = np.array([-1], dtype=np.int32)
        groups = np.array([1, 0, 0, 0, 0, 0], dtype=np.uint8)
        far_m = self._engine.mj_ray(self.model, self.data, tip_m, np.array([0.0, 0.0, -1.0]), groups, 1, -1, met, None)
        near = 0 <= far_m <= self._hand.cloth_gives_m + _INSIDE_M
        return {int(met[0])} if near and 0 < met[0] < len(self._world.geom_numbers) else set()

    def _tie(self, geom: int) -> None:
        """Tie one panel to the hand where it is."""
        body, hand = int(self.model.geom_bodyid[geom]), int(self.model.geom_bodyid[self._left - 1])
        name = self._engine.mj_id2name(self.model, self._engine.mjtObj.mjOBJ_BODY, body)
        tie = self._engine.mj_name2id(self.model, self._engine.mjtObj.mjOBJ_EQUALITY, f"tie_{name}")
        point = self.data.xpos[body]
        self.model.eq_data[tie, :3] = self._in_body(hand, point)
        self.model.eq_data[tie, 3:6] = self._in_body(body, point)
        self.data.eq_active[tie] = 1

    def _in_body(self, body: int, point_m: FloatArray) -> FloatArray:
        R = self.data.xmat[body].reshape(3, 3)
        return np.asarray(R.T @ (point_m - self.data.xpos[body]))

    def _close(self) -> None:
        self.data.ctrl[1:] = _SHUT_M
        for k in range(_MOST_LOOKS):
            before_m = self._gap_m()
            self._wait(_LOOK_S)
            if self._touching(self._left) and self._touching(self._right) and self._pinch():
                break
            if k >= _CLOSING and abs(self._gap_m() - before_m) < _STILL_M:
                break

    def _lift_clear(self) -> None:
        """Lift a pinched cover on until it hangs from the hand alone: an end of it may still lie on the pile."""
        for _ in range(_MOST_CLEARING):
            if not self._tied or self._hangs_free():
                return
            self._go(_CLEARING_M)

    def _hangs_free(self) -> bool:
        """Whether the cover that is tied touches nothing but the hand and itself."""
        numbers, mine = self._world.geom_numbers, min(self._tied_covers())
        for pair in self.data.contact.geom.reshape(-1, 2):
            of = {int(numbers[geom]) for geom in pair if geom < len(numbers)}
            if mine in of and of != {mine}:
                return False
        return True

    def _tied_covers(self) -> set[int]:
        """Numbers of the covers that are tied to the hand."""
        return {self._covers[int(tie)][0] for tie in np.flatnonzero(self.data.eq_active[1:])}

    def _go(self, up_m: float) -> None:
        """Move the slide up by a way."""
        target_m = start_m = float(self.data.ctrl[0])
        while target_m < start_m + up_m:
            target_m = min(start_m + up_m, target_m + self._hand.speed_m_s * self.model.opt.timestep)
            self._step(target_m)
            if self._tied and -float(self.data.qfrc_constraint[self._dof]) > self._hand.pinch_holds_n:
                self.data.eq_active[1:] = 0
                self._tied = False

    def _wait(self, duration_s: float) -> None:
        for _ in range(round(duration_s / self.model.opt.timestep)):
            self._step(float(self.data.ctrl[0]))

    def _step(self, target_m: float) -> None:
        self.data.ctrl[0] = target_m
        self._engine.mj_step(self.model, self.data)
        self.passed_s += self.model.opt.timestep
        if self.data.time < self.passed_s / 2:
            # The simulation blew up and was begun anew by MuJoCo, with everything in one place: steps of minutes.
            raise _BlewUp
        if self._ways.size and np.abs(self.data.qvel[self._ways]).max() > _TOO_FAST_M_S:
            raise _BlewUp

    def _gap_m(self) -> float:
        return float(max(0.0, self.data.qpos[-1] + self.data.qpos[-2]))

    def _between(self, duration_s: float) -> set[int]:
        """Let time pass; numbers of the items that both jaws touched then, or that are tied.

        Stiff pads let go of a light thing for a step or two, so that one moment says little.
        """
        found: set[int] = set()
        for _ in range(round(duration_s / self.model.opt.timestep)):
            self._step(float(self.data.ctrl[0]))
            if self._gap_m() > _CLOSED_M:
                found |= self._numbers(self._touching(self._left)) & self._numbers(self._touching(self._right))
        return self._tied_covers() if self._tied else found

    def _heights_m(self) -> dict[int, float]:
        """Height of each item [m], by number."""
        return {number: float(state[2]) for number, state in self.states.items()}

    def _touching(self, finger: int) -> set[int]:
        """Geoms of items in contact with a finger."""
        pairs = self.data.contact.geom.reshape(-1, 2)
        near = {int(g) for pair in pairs if finger in pair for g in pair}
        return {g for g in near if 0 < g < len(self._world.geom_numbers)}

    def _numbers(self, geoms: set[int]) -> set[int]:
        """Items that geoms belong to."""
        return {int(self._world.geom_numbers[geom]) for geom in geoms}


def _about(world: PileWorld, place_m: FloatArray) -> PileWorld:
    """The part of a pile that a grasp can move: what is near the hand, and all that hangs together with it.

    The other piles rest meanwhile, so that they need not be computed.
    """
    todo = [item.number for item in world.items if _distance_m(world, item.number, place_m) < _MOVABLE_M]
    found = set(todo)
    while todo:
        more = world.touching(todo.pop()) - found
        found |= more
        todo += more
    items = [item for item in world.items if item.number in found]
    return PileWorld(items, {number: state for number, state in world.states.items() if number in found}, world.physics)


def _meet(world: PileWorld, near: PileWorld) -> bool:
    """Whether something that was moved touches what was left out of the simulation."""
    moved = {item.number for item in near.items}
    return any(world.touching(number) - moved for number in moved)


def _distance_m(world: PileWorld, number: int, place_m: FloatArray) -> float:
    """Level distance from a place to the box about an item [m]."""
    corners_m = world.corners_m(number)[:, :2]
    return float(np.linalg.norm(np.clip(place_m, corners_m.min(axis=0), corners_m.max(axis=0)) - place_m))


def _top_about(world: PileWorld, place_m: FloatArray) -> float:
    """Height of the highest thing that the hand could meet on its way down [m]."""
    top_m = 0.0
    for item in world.items:
        if _distance_m(world, item.number, place_m) < _AROUND_M:
            top_m = max(top_m, float(world.corners_m(item.number)[:, 2].max()))
    return top_m
