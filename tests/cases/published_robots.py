"""Published robots that tests read: their URDFs, tips, and a cell of one arm."""

from pathlib import Path

import airo_models
import pinocchio as pin
from shipped_cells import cell_of_arms

SITE = Path(pin.__file__).parents[4]
ROBOTS = SITE / "share" / "example-robot-data" / "robots"

CASES = {
    "ur5": ("ur_description/urdf/ur5_robot.urdf", "tool0"),
    "ur10": ("ur_description/urdf/ur10_robot.urdf", "tool0"),
    "kinova j2s6": ("kinova_description/robots/kinova.urdf", "j2s6s200_end_effector"),
    "z1": ("z1_description/urdf/z1.urdf", "link06"),
    "panda": ("panda_description/urdf/panda.urdf", "panda_hand_tcp"),
    "xarm7": ("xarm_description/urdf/xarm7.urdf", "link7"),
    "baxter left": ("baxter_description/urdf/baxter.urdf", "left_gripper"),
    "baxter right": ("baxter_description/urdf/baxter.urdf", "right_gripper"),
    "ur3e": ("package://airo_models/arms/ur3e/ur3e.urdf", "tool0"),
    "ur5e": ("package://airo_models/arms/ur5e/ur5e.urdf", "tool0"),
}


def urdf_path(reference):
    if reference.startswith("package://"):
        return Path(airo_models.__file__).parent / reference.removeprefix("package://airo_models/")
    return ROBOTS / reference


def single_arm_cell(folder, reference, tip, joints):
    arm = {"name": "arm", "urdf": reference if reference.startswith("package://") else str(ROBOTS / reference)}
    arm |= {"tip_link": tip, "posture": [0.1] * joints, "torque": [100.0] * joints}
    return cell_of_arms(folder, arm, gravity=[0.3, -0.2, -9.81])
