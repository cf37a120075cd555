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
    from mrts.cell.cell import Cell
    from mrts.cell.cell_change import CellChange, ChangeSteps
    from mrts.cell.hands.contact import Contact
    from mrts.cell.hands.kinds import box_contact, gripper_contact, pad_contact, rows_contact, suction_contact
    from mrts.cell.loading import load_cell
    from mrts.cell.motors.joint_duty import JointDuty
    from mrts.cell.motors.joint_motors import JointMotors
    from mrts.cell.motors.joint_source import JointSource
    from mrts.cell.robot import Robot
    from mrts.diagnosis.arm_reach import ArmMargin, ArmReach
    from mrts.diagnosis.cell_check import CellCheck
    from mrts.diagnosis.check import check
    from mrts.diagnosis.nearest_hold import NearestHold
    from mrts.following.coordinated_motion import CoordinatedMotion, follow_object
    from mrts.following.grasp_closure import ClosureBound
    from mrts.identification.identified_motors import ArmMotors, MotorIdentification, MotorParameter
    from mrts.identification.identify import identify
    from mrts.layout.place import place
    from mrts.layout.placement import Placement, PlayedLayout
    from mrts.limits.rows import ActiveRow, RowName
    from mrts.motion.joint_recording import JointRecording, RecordedJoint, load_recording
    from mrts.motion.joint_table import JointTable
    from mrts.motion.motion_file import MotionDescription, load_motion, sample_motion
    from mrts.motion.object_motion import ObjectMotion
    from mrts.output.ros_bag import write_ros_bag
    from mrts.output.saved_result import load_result, save_result
    from mrts.output.trajectory_table import write_trajectory_csv
    from mrts.program.excess import Excess
    from mrts.program.infeasibility import Conflict
    from mrts.program.load_sharing import LoadSharing
    from mrts.program.range_status import SampleStatus, ScalingStatus
    from mrts.program.rate_limits import RateLimits
    from mrts.program.reserve import PlanReserve, Reserve
    from mrts.program.sample_ranges import SampleRanges
    from mrts.report import write_report
    from mrts.scaling.loads import LoadStudy
    from mrts.scaling.options import Options
    from mrts.scaling.range import RangeEnd, ScalingRange
    from mrts.scaling.result import Residuals, ScalingResult
    from mrts.scaling.scale import SelectionError, scale, torques_for_load
    from mrts.scaling.scaled_trajectory import Holding, ScaledTrajectory
    from mrts.scaling.what_if import ChangedAnswer, SpeedAnswer, WhatIf
    from mrts.starting.hold import hold_here
    from mrts.studies.configurations import Branch, Configuration, ConfigurationStudy, rank_configurations
    from mrts.studies.study import Study
    from mrts.studies.study_file import read_study
    from mrts.studies.study_folder import StudyFolder, read_study_folder
    from mrts.sweeps.sweep import sweep
    from mrts.sweeps.sweep_progress import SweepProgress
    from mrts.timing.result import RetimingResult, RetimingStatus, SmoothAnswer
    from mrts.timing.retime import retime

