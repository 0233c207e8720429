"""Grasp plans, and failures of the planner, as JSON."""

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from rfcompass.recordings import PlanSetting
    from rfcompass.types import GraspCandidate, GraspFailure, GraspPlan, StageCertificate, TimedPath, World


def world_around(setting: "PlanSetting") -> "World":
    """What stands around, in the base frame before any drive."""
    from rfcompass.robots.collision_model import homogeneous
    from rfcompass.types import World, world_of_scene

    return World() if setting.scene is None else world_of_scene(setting.scene, homogeneous(setting.base.inverse()))


def plan_json(plan: "GraspPlan", setting: "PlanSetting") -> dict[str, Any]:
    """Return a plan and what it was made for; arrays stay arrays.

    Everything is in the base frame at the grasp, [m, rad, s]; but `drive_to` is in the base frame before the drive, and
    `base`, where that frame is, in the scene's.
    """
    from rfcompass.types.scene_json import scene_to_json

    names = plan.stages[0].names if plan.stages else ()
    solution = plan.solution
    return {
        "part": plan.part_id,
        "robot": setting.robot,
        "scene": None if setting.scene is None else scene_to_json(setting.scene),
        "base": [setting.base.x_m, setting.base.y_m, setting.base.theta_rad],
        "success_probability": plan.success_probability,
        "success_sd": plan.success_sd,
        "risks": dict(plan.risks),
        "joint_names": names,
        "configuration": plan.configuration,
        "T_base_hand": plan.T_base_hand,
        "T_part_hand": plan.T_part_hand,
        "aperture_m": plan.aperture_m,
        "closed_m": plan.closed_m,
        "clearance_m": plan.clearance_m,
        "drive_to": [plan.base.x_m, plan.base.y_m, plan.base.theta_rad],
        "duration_s": plan.duration_s,
        "stages": [_stage_json(stage) for stage in plan.stages],
        "solution": None if solution is None else {
            "method": solution.method, "residual_m": solution.residual_m, "residual_rad": solution.residual_rad,
            "at_limit": solution.at_limit, "tries": solution.tries, "certified_pairs": solution.certified_pairs,
        },
        "certificates": [_certificate_json(row) for row in plan.certificates],
        "defects": plan.defects,
        "candidates": [_candidate_json(row) for row in plan.candidates],
        "reasons": plan.reasons,
    }  # fmt: skip


def grasp_failure_json(failure: "GraspFailure") -> dict[str, Any]:
    """Return why there is no plan, in the shape of all failures, with what was tried."""
    base = failure.base
    return {
        "failure": {"kind": failure.kind, "message": failure.message, **dict(failure.numbers)},
        "drive_to": None if base is None else [base.x_m, base.y_m, base.theta_rad],
        "candidates": [_candidate_json(row) for row in failure.candidates],
        "reasons": failure.reasons,
    }


def _stage_json(stage: "TimedPath") -> dict[str, Any]:
    return {"stage": stage.stage, "times_s": stage.times_s, "joints": stage.joints, "bases": stage.bases}


def _certificate_json(row: "StageCertificate") -> dict[str, Any]:
    near = row.clearance
    return {
        "stage": row.stage,
        "pairs": row.pairs,
        "fcl_checks": row.fcl_checks,
        "apart": row.apart,
        "nearest": None if near is None else [near.first, near.second],
        "nearest_m": None if near is None else near.distance_m,
        "at_least_m": row.at_least_m,
    }


def _candidate_json(row: "GraspCandidate") -> dict[str, Any]:
    return {
        "T_part_hand": row.T_part_hand,
        "score": row.score,
        "rejection": None if row.rejection is None else row.rejection.kind,
        "message": None if row.rejection is None else row.rejection.message,
    }
