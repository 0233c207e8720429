"""Worlds that answer like the real one; the only owner of truth below the studies."""

from typing import TYPE_CHECKING

from rfcompass.lazy import lazy_names

if TYPE_CHECKING:
    from rfcompass.simulation.antennas import LOG_PERIODIC as LOG_PERIODIC
    from rfcompass.simulation.antennas import PATCH_CIRCULAR as PATCH_CIRCULAR
    from rfcompass.simulation.antennas import PATCH_DUAL as PATCH_DUAL
    from rfcompass.simulation.antennas import PATCH_LINEAR as PATCH_LINEAR
    from rfcompass.simulation.antennas import VERT900 as VERT900
    from rfcompass.simulation.antennas import AntennaModel as AntennaModel
    from rfcompass.simulation.antennas import look_along as look_along
    from rfcompass.simulation.echoes import Backscatter as Backscatter
    from rfcompass.simulation.echoes import backscatter as backscatter
    from rfcompass.simulation.field import image_indices as image_indices
    from rfcompass.simulation.field import one_way_field as one_way_field
    from rfcompass.simulation.gen2 import Gen2Slots as Gen2Slots
    from rfcompass.simulation.grasp_oracle import GraspTry as GraspTry
    from rfcompass.simulation.grasp_oracle import PartOracle as PartOracle
    from rfcompass.simulation.grasp_oracle import Push as Push
    from rfcompass.simulation.inventory import AntennaRow as AntennaRow
    from rfcompass.simulation.inventory import Inventory as Inventory
    from rfcompass.simulation.inventory import Misses as Misses
    from rfcompass.simulation.inventory import simulate_inventory as simulate_inventory
    from rfcompass.simulation.inventory_averages import inventory_scan as inventory_scan
    from rfcompass.simulation.mask_noise import MaskNoise as MaskNoise
    from rfcompass.simulation.motion_capture import CameraRig as CameraRig
    from rfcompass.simulation.motion_capture import MotionCapture as MotionCapture
    from rfcompass.simulation.placed_tags import DUAL_DIPOLE as DUAL_DIPOLE
    from rfcompass.simulation.placed_tags import SQUIGGLE as SQUIGGLE
    from rfcompass.simulation.placed_tags import PlacedTags as PlacedTags
    from rfcompass.simulation.placed_tags import TagModel as TagModel
    from rfcompass.simulation.plane_room import PlaneRoom as PlaneRoom
    from rfcompass.simulation.radio_scene import RadioScene as RadioScene
    from rfcompass.simulation.radio_scene import Scatterers as Scatterers
    from rfcompass.simulation.radio_sensing import FAR_L_M as FAR_L_M
    from rfcompass.simulation.radio_sensing import FAR_LINE_M as FAR_LINE_M
    from rfcompass.simulation.radio_sensing import Carrier as Carrier
    from rfcompass.simulation.radio_sensing import RadioSensor as RadioSensor
    from rfcompass.simulation.radio_sensing import metal_body as metal_body
    from rfcompass.simulation.reader_noise import NOISE_BAD as NOISE_BAD
    from rfcompass.simulation.reader_noise import NOISE_NONE as NOISE_NONE
    from rfcompass.simulation.reader_noise import NOISE_R420 as NOISE_R420
    from rfcompass.simulation.reader_noise import NOISE_USRP as NOISE_USRP
    from rfcompass.simulation.reader_noise import NOISES as NOISES
    from rfcompass.simulation.reader_noise import NoiseModel as NoiseModel
    from rfcompass.simulation.reader_rig import ETSI_HZ as ETSI_HZ
    from rfcompass.simulation.reader_rig import FCC_HZ as FCC_HZ
    from rfcompass.simulation.reader_rig import RIG_PAPER as RIG_PAPER
    from rfcompass.simulation.reader_rig import RIG_R420 as RIG_R420
    from rfcompass.simulation.reader_rig import RIG_R420_ETSI as RIG_R420_ETSI
    from rfcompass.simulation.reader_rig import RIG_WRIST as RIG_WRIST
    from rfcompass.simulation.reader_rig import FixedTransmitters as FixedTransmitters
    from rfcompass.simulation.reader_rig import ReaderRig as ReaderRig
    from rfcompass.simulation.reader_rig import WristTransmitter as WristTransmitter
    from rfcompass.simulation.recipes import SCENES as SCENES
    from rfcompass.simulation.recipes import load_recipe as load_recipe
    from rfcompass.simulation.recipes import recipe_from_json as recipe_from_json
    from rfcompass.simulation.room_sensing import Heard as Heard
    from rfcompass.simulation.room_sensing import NoisyDistances as NoisyDistances
    from rfcompass.simulation.room_sensing import RoomSensor as RoomSensor
    from rfcompass.simulation.room_sensing import RoomState as RoomState
    from rfcompass.simulation.scene_recipe import SceneRecipe as SceneRecipe
    from rfcompass.simulation.simulated_robot import RecordedStop as RecordedStop
    from rfcompass.simulation.simulated_robot import SimulatedRobot as SimulatedRobot
    from rfcompass.simulation.simulated_robot import WheelSlip as WheelSlip
    from rfcompass.simulation.sweep import SweepScene as SweepScene
    from rfcompass.simulation.sweep import simulate_sweep as simulate_sweep
    from rfcompass.simulation.tracks import AntennaTrack as AntennaTrack

