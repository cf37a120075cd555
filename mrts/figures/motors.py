# SPDX-License-Identifier: MIT
"""What rigid-body torque leaves of measured efforts, and what the identified motors say of it."""

from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from mrts.base.argument_types import as_path
from mrts.base.atomic_file import Write, write_together
from mrts.drawing.colours import COLOURS
from mrts.figures.style import figure_writer, finish, plain, plain_text
from mrts.studies.identified_motors import ArmMotors, MotorIdentification

ROW_INCHES = 2.0

DOT = 2.0
"""Of a block [pt]."""


def draw_motor_residual(axes: Axes, arm: ArmMotors, joint: int) -> None:
    """Effort without rigid-body torque along time, its fit, and the difference; blocks that do not count are left out.

    Args:
        axes: Where to draw.
        arm: What was identified of the arm.
        joint: Its number, from 0.
    """
    left_over, fitted = (np.where(arm.used[:, joint], part[:, joint], np.nan) for part in (arm.left_over, arm.fitted))
    axes.plot(arm.time, left_over, ".", color=COLOURS[0], markersize=DOT, label="effort - rigid bodies")
    axes.plot(arm.time, fitted, color=COLOURS[1], linewidth=0.8, label="motor")
    axes.plot(arm.time, left_over - fitted, color=COLOURS[2], linewidth=0.8, label="residual")
    finish(axes, "time [s]", f"{plain(arm.robot.joints[joint])} [{arm.robot.torque_units[joint]}]")


def draw_friction(axes: Axes, arm: ArmMotors, joint: int) -> None:
    """Effort without rigid-body torque and armature over the speed, and the friction identified.

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
    axes.plot([-reach, 0, 0, reach], line, color=COLOURS[1], label="friction")
    unit = f"{arm.robot.position_units[joint]}/s"
    finish(axes, f"speed [{unit}]", f"[{arm.robot.torque_units[joint]}]")


def motor_figure(arm: ArmMotors) -> Figure:
    """Every joint of an arm: what is left over along time, and friction over speed.

    Args:
        arm: What was identified of it.
    """
    count = len(arm.robot.joints)
    figure = Figure(figsize=(9.0, 1.2 + ROW_INCHES * count), layout="constrained")
    grid = figure.subplots(count, 2, squeeze=False, width_ratios=(2, 1))
    for joint, (left, right) in enumerate(grid):
        draw_motor_residual(left, arm, joint)
        draw_friction(right, arm, joint)
    for axes in grid[0]:
        axes.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=3, fontsize="small", frameon=False)
    figure.suptitle(plain_text(f"{arm.robot.name}: efforts that the rigid bodies leave over"), fontsize="medium")
    return figure


def write_motor_figures(found: MotorIdentification, folder: Path | str) -> None:
    """Write `motors_ROBOT.png` of every recorded robot, all or none.

    Args:
        found: What `mrts.identify` found.
        folder: Is made if it is not there.

    Raises:
        InputError: If a file cannot be written.
    """
    folder = as_path("folder", folder)
    files: dict[Path, Write] = {
        folder / f"motors_{arm.robot.name}.png": figure_writer(motor_figure(arm)) for arm in found.arms
    }
    write_together(files)
