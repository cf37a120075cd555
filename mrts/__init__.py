# SPDX-License-Identifier: MIT
"""Time scaling of cooperative multi-robot motions: how fast may several arms carry one object?

Names are imported on first use, so that `import mrts` costs next to nothing.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from mrts.cell import Cell, load_cell
    from mrts.configurations import rank_configurations
    from mrts.coordinated_motion import CoordinatedMotion, follow_object
    from mrts.errors import CompilerError, InputError, MotionError, MrtsError, SolverError
    from mrts.grasp_closure import ClosureBound
    from mrts.joint_table import JointTable
    from mrts.known_load import torques_for_load
    from mrts.load_box import LoadBox, LoadPoint
    from mrts.load_sharing import LoadSharing
    from mrts.motion_file import MotionDescription, load_motion, sample_motion
    from mrts.object_motion import ObjectMotion
    from mrts.report import write_report
    from mrts.result import ScalingResult
    from mrts.retiming import retime
    from mrts.retiming_result import RetimingResult, RetimingStatus
    from mrts.robot import Robot
    from mrts.saved_result import load_result, save_result
    from mrts.scaled_trajectory import ScaledTrajectory
    from mrts.scaling import SelectionError, scale
    from mrts.scaling_range import SampleStatus, ScalingRange, ScalingStatus
    from mrts.uncertain_load import LoadStudy

__version__ = "0.1.0"

_HOMES = {
    "Cell": "cell",
    "ClosureBound": "grasp_closure",
    "CompilerError": "errors",
    "CoordinatedMotion": "coordinated_motion",
    "InputError": "errors",
    "JointTable": "joint_table",
    "LoadBox": "load_box",
    "LoadPoint": "load_box",
    "LoadSharing": "load_sharing",
    "LoadStudy": "uncertain_load",
    "MotionDescription": "motion_file",
    "MotionError": "errors",
    "MrtsError": "errors",
    "ObjectMotion": "object_motion",
    "RetimingResult": "retiming_result",
    "RetimingStatus": "retiming_result",
    "Robot": "robot",
    "SampleStatus": "scaling_range",
    "ScaledTrajectory": "scaled_trajectory",
    "ScalingRange": "scaling_range",
    "ScalingResult": "result",
    "ScalingStatus": "scaling_range",
    "SelectionError": "scaling",
    "SolverError": "errors",
    "follow_object": "coordinated_motion",
    "load_cell": "cell",
    "load_motion": "motion_file",
    "load_result": "saved_result",
    "rank_configurations": "configurations",
    "retime": "retiming",
    "sample_motion": "motion_file",
    "save_result": "saved_result",
    "scale": "scaling",
    "torques_for_load": "known_load",
    "write_report": "report",
}

__all__ = [
    "Cell",
    "ClosureBound",
    "CompilerError",
    "CoordinatedMotion",
    "InputError",
    "JointTable",
    "LoadBox",
    "LoadPoint",
    "LoadSharing",
    "LoadStudy",
    "MotionDescription",
    "MotionError",
    "MrtsError",
    "ObjectMotion",
    "RetimingResult",
    "RetimingStatus",
    "Robot",
    "SampleStatus",
    "ScaledTrajectory",
    "ScalingRange",
    "ScalingResult",
    "ScalingStatus",
    "SelectionError",
    "SolverError",
    "follow_object",
    "load_cell",
    "load_motion",
    "load_result",
    "rank_configurations",
    "retime",
    "sample_motion",
    "save_result",
    "scale",
    "torques_for_load",
    "write_report",
]


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        raise AttributeError(f"module 'mrts' has no attribute '{name}'")
    return getattr(import_module(f"mrts.{_HOMES[name]}"), name)


def __dir__() -> list[str]:
    return sorted([*globals(), *__all__])
