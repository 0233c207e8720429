"""Worlds that answer like the real one; the only owner of truth below the studies."""

from typing import TYPE_CHECKING

from rfcompass.lazy import lazy_names

if TYPE_CHECKING:
    from rfcompass.simulation.plane_room import PlaneRoom as PlaneRoom
    from rfcompass.simulation.plane_room import RoomNoise as RoomNoise
    from rfcompass.simulation.plane_room import SimulatedRobot as SimulatedRobot
    from rfcompass.simulation.sweep import SweepScene as SweepScene
    from rfcompass.simulation.sweep import simulate_sweep as simulate_sweep

_HOME = {
    "PlaneRoom": "plane_room",
    "RoomNoise": "plane_room",
    "SimulatedRobot": "plane_room",
    "SweepScene": "sweep",
    "simulate_sweep": "sweep",
}

__all__ = ["PlaneRoom", "RoomNoise", "SimulatedRobot", "SweepScene", "simulate_sweep"]

__getattr__, __dir__ = lazy_names(__name__, _HOME)
