# SPDX-License-Identifier: MIT
"""Time scaling of cooperative multi-robot motions: how fast may several arms carry one object?

Names are imported on first use, so that `import mrts` costs next to nothing.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

from mrts.base.version import __version__ as __version__

if TYPE_CHECKING:
    from mrts.base.errors import CompilerError, InputError, MotionError, MrtsError, SolverError
    from mrts.base.load_box import LoadBox, LoadPoint
    from mrts.base.remark import Remark
    from mrts.base.rigid_transform import RigidTransform
    from mrts.cell.cell import Cell, load_cell
    from mrts.cell.robot import Robot
    from mrts.coordination.coordinated_motion import CoordinatedMotion, follow_object
    from mrts.coordination.grasp_closure import ClosureBound
    from mrts.limits.rows import ActiveRow, RowName
    from mrts.motion.joint_table import JointTable
    from mrts.motion.motion_file import MotionDescription, load_motion, sample_motion
    from mrts.motion.object_motion import ObjectMotion
    from mrts.output.ros_bag import write_ros_bag
    from mrts.output.saved_result import load_result, save_result
    from mrts.output.trajectory_table import write_trajectory_csv
    from mrts.refinement.excess import Excess
    from mrts.report import write_report
    from mrts.retiming.result import RetimingResult, RetimingStatus
    from mrts.retiming.retime import retime
    from mrts.samples.infeasibility import Conflict
    from mrts.samples.load_sharing import LoadSharing
    from mrts.samples.range_status import SampleStatus, ScalingStatus
    from mrts.samples.sample_ranges import SampleRanges
    from mrts.scaling.holding_torques import Holding
    from mrts.scaling.known_load import torques_for_load
    from mrts.scaling.load_study import LoadStudy
    from mrts.scaling.range import RangeEnd, ScalingRange
    from mrts.scaling.result import DistributionRule, Residuals, ScalingResult
    from mrts.scaling.scale import SelectionError, scale
    from mrts.scaling.scaled_trajectory import ScaledTrajectory
    from mrts.studies.configurations import Branch, Configuration, ConfigurationStudy, rank_configurations

_HOMES = {
    "ActiveRow": "limits.rows",
    "Branch": "studies.configurations",
    "Cell": "cell.cell",
    "ClosureBound": "coordination.grasp_closure",
    "CompilerError": "base.errors",
    "Configuration": "studies.configurations",
    "ConfigurationStudy": "studies.configurations",
    "Conflict": "samples.infeasibility",
    "CoordinatedMotion": "coordination.coordinated_motion",
    "DistributionRule": "scaling.result",
    "Excess": "refinement.excess",
    "Holding": "scaling.holding_torques",
    "InputError": "base.errors",
    "JointTable": "motion.joint_table",
    "LoadBox": "base.load_box",
    "LoadPoint": "base.load_box",
    "LoadSharing": "samples.load_sharing",
    "LoadStudy": "scaling.load_study",
    "MotionDescription": "motion.motion_file",
    "MotionError": "base.errors",
    "MrtsError": "base.errors",
    "ObjectMotion": "motion.object_motion",
    "RangeEnd": "scaling.range",
    "Remark": "base.remark",
    "Residuals": "scaling.result",
    "RetimingResult": "retiming.result",
    "RetimingStatus": "retiming.result",
    "RigidTransform": "base.rigid_transform",
    "Robot": "cell.robot",
    "RowName": "limits.rows",
    "SampleRanges": "samples.sample_ranges",
    "SampleStatus": "samples.range_status",
    "ScaledTrajectory": "scaling.scaled_trajectory",
    "ScalingRange": "scaling.range",
    "ScalingResult": "scaling.result",
    "ScalingStatus": "samples.range_status",
    "SelectionError": "scaling.scale",
    "SolverError": "base.errors",
    "follow_object": "coordination.coordinated_motion",
    "load_cell": "cell.cell",
    "load_motion": "motion.motion_file",
    "load_result": "output.saved_result",
    "rank_configurations": "studies.configurations",
    "retime": "retiming.retime",
    "sample_motion": "motion.motion_file",
    "save_result": "output.saved_result",
    "scale": "scaling.scale",
    "torques_for_load": "scaling.known_load",
    "write_report": "report",
    "write_ros_bag": "output.ros_bag",
    "write_trajectory_csv": "output.trajectory_table",
}

__all__ = [
    "ActiveRow",
    "Branch",
    "Cell",
    "ClosureBound",
    "CompilerError",
    "Configuration",
    "ConfigurationStudy",
    "Conflict",
    "CoordinatedMotion",
    "DistributionRule",
    "Excess",
    "Holding",
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
    "RangeEnd",
    "Remark",
    "Residuals",
    "RetimingResult",
    "RetimingStatus",
    "RigidTransform",
    "Robot",
    "RowName",
    "SampleRanges",
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
    "write_ros_bag",
    "write_trajectory_csv",
]


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        raise AttributeError(f"module 'mrts' has no attribute '{name}'")
    return getattr(import_module(f"mrts.{_HOMES[name]}"), name)


def __dir__() -> list[str]:
    return sorted([*globals(), *__all__])
