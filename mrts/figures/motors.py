# SPDX-License-Identifier: MIT
"""What rigid-body torque leaves of measured efforts, and what the identified motors say of it."""

from pathlib import Path

import numpy as np
from matplotlib.axes import Axes

from mrts.base.argument_types import as_path
from mrts.drawing.colours import COLOURS
from mrts.figures.style import NotebookFigure, check_form, finish, plain, plain_text, write_figures
from mrts.identification.identified_motors import ArmMotors, MotorIdentification

ROW_INCHES = 2.0

DOT = 2.0
"""Of a block [pt]."""


def draw_motor_torque(axes: Axes, arm: ArmMotors, joint: int) -> None:
    """Effort without rigid-body torque along time, and its fit; blocks that do not count are left out.

    Args:
        axes: Where to draw.
        arm: What was identified of the arm.
        joint: Its number, from 0.
    """
    fitted = np.where(arm.used[:, joint], arm.fitted[:, joint], np.nan)
    used = arm.used[:, joint]
    axes.plot(
        arm.time[used], arm.left_over[used, joint], ".", color=COLOURS[0], markersize=DOT, label="effort - rigid bodies"
    )
    axes.plot(arm.time, fitted, color=COLOURS[1], linewidth=0.8, label="motor")
    finish(axes, "time [s]", _unit(arm, joint))


def draw_friction(axes: Axes, arm: ArmMotors, joint: int) -> None:
    """Effort without rigid-body torque, armature and offset over the speed, and the friction identified.

    Args:
        axes: Where to draw.
        arm: What was identified of the arm.
        joint: Its number, from 0.
    """
    used = arm.used[:, joint]
    speed = arm.velocity[used, joint]
    friction = arm.left_over[used, joint] - arm.armature.value[joint] * arm.acceleration[used, joint]
    axes.plot(speed, friction - arm.offset[joint], ".", color=COLOURS[0], markersize=DOT, label="without armature")
    reach = np.max(np.abs(speed), initial=0.0)
    coulomb, viscous = arm.coulomb.value[joint], arm.viscous.value[joint]
    line = [-coulomb - viscous * reach, -coulomb, coulomb, coulomb + viscous * reach]
    axes.plot([-reach, 0, 0, reach], line, color=COLOURS[1], linewidth=0.8, label="friction")
    finish(axes, f"speed [{arm.robot.position_units[joint]}/s]", _unit(arm, joint))


def draw_motor_residual(axes: Axes, arm: ArmMotors, joint: int) -> None:
    """What neither rigid bodies nor motor explain, along time.

    Args:
        axes: Where to draw.
        arm: What was identified of the arm.
        joint: Its number, from 0.
    """
    used = arm.used[:, joint]
    residual = arm.left_over[used, joint] - arm.fitted[used, joint]
    axes.plot(arm.time[used], residual, ".", color=COLOURS[2], markersize=DOT, label="residual")
    finish(axes, "time [s]", _unit(arm, joint))


def _unit(arm: ArmMotors, joint: int) -> str:
    return f"[{arm.robot.torque_units[joint]}]"


def motor_figure(arm: ArmMotors) -> NotebookFigure:
    """Every joint of an arm: what is left over along time, friction over speed, and the residual.

    Args:
        arm: What was identified of it.
    """
    count = len(arm.robot.joints)
    figure = NotebookFigure(figsize=(11.0, 1.2 + ROW_INCHES * count), layout="constrained")
    grid = figure.subplots(count, 3, squeeze=False, width_ratios=(2, 1, 1))
    for joint, row in enumerate(grid):
        for axes, draw in zip(row, (draw_motor_torque, draw_friction, draw_motor_residual), strict=True):
            draw(axes, arm, joint)
        row[0].set_title(plain(arm.robot.joints[joint]), loc="left", fontsize="small")
    for axes in grid[0]:
        axes.legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=2, fontsize="small", frameon=False)
    figure.suptitle(plain_text(f"{arm.robot.name}: efforts that the rigid bodies leave over"), fontsize="medium")
    return figure


def write_motor_figures(found: MotorIdentification, folder: Path | str, form: str = "png") -> None:
    """Write a figure `motors_ROBOT` of every recorded robot, all or none.

    Args:
        found: What `mrts.identify` found.
        folder: Is made if it is not there.
        form: "png", "svg" or "pdf".

    Raises:
        InputError: If there is no such format, or a file cannot be written.
    """
    check_form(form)
    figures = {f"motors_{arm.robot.name}": motor_figure(arm) for arm in found.arms}
    write_figures(figures, as_path("folder", folder), form)
