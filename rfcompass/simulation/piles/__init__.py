"""Piles of items on a table: poured, seen by a depth camera, taken apart; needs MuJoCo (`rfcompass[piles]`)."""

from typing import TYPE_CHECKING

from rfcompass.lazy import lazy_names

if TYPE_CHECKING:
    from rfcompass.simulation.piles.camera import NO_DEPTH_NOISE as NO_DEPTH_NOISE
    from rfcompass.simulation.piles.camera import NO_POSE_NOISE as NO_POSE_NOISE
    from rfcompass.simulation.piles.camera import DepthNoise as DepthNoise
    from rfcompass.simulation.piles.camera import PileCamera as PileCamera
    from rfcompass.simulation.piles.camera import PoseNoise as PoseNoise
    from rfcompass.simulation.piles.camera import look_down as look_down
    from rfcompass.simulation.piles.camera import scan_poses as scan_poses
    from rfcompass.simulation.piles.catalogue import TARGET_RGB as TARGET_RGB
    from rfcompass.simulation.piles.catalogue import draw_distractor as draw_distractor
    from rfcompass.simulation.piles.catalogue import draw_item as draw_item
    from rfcompass.simulation.piles.catalogue import draw_target as draw_target
    from rfcompass.simulation.piles.engine import PilePhysics as PilePhysics
    from rfcompass.simulation.piles.engine import flat_state as flat_state
    from rfcompass.simulation.piles.families import FAMILIES as FAMILIES
    from rfcompass.simulation.piles.families import PileFamily as PileFamily
    from rfcompass.simulation.piles.families import family as family
    from rfcompass.simulation.piles.generation import PileTally as PileTally
    from rfcompass.simulation.piles.generation import make_pile as make_pile
    from rfcompass.simulation.piles.gripper import ExecutedGrasp as ExecutedGrasp
    from rfcompass.simulation.piles.gripper import grasp_item as grasp_item
    from rfcompass.simulation.piles.hand import PileHand as PileHand
    from rfcompass.simulation.piles.items import KINDS as KINDS
    from rfcompass.simulation.piles.items import PileItem as PileItem
    from rfcompass.simulation.piles.materials import DENSITY_KG_M3 as DENSITY_KG_M3
    from rfcompass.simulation.piles.materials import PILE_MATERIALS as PILE_MATERIALS
    from rfcompass.simulation.piles.pile_shapes import drawn_shapes as drawn_shapes
    from rfcompass.simulation.piles.pile_shapes import radio_scene as radio_scene
    from rfcompass.simulation.piles.pouring import Pouring as Pouring
    from rfcompass.simulation.piles.pouring import pour as pour
    from rfcompass.simulation.piles.rays import D415 as D415
    from rfcompass.simulation.piles.rays import CameraModel as CameraModel
    from rfcompass.simulation.piles.rays import TrueImage as TrueImage
    from rfcompass.simulation.piles.rays import cast_image as cast_image
    from rfcompass.simulation.piles.rays import count_alone as count_alone
    from rfcompass.simulation.piles.scanning import PileRig as PileRig
    from rfcompass.simulation.piles.scanning import PileScan as PileScan
    from rfcompass.simulation.piles.scanning import RadioSetting as RadioSetting
    from rfcompass.simulation.piles.scanning import TagCover as TagCover
    from rfcompass.simulation.piles.scanning import hear_tags as hear_tags
    from rfcompass.simulation.piles.scanning import scan_pile as scan_pile
    from rfcompass.simulation.piles.scanning import tag_cover as tag_cover
    from rfcompass.simulation.piles.scene import FIRST_REPORT_SEED as FIRST_REPORT_SEED
    from rfcompass.simulation.piles.scene import PileScene as PileScene
    from rfcompass.simulation.piles.scene_file import open_pile as open_pile
    from rfcompass.simulation.piles.scene_file import remake_pile as remake_pile
    from rfcompass.simulation.piles.scene_file import write_pile as write_pile
    from rfcompass.simulation.piles.tagging import PLACEMENTS as PLACEMENTS
    from rfcompass.simulation.piles.tagging import ItemTag as ItemTag
    from rfcompass.simulation.piles.tagging import TaggedItems as TaggedItems
    from rfcompass.simulation.piles.tagging import tag_items as tag_items
    from rfcompass.simulation.piles.visibility import TARGET_CLASSES as TARGET_CLASSES
    from rfcompass.simulation.piles.visibility import Sight as Sight
    from rfcompass.simulation.piles.visibility import sights as sights
    from rfcompass.simulation.piles.world import PileWorld as PileWorld
    from rfcompass.simulation.piles.world import Settling as Settling