_HOME = {
    "LOG_PERIODIC": "antennas",
    "PATCH_CIRCULAR": "antennas",
    "PATCH_DUAL": "antennas",
    "PATCH_LINEAR": "antennas",
    "VERT900": "antennas",
    "AntennaModel": "antennas",
    "look_along": "antennas",
    "Backscatter": "echoes",
    "backscatter": "echoes",
    "image_indices": "field",
    "one_way_field": "field",
    "MaskNoise": "mask_noise",
    "CameraRig": "motion_capture",
    "Gen2Slots": "gen2",
    "GraspTry": "grasp_oracle",
    "MotionCapture": "motion_capture",
    "PartOracle": "grasp_oracle",
    "Push": "grasp_oracle",
    "AntennaRow": "inventory",
    "Inventory": "inventory",
    "Misses": "inventory",
    "simulate_inventory": "inventory",
    "DUAL_DIPOLE": "placed_tags",
    "SQUIGGLE": "placed_tags",
    "PlacedTags": "placed_tags",
    "TagModel": "placed_tags",
    "RadioScene": "radio_scene",
    "Scatterers": "radio_scene",
    "NOISES": "reader_noise",
    "NOISE_BAD": "reader_noise",
    "NOISE_NONE": "reader_noise",
    "NOISE_R420": "reader_noise",
    "NOISE_USRP": "reader_noise",
    "NoiseModel": "reader_noise",
    "ETSI_HZ": "reader_rig",
    "FCC_HZ": "reader_rig",
    "RIG_PAPER": "reader_rig",
    "RIG_R420": "reader_rig",
    "RIG_R420_ETSI": "reader_rig",
    "RIG_WRIST": "reader_rig",
    "FixedTransmitters": "reader_rig",
    "ReaderRig": "reader_rig",
    "WristTransmitter": "reader_rig",
    "SCENES": "recipes",
    "load_recipe": "recipes",
    "recipe_from_json": "recipes",
    "SceneRecipe": "scene_recipe",
    "AntennaTrack": "tracks",
    "PlaneRoom": "plane_room",
    "FAR_L_M": "radio_sensing",
    "FAR_LINE_M": "radio_sensing",
    "Carrier": "radio_sensing",
    "RadioSensor": "radio_sensing",
    "metal_body": "radio_sensing",
    "Heard": "room_sensing",
    "NoisyDistances": "room_sensing",
    "RoomSensor": "room_sensing",
    "RoomState": "room_sensing",
    "RecordedStop": "simulated_robot",
    "SimulatedRobot": "simulated_robot",
    "WheelSlip": "simulated_robot",
    "inventory_scan": "inventory_averages",
    "SweepScene": "sweep",
    "simulate_sweep": "sweep",
}

__all__ = [
    "DUAL_DIPOLE",
    "ETSI_HZ",
    "FAR_LINE_M",
    "FAR_L_M",
    "FCC_HZ",
    "LOG_PERIODIC",
    "NOISES",
    "NOISE_BAD",
    "NOISE_NONE",
    "NOISE_R420",
    "NOISE_USRP",
    "PATCH_CIRCULAR",
    "PATCH_DUAL",
    "PATCH_LINEAR",
    "RIG_PAPER",
    "RIG_R420",
    "RIG_R420_ETSI",
    "RIG_WRIST",
    "SCENES",
    "SQUIGGLE",
    "VERT900",
    "AntennaModel",
    "AntennaRow",
    "AntennaTrack",
    "Backscatter",
    "CameraRig",
    "Carrier",
    "FixedTransmitters",
    "Gen2Slots",
    "GraspTry",
    "Heard",
    "Inventory",
    "MaskNoise",
    "Misses",
    "MotionCapture",
    "NoiseModel",
    "NoisyDistances",
    "PartOracle",
    "PlacedTags",
    "PlaneRoom",
    "Push",
    "RadioScene",
    "RadioSensor",
    "ReaderRig",
    "RecordedStop",
    "RoomSensor",
    "RoomState",
    "Scatterers",
    "SceneRecipe",
    "SimulatedRobot",
    "SweepScene",
    "TagModel",
    "WheelSlip",
    "WristTransmitter",
    "backscatter",
    "image_indices",
    "inventory_scan",
    "load_recipe",
    "look_along",
    "metal_body",
    "one_way_field",
    "recipe_from_json",
    "simulate_inventory",
    "simulate_sweep",
]

__getattr__, __dir__ = lazy_names(__name__, _HOME)
