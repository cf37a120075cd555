# SPDX-License-Identifier: MIT
"""Time scaling of cooperative multi-robot motions: how fast may several arms carry one object?

Names are imported on first use, so that `import mrts` costs next to nothing. What these functions return is of classes
that stand in the packages.
"""

from typing import TYPE_CHECKING

from mrts.base.lazy_names import lazy_names
from mrts.base.version import __version__ as __version__

if TYPE_CHECKING:
    from mrts.base.errors import CompilerError as CompilerError
    from mrts.base.errors import InputError as InputError
    from mrts.base.errors import MotionError as MotionError
    from mrts.base.errors import MrtsError as MrtsError
    from mrts.base.errors import SolverError as SolverError
    from mrts.base.load_box import LoadBox as LoadBox
    from mrts.base.remark import Remark as Remark
    from mrts.base.rigid_transform import RigidTransform as RigidTransform
    from mrts.cell.cell import Cell as Cell
    from mrts.cell.hands import Contact as Contact
    from mrts.cell.hands import box_contact as box_contact
    from mrts.cell.hands import gripper_contact as gripper_contact
    from mrts.cell.hands import pad_contact as pad_contact
    from mrts.cell.hands import rows_contact as rows_contact
    from mrts.cell.hands import suction_contact as suction_contact
    from mrts.cell.loading import load_cell as load_cell
    from mrts.cell.motors import JointMotors as JointMotors
    from mrts.cell.robot import Robot as Robot
    from mrts.collisions.clearance import Clearance as Clearance
    from mrts.collisions.clearance import clearance as clearance
    from mrts.following.coordinated_motion import CoordinatedMotion as CoordinatedMotion
    from mrts.following.coordinated_motion import follow_object as follow_object
    from mrts.following.grasp_closure import ClosureBound as ClosureBound
    from mrts.identification.identify import identify as identify
    from mrts.limits.rows import ActiveRow as ActiveRow
    from mrts.limits.rows import RowName as RowName
    from mrts.motion.joint_recording import JointRecording as JointRecording
    from mrts.motion.joint_recording import RecordedJoint as RecordedJoint
    from mrts.motion.joint_recording import load_recording as load_recording
    from mrts.motion.joint_table import JointTable as JointTable
    from mrts.motion.motion_file import MotionDescription as MotionDescription
    from mrts.motion.motion_file import load_motion as load_motion
    from mrts.motion.motion_file import sample_motion as sample_motion
    from mrts.motion.object_motion import ObjectMotion as ObjectMotion
    from mrts.output.ros_bag import write_ros_bag as write_ros_bag
    from mrts.output.saved_result import load_result as load_result
    from mrts.output.saved_result import save_result as save_result
    from mrts.output.trajectory_table import write_trajectory_csv as write_trajectory_csv
    from mrts.override.speed_override import SpeedOverride as SpeedOverride
    from mrts.program.load_sharing import LoadSharing as LoadSharing
    from mrts.program.range_status import SampleStatus as SampleStatus
    from mrts.program.range_status import ScalingStatus as ScalingStatus
    from mrts.program.rate_limits import RateLimits as RateLimits
    from mrts.program.sample_ranges import SampleRanges as SampleRanges
    from mrts.report import write_report as write_report
    from mrts.scaling.options import Options as Options
    from mrts.scaling.range import ScalingRange as ScalingRange
    from mrts.scaling.result import ScalingResult as ScalingResult
    from mrts.scaling.scale import SelectionError as SelectionError
    from mrts.scaling.scale import scale as scale
    from mrts.scaling.scale import torques_for_load as torques_for_load
    from mrts.simulation.controller import Controller as Controller
    from mrts.simulation.controller import PlantErrors as PlantErrors
    from mrts.simulation.reserve import least_reserve as least_reserve
    from mrts.simulation.simulate import simulate as simulate
    from mrts.starting.check import check as check
    from mrts.starting.hold import hold_here as hold_here
    from mrts.starting.plan_check import check_plan as check_plan
    from mrts.studies.configurations import rank_configurations as rank_configurations
    from mrts.studies.place import place as place
    from mrts.studies.study import Study as Study
    from mrts.studies.study import read_study as read_study
    from mrts.studies.study_folder import read_study_folder as read_study_folder
    from mrts.studies.sweep import sweep as sweep
    from mrts.timing.result import RetimingResult as RetimingResult
    from mrts.timing.result import RetimingStatus as RetimingStatus
    from mrts.timing.retime import retime as retime

__all__, __getattr__, __dir__ = lazy_names(
    __name__,
    {
        "base.errors": "CompilerError InputError MotionError MrtsError SolverError",
        "base.load_box": "LoadBox",
        "base.remark": "Remark",
        "base.rigid_transform": "RigidTransform",
        "cell.cell": "Cell",
        "cell.hands": "Contact box_contact gripper_contact pad_contact rows_contact suction_contact",
        "cell.loading": "load_cell",
        "cell.motors": "JointMotors",
        "cell.robot": "Robot",
        "starting.check": "check",
        "collisions.clearance": "Clearance clearance",
        "following.coordinated_motion": "CoordinatedMotion follow_object",
        "following.grasp_closure": "ClosureBound",
        "identification.identify": "identify",
        "limits.rows": "ActiveRow RowName",
        "motion.joint_recording": "JointRecording RecordedJoint load_recording",
        "motion.joint_table": "JointTable",
        "motion.motion_file": "MotionDescription load_motion sample_motion",
        "motion.object_motion": "ObjectMotion",
        "output.ros_bag": "write_ros_bag",
        "output.saved_result": "load_result save_result",
        "output.trajectory_table": "write_trajectory_csv",
        "override.speed_override": "SpeedOverride",
        "program.load_sharing": "LoadSharing",
        "program.range_status": "SampleStatus ScalingStatus",
        "program.rate_limits": "RateLimits",
        "program.sample_ranges": "SampleRanges",
        "report": "write_report",
        "scaling.options": "Options",
        "scaling.range": "ScalingRange",
        "scaling.result": "ScalingResult",
        "scaling.scale": "SelectionError scale torques_for_load",
        "simulation.controller": "Controller PlantErrors",
        "simulation.reserve": "least_reserve",
        "simulation.simulate": "simulate",
        "starting.hold": "hold_here",
        "starting.plan_check": "check_plan",
        "studies.configurations": "rank_configurations",
        "studies.place": "place",
        "studies.study": "Study read_study",
        "studies.study_folder": "read_study_folder",
        "studies.sweep": "sweep",
        "timing.result": "RetimingResult RetimingStatus",
        "timing.retime": "retime",
    },
)