_HOME = {
    "TARGET_RGB": "catalogue",
    "D415": "rays",
    "CameraModel": "rays",
    "TrueImage": "rays",
    "cast_image": "rays",
    "count_alone": "rays",
    "NO_DEPTH_NOISE": "camera",
    "NO_POSE_NOISE": "camera",
    "DepthNoise": "camera",
    "PileCamera": "camera",
    "PoseNoise": "camera",
    "look_down": "camera",
    "scan_poses": "camera",
    "draw_distractor": "catalogue",
    "draw_item": "catalogue",
    "draw_target": "catalogue",
    "PilePhysics": "engine",
    "flat_state": "engine",
    "FAMILIES": "families",
    "PileFamily": "families",
    "family": "families",
    "PileTally": "generation",
    "make_pile": "generation",
    "ExecutedGrasp": "gripper",
    "PileHand": "hand",
    "grasp_item": "gripper",
    "KINDS": "items",
    "PileItem": "items",
    "DENSITY_KG_M3": "materials",
    "PILE_MATERIALS": "materials",
    "drawn_shapes": "pile_shapes",
    "radio_scene": "pile_shapes",
    "Pouring": "pouring",
    "pour": "pouring",
    "PileRig": "scanning",
    "PileScan": "scanning",
    "RadioSetting": "scanning",
    "TagCover": "scanning",
    "hear_tags": "scanning",
    "scan_pile": "scanning",
    "tag_cover": "scanning",
    "FIRST_REPORT_SEED": "scene",
    "PileScene": "scene",
    "open_pile": "scene_file",
    "remake_pile": "scene_file",
    "write_pile": "scene_file",
    "PLACEMENTS": "tagging",
    "ItemTag": "tagging",
    "TaggedItems": "tagging",
    "tag_items": "tagging",
    "TARGET_CLASSES": "visibility",
    "Sight": "visibility",
    "sights": "visibility",
    "PileWorld": "world",
    "Settling": "world",
}

__all__ = [
    "D415",
    "DENSITY_KG_M3",
    "FAMILIES",
    "FIRST_REPORT_SEED",
    "KINDS",
    "NO_DEPTH_NOISE",
    "NO_POSE_NOISE",
    "PILE_MATERIALS",
    "PLACEMENTS",
    "TARGET_CLASSES",
    "TARGET_RGB",
    "CameraModel",
    "DepthNoise",
    "ExecutedGrasp",
    "ItemTag",
    "PileCamera",
    "PileFamily",
    "PileHand",
    "PileItem",
    "PilePhysics",
    "PileRig",
    "PileScan",
    "PileScene",
    "PileTally",
    "PileWorld",
    "PoseNoise",
    "Pouring",
    "RadioSetting",
    "Settling",
    "Sight",
    "TagCover",
    "TaggedItems",
    "TrueImage",
    "cast_image",
    "count_alone",
    "draw_distractor",
    "draw_item",
    "draw_target",
    "drawn_shapes",
    "family",
    "flat_state",
    "grasp_item",
    "hear_tags",
    "look_down",
    "make_pile",
    "open_pile",
    "pour",
    "radio_scene",
    "remake_pile",
    "scan_pile",
    "scan_poses",
    "sights",
    "tag_cover",
    "tag_items",
    "write_pile",
]

__getattr__, __dir__ = lazy_names(__name__, _HOME)
