"""Grasp plans as `rfcompass grasp` prints and stores them: a JSON file."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from rfcompass.errors import PlanFileError, RfCompassError
from rfcompass.files import read_json
from rfcompass.geometry.pose2 import Pose2, as_pose2
from rfcompass.types.grasps import Failure, GraspCandidate, GraspPlan
from rfcompass.types.motions import APPROACH, LIFT, RETREAT, TimedPath
from rfcompass.types.scene import Scene
from rfcompass.types.scene_json import scene_from_json


@dataclass(frozen=True, slots=True)
class PlanSetting:
    """What a plan was made for.

    Attributes:
        robot: Name or file of the robot; None in files of older versions.
        scene: What stood around, as in a scene file; None if nothing did, or nobody said so.
        base: Pose of the base in the scene before any drive.
    """

    robot: str | None
    scene: Scene | None
    base: Pose2


def read_plan_setting(path: Path | str) -> PlanSetting:
    """Read what a plan was made for: robot and scene.

    Raises:
        PlanFileError: If the file is no JSON object, or a key is ill-typed.
        SceneError: If the scene breaks its format.
    """
    content, file = _content(path), str(path)
    robot, base = content.get("robot"), content.get("base", [0.0, 0.0, 0.0])
    if not isinstance(robot, str | None):
        raise PlanFileError(f"{file}: robot is {robot!r}, no text", file=file, key="robot")
    try:
        pose = as_pose2(base)
    except (RfCompassError, TypeError, ValueError) as cause:
        raise PlanFileError(f"{file}: base is {base!r}, no x, y, heading", file=file, key="base") from cause
    stood = content.get("scene")
    return PlanSetting(robot, None if stood is None else scene_from_json(stood), pose)


def read_plan(path: Path | str) -> GraspPlan:
    """Read what a viewer and a robot need of a plan: its motions, its grasp and its candidates.

    How it was solved and certified is kept in the file only: a plan that was read is no certificate.

    Raises:
        PlanFileError: If the file is none, holds a failure, or a key is missing or ill-typed.
    """
    file, content = Path(path), _content(path)
    if isinstance(failure := content.get("failure"), dict):
        told = f"{failure.get('kind')}: {failure.get('message')}"
        raise PlanFileError(f"{file}: holds no plan but a failure, {told}", file=str(file))
    try:
        return _plan(content)
    except KeyError as missing:
        raise PlanFileError(f"{file}: {missing.args[0]} is missing", file=str(file), key=missing.args[0]) from missing
    except (RfCompassError, TypeError, ValueError, AttributeError) as cause:
        raise PlanFileError(f"{file}: is no grasp plan: {cause}", file=str(file)) from cause


def _content(path: Path | str) -> Mapping[str, Any]:
    file = Path(path)
    content = read_json(file, PlanFileError)
    if not isinstance(content, dict):
        raise PlanFileError(f"{file}: is no grasp plan: it holds no JSON object", file=str(file))
    return content


def _plan(content: Mapping[str, Any]) -> GraspPlan:
    names, aperture_m = tuple(map(str, content["joint_names"])), float(content["aperture_m"])
    stages = tuple(_stage(row, names) for row in content["stages"])
    chance = content["success_probability"]
    return GraspPlan(
        configuration=_array(content["configuration"]),
        approach=_joints(stages, (APPROACH,), len(names)),
        retreat=_joints(stages, (LIFT, RETREAT), len(names)),
        aperture_m=aperture_m,
        clearance_m=float(content["clearance_m"]),
        success_probability=None if chance is None else float(chance),
        candidates=tuple(_candidate(row, aperture_m) for row in content["candidates"]),
        part_id=str(content["part"]),
        T_base_hand=_array(content["T_base_hand"]),
        T_part_hand=_array(content["T_part_hand"]),
        closed_m=float(content["closed_m"]),
        success_sd=float(content["success_sd"]),
        risks=tuple((str(kind), float(share)) for kind, share in content["risks"].items()),
        stages=stages,
        base=as_pose2(content["drive_to"]),
    )


def _stage(row: Mapping[str, Any], names: tuple[str, ...]) -> TimedPath:
    return TimedPath(row["stage"], names, _array(row["times_s"]), _array(row["joints"]), _array(row["bases"]))


def _joints(stages: tuple[TimedPath, ...], wanted: tuple[str, ...], Q: int) -> np.ndarray[Any, np.dtype[np.float64]]:
    """Joint values of some stages, one after the other, shape (T, Q)."""
    return np.concatenate([np.zeros((0, Q)), *(stage.joints for stage in stages if stage.stage in wanted)])


def _candidate(row: Mapping[str, Any], aperture_m: float) -> GraspCandidate:
    kind = row["rejection"]
    rejection = None if kind is None else Failure(str(kind), str(row["message"]))
    return GraspCandidate(_array(row["T_part_hand"]), aperture_m, row["score"], rejection)


def _array(value: object) -> np.ndarray[Any, np.dtype[np.float64]]:
    return np.array(value, dtype=np.float64)
