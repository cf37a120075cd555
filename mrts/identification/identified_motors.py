# SPDX-License-Identifier: MIT
"""What an identification found of the motors: numbers with their confidence, as text and as YAML for the cell file."""

from dataclasses import dataclass
from pathlib import Path
from textwrap import indent
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mrts.base.arrays import Array, freeze
from mrts.base.atomic_file import write_text_atomically
from mrts.base.errors import InputError, as_path, printable
from mrts.base.remark import Remark
from mrts.base.version import __version__
from mrts.base.yaml_text import yaml_text
from mrts.cell.robot import Robot

DIGITS = 5
"""Significant digits in the YAML: more than any recording tells."""

UNITS = {
    "armature": ("kg m²", "kg"),
    "coulomb": ("N m", "N"),
    "viscous": ("N m s/rad", "N s/m"),
}
"""Of a parameter, for a revolute and for a prismatic joint."""


@dataclass(frozen=True, eq=False)
class ArmMotors:
    """The motors of one arm, joint side of their gears, and what they leave unexplained.

    The first four are by parameter: "armature" (rotor inertia by the square of the gear ratio [kg m² or kg]), "coulomb"
    (dry friction [N m or N]) and "viscous" (friction by speed [N m s/rad or N s/m]).

    Attributes:
        robot: The arm.
        value: Shape (n,), 0 where it is not identified.
        half_width: Half the interval of 95 % confidence, Shape (n,), infinity where it is not identified.
        reasons: Why the motion does not show it, "" where it does, Shape (n,).
        bounded: Whether it is 0 because it must not be negative, Shape (n,).
        offset: Constant part of the effort, which no motor has: a sensor's zero, a load that the model lacks,
            Shape (n,) [N m or N].
        residual_rms: Of what was not explained, means of blocks, Shape (n,) [N m or N].
        explained: Share of the effort's variance that model and motors explain, Shape (n,).
        cutoff: Of the filter [Hz].
        time: Of the blocks, Shape (B,) [s].
        used: Which blocks count, Shape (B, n).
        velocity: Shape (B, n) [rad/s or m/s].
        acceleration: Shape (B, n) [rad/s² or m/s²].
        left_over: Effort without the torque of the rigid bodies, Shape (B, n) [N m or N].
        fitted: What the motors say of that, Shape (B, n) [N m or N].
    """

    robot: Robot
    value: dict[str, Array]
    half_width: dict[str, Array]
    reasons: dict[str, NDArray[np.str_]]
    bounded: dict[str, NDArray[np.bool_]]
    offset: Array
    residual_rms: Array
    explained: Array
    cutoff: float
    time: Array
    used: NDArray[np.bool_]
    velocity: Array
    acceleration: Array
    left_over: Array
    fitted: Array

    def __post_init__(self) -> None:
        freeze(self)


@dataclass(frozen=True, eq=False, repr=False)
class MotorIdentification:
    """What `identify` found.

    Attributes:
        cell: Name of the cell.
        recording: The file.
        arms: The arms that were recorded.
        remarks: What to know of it.
    """

    cell: str
    recording: Path
    arms: tuple[ArmMotors, ...]
    remarks: tuple[Remark, ...]

    def __repr__(self) -> str:
        return f"<MotorIdentification of {self.cell}: {', '.join(arm.robot.name for arm in self.arms)}>"

    def arm(self, robot: str) -> ArmMotors:
        """What was found of one arm.

        Raises:
            InputError: If it was not recorded.
        """
        for arm in self.arms:
            if arm.robot.name == robot:
                return arm
        known = ", ".join(arm.robot.name for arm in self.arms)
        raise InputError("robot", f"is not in the recording; there are {known}.", value=robot)

    @property
    def empty(self) -> bool:
        """Whether no parameter is identified of all joints of an arm, so that nothing can be written."""
        return not any(np.all(why == "") for arm in self.arms for why in arm.reasons.values())

    def sentence(self) -> str:
        """The outcome in one line."""
        reasons = np.concatenate([why for arm in self.arms for why in arm.reasons.values()])
        arms = ", ".join(arm.robot.name for arm in self.arms)
        return f"{np.count_nonzero(reasons == '')} of {reasons.size} parameters of the motors of {arms} identified"

    def to_yaml(self) -> str:
        """The `motors` block of each recorded robot, as it stands in a cell file, with what is known of its numbers.

        A parameter that the motion does not show of every joint is left out, and a comment says why.
        """
        lines = [
            f"# Found by mrts {__version__} for cell {printable(self.cell)} from {printable(self.recording.name)}.",
            "# Put each `motors` block under its robot in the cell file. ± is half an interval of 95 % confidence.",
            "robots:",
        ]
        for arm in self.arms:
            lines += [f"  - name: {arm.robot.name}", *_block(arm)]
        return "\n".join(lines) + "\n"

    def write_yaml(self, path: Path | str) -> None:
        """Write `to_yaml` to a file, whole or not at all.

        Raises:
            InputError: If the file cannot be written.
        """
        write_text_atomically(as_path("path", path), self.to_yaml())


def _block(arm: ArmMotors) -> list[str]:
    rms = ", ".join(f"{value:.3g} {unit}" for value, unit in zip(arm.residual_rms, arm.robot.torque_units, strict=True))
    told = [f"{arm.time[-1] - arm.time[0]:.3g} s, filter {arm.cutoff:.4g} Hz; residual rms {rms}"]
    motors: dict[str, Any] = {}
    for name, (turning, sliding) in UNITS.items():
        value, half_width, reasons = arm.value[name], arm.half_width[name], arm.reasons[name]
        if all(reasons == ""):
            block = motors if name == "armature" else motors.setdefault("friction", {})
            block[name] = [float(f"{number:.{DIGITS}g}") for number in value]
            zero = ", ".join(np.array(arm.robot.joints)[arm.bounded[name]])
            widths = ", ".join(f"{width:.2g}" for width in half_width)
            units = " or ".join(dict.fromkeys(turning if of == "rad" else sliding for of in arm.robot.position_units))
            told.append(f"{name} in {units} ± {widths}{f'; held at 0: {zero}' if zero else ''}")
        else:
            told.append(f"{name} is not known of every joint, so it is left out:")
            joints = zip(arm.robot.joints, reasons, value, half_width, strict=True)
            told += [f"  {joint}: {why or f'{number:.4g} ± {width:.2g}'}" for joint, why, number, width in joints]
    block_text = yaml_text({"motors": motors}) if motors else ""
    return [f"    # {printable(line)}" for line in told] + indent(block_text, "    ").splitlines()