_HOMES = {
    "ActiveRow": "limits.rows",
    "ArmMargin": "diagnosis.arm_reach",
    "ArmMotors": "identification.identified_motors",
    "ArmReach": "diagnosis.arm_reach",
    "Branch": "studies.configurations",
    "Cell": "cell.cell",
    "CellChange": "cell.cell_change",
    "CellCheck": "diagnosis.cell_check",
    "ChangeSteps": "cell.cell_change",
    "ChangedAnswer": "scaling.what_if",
    "ClosureBound": "following.grasp_closure",
    "CompilerError": "base.errors",
    "Configuration": "studies.configurations",
    "ConfigurationStudy": "studies.configurations",
    "Conflict": "program.infeasibility",
    "Contact": "cell.hands.contact",
    "CoordinatedMotion": "following.coordinated_motion",
    "Excess": "program.excess",
    "Holding": "scaling.scaled_trajectory",
    "InputError": "base.errors",
    "JointDuty": "cell.motors.joint_duty",
    "JointMotors": "cell.motors.joint_motors",
    "JointSource": "cell.motors.joint_source",
    "JointRecording": "motion.joint_recording",
    "JointTable": "motion.joint_table",
    "LoadBox": "base.load_box",
    "LoadPoint": "base.load_box",
    "LoadSharing": "program.load_sharing",
    "LoadStudy": "scaling.loads",
    "MotionDescription": "motion.motion_file",
    "MotionError": "base.errors",
    "MotorIdentification": "identification.identified_motors",
    "MotorParameter": "identification.identified_motors",
    "MrtsError": "base.errors",
    "NearestHold": "diagnosis.nearest_hold",
    "ObjectMotion": "motion.object_motion",
    "Options": "scaling.options",
    "Placement": "layout.placement",
    "PlanReserve": "program.reserve",
    "PlayedLayout": "layout.placement",
    "RangeEnd": "scaling.range",
    "RecordedJoint": "motion.joint_recording",
    "Remark": "base.remark",
    "Reserve": "program.reserve",
    "Residuals": "scaling.result",
    "RateLimits": "program.rate_limits",
    "RetimingResult": "timing.result",
    "RetimingStatus": "timing.result",
    "RigidTransform": "base.rigid_transform",
    "Robot": "cell.robot",
    "RowName": "limits.rows",
    "SampleRanges": "program.sample_ranges",
    "SampleStatus": "program.range_status",
    "ScaledTrajectory": "scaling.scaled_trajectory",
    "ScalingRange": "scaling.range",
    "ScalingResult": "scaling.result",
    "ScalingStatus": "program.range_status",
    "SelectionError": "scaling.scale",
    "SmoothAnswer": "timing.result",
    "SolverError": "base.errors",
    "SpeedAnswer": "scaling.what_if",
    "WhatIf": "scaling.what_if",
    "Study": "studies.study",
    "StudyFolder": "studies.study_folder",
    "SweepProgress": "sweeps.sweep_progress",
    "box_contact": "cell.hands.kinds",
    "check": "diagnosis.check",
    "follow_object": "following.coordinated_motion",
    "gripper_contact": "cell.hands.kinds",
    "hold_here": "starting.hold",
    "identify": "identification.identify",
    "load_cell": "cell.loading",
    "load_motion": "motion.motion_file",
    "load_recording": "motion.joint_recording",
    "load_result": "output.saved_result",
    "pad_contact": "cell.hands.kinds",
    "place": "layout.place",
    "rank_configurations": "studies.configurations",
    "retime": "timing.retime",
    "read_study": "studies.study_file",
    "read_study_folder": "studies.study_folder",
    "rows_contact": "cell.hands.kinds",
    "sample_motion": "motion.motion_file",
    "save_result": "output.saved_result",
    "scale": "scaling.scale",
    "suction_contact": "cell.hands.kinds",
    "sweep": "sweeps.sweep",
    "torques_for_load": "scaling.scale",
    "write_report": "report",
    "write_ros_bag": "output.ros_bag",
    "write_trajectory_csv": "output.trajectory_table",
}

__all__ = [
    "ActiveRow",
    "ArmMargin",
    "ArmMotors",
    "ArmReach",
    "Branch",
    "Cell",
    "CellChange",
    "CellCheck",
    "ChangeSteps",
    "ChangedAnswer",
    "ClosureBound",
    "CompilerError",
    "Configuration",
    "ConfigurationStudy",
    "Conflict",
    "Contact",
    "CoordinatedMotion",
    "Excess",
    "Holding",
    "InputError",
    "JointDuty",
    "JointMotors",
    "JointRecording",
    "JointSource",
    "JointTable",
    "LoadBox",
    "LoadPoint",
    "LoadSharing",
    "LoadStudy",
    "MotionDescription",
    "MotionError",
    "MotorIdentification",
    "MotorParameter",
    "MrtsError",
    "NearestHold",
    "ObjectMotion",
    "Options",
    "Placement",
    "PlanReserve",
    "PlayedLayout",
    "RangeEnd",
    "RateLimits",
    "RecordedJoint",
    "Remark",
    "Reserve",
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
    "SmoothAnswer",
    "SolverError",
    "SpeedAnswer",
    "Study",
    "StudyFolder",
    "SweepProgress",
    "WhatIf",
    "box_contact",
    "check",
    "follow_object",
    "gripper_contact",
    "hold_here",
    "identify",
    "load_cell",
    "load_motion",
    "load_recording",
    "load_result",
    "pad_contact",
    "place",
    "rank_configurations",
    "read_study",
    "read_study_folder",
    "retime",
    "rows_contact",
    "sample_motion",
    "save_result",
    "scale",
    "suction_contact",
    "sweep",
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
