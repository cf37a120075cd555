# SPDX-License-Identifier: MIT
"""What an identification found of an arm's motors: efforts that rigid bodies leave over, friction, residuals."""

import numpy as np

from mrts.base.colours import COLOURS
from mrts.identification.identify import ArmMotors
from mrts.plots.plot import Axis, Item, Line, Panel, Plot, Points


def motor_plot(arm: ArmMotors) -> Plot:
    """Every joint of an arm: what is left over along time, friction over speed, and the residual.

    Blocks of the recording that do not count are left out.
    """
    rows = [_joint(arm, joint) for joint in range(len(arm.robot.joints))]
    title = f"{arm.robot.name}: efforts that the rigid bodies leave over"
    return Plot(name=f"motors_{arm.robot.name}", title=title, rows=rows)


def _joint(arm: ArmMotors, joint: int) -> list[Panel]:
    motion, name = arm.motion, arm.robot.joints[joint]
    used = motion.used[:, joint]
    time, effort = Axis(label="time [s]"), Axis(label=f"[{arm.robot.torque_units[joint]}]")
    fitted = np.where(used, arm.fitted[:, joint], np.nan)
    left_over: list[Item] = [
        Points(x=motion.time[used], y=motion.left_over[used, joint], symbol="dot", label="effort − rigid bodies"),
        Line(x=motion.time, y=fitted, color=COLOURS[1], width=0.8, label="motor"),
    ]
    speed = motion.velocity[used, joint]
    torque = motion.left_over[used, joint] - arm.value["armature"][joint] * motion.acceleration[used, joint]
    reach = np.max(np.abs(speed), initial=0.0)
    coulomb, viscous = arm.value["coulomb"][joint], arm.value["viscous"][joint]
    line = np.array([-coulomb - viscous * reach, -coulomb, coulomb, coulomb + viscous * reach])
    friction: list[Item] = [
        Points(x=speed, y=torque - arm.offset[joint], symbol="dot", label="without armature"),
        Line(x=np.array([-reach, 0, 0, reach]), y=line, color=COLOURS[1], width=0.8, label="friction"),
    ]
    rest = motion.left_over[used, joint] - arm.fitted[used, joint]
    residual: list[Item] = [Points(x=motion.time[used], y=rest, symbol="dot", color=COLOURS[2], label="residual")]
    over_speed = Axis(label=f"speed [{arm.robot.position_units[joint]}/s]")
    return [
        Panel(title=name, x=time, y=effort, items=left_over),
        Panel(title=f"{name}: friction", x=over_speed, y=effort, items=friction),
        Panel(title=f"{name}: residual", x=time, y=effort, items=residual),
    ]
