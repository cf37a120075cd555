"""Bags of MoveIt's trajectories, written by the rosbags library alone; the definitions are those of moveit_msgs 2."""

import numpy as np
from ros_bags import TYPES, message
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

ROBOT, DISPLAY = "moveit_msgs/msg/RobotTrajectory", "moveit_msgs/msg/DisplayTrajectory"

DEFINITIONS = {
    "object_recognition_msgs/msg/ObjectType": "string key\nstring db\n",
    "moveit_msgs/msg/CollisionObject": """std_msgs/Header header
geometry_msgs/Pose pose
string id
object_recognition_msgs/ObjectType type
shape_msgs/SolidPrimitive[] primitives
geometry_msgs/Pose[] primitive_poses
shape_msgs/Mesh[] meshes
geometry_msgs/Pose[] mesh_poses
shape_msgs/Plane[] planes
geometry_msgs/Pose[] plane_poses
string[] subframe_names
geometry_msgs/Pose[] subframe_poses
byte ADD=0
byte REMOVE=1
byte operation
""",
    "moveit_msgs/msg/AttachedCollisionObject": """string link_name
moveit_msgs/CollisionObject object
string[] touch_links
trajectory_msgs/JointTrajectory detach_posture
float64 weight
""",
    "moveit_msgs/msg/RobotState": """sensor_msgs/JointState joint_state
sensor_msgs/MultiDOFJointState multi_dof_joint_state
moveit_msgs/AttachedCollisionObject[] attached_collision_objects
bool is_diff
""",
    ROBOT: """trajectory_msgs/JointTrajectory joint_trajectory
trajectory_msgs/MultiDOFJointTrajectory multi_dof_joint_trajectory
""",
    DISPLAY: """string model_id
moveit_msgs/RobotTrajectory[] trajectory
moveit_msgs/RobotState trajectory_start
""",
}


def with_moveit(release=Stores.ROS2_HUMBLE):
    """The types of a release of ROS 2, and MoveIt's."""
    types = get_typestore(release)
    for name, text in DEFINITIONS.items():
        types.register(get_types_from_msg(text, name))
    return types


MOVEIT = with_moveit()


def header():
    return TYPES.types["std_msgs/msg/Header"](TYPES.types["builtin_interfaces/msg/Time"](0, 0), "world")


def robot_trajectory(names, points, floating=()):
    """RobotTrajectory; joints of several degrees of freedom, in `floating`, stand still at one point."""
    make = MOVEIT.types
    point = make["trajectory_msgs/msg/MultiDOFJointTrajectoryPoint"]
    still = point([], [], [], make["builtin_interfaces/msg/Duration"](0, 0))
    others = make["trajectory_msgs/msg/MultiDOFJointTrajectory"](header(), list(floating), [still] if floating else [])
    return make[ROBOT](message(names, points), others)


def display(*planned):
    """DisplayTrajectory of some trajectories."""
    make = MOVEIT.types
    joints = make["sensor_msgs/msg/JointState"](header(), [], *[np.zeros(0)] * 3)
    floating = make["sensor_msgs/msg/MultiDOFJointState"](header(), [], [], [], [])
    start = make["moveit_msgs/msg/RobotState"](joints, floating, [], is_diff=False)
    return make[DISPLAY]("cell", list(planned), start)
