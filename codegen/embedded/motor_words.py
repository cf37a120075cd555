# SPDX-License-Identifier: MIT
"""What the library of a cell with motors has besides; one of ideal motors has none of it."""

from mrts_codegen.embedded.c_literals import Precision, c_number, c_numbers
from mrts_codegen.embedded.template import in_place, sections

from mrts.base.embedded_inputs import EmbeddedLimits, EmbeddedMotors

OF_LINES = ("LINE_SETTINGS", "LINE_DEFAULTS", "LINE_CHECK", "LINE_TERMS")
"""Words that are for cells where a torque-speed curve falls."""

OF_ENDS = ("MOTOR_ENDS",)
"""Words that are for cells where one ends."""


def motor_words(limits: EmbeddedLimits, words: dict[str, str], precision: Precision) -> dict[str, str]:
    """What stands for each @WORD@ that is about motors: nothing where they are ideal.

    Args:
        limits: Of the cell.
        words: All other words.
        precision: "double" or "float".
    """
    motors, texts = limits.motors, sections("motors/words.txt")
    nothing = dict.fromkeys((*texts, "MORE_VELOCITIES", "AND_ENDS"), "")
    if motors is None:
        return nothing
    ends = len(motors.end_joints)
    given = words | _numbers(motors, precision)
    left_out = (*(() if motors.line_rows else OF_LINES), *(() if ends else OF_ENDS))
    if ends:
        nothing |= {"MORE_VELOCITIES": f" + {ends}", "AND_ENDS": ", and ends of torque-speed curves"}
    return nothing | {word: "\n" + in_place(text, given) for word, text in texts.items() if word not in left_out}


def motor_memory(limits: EmbeddedLimits, joints: int, k: int) -> tuple[int, int, int]:
    """Reals that motors take in the settings, and reals and ints in the workspace.

    Args:
        limits: Of the cell.
        joints: Of all its arms.
        k: Unknowns of the programs.
    """
    if limits.motors is None:
        return 0, 0, 0
    rows = len(limits.lower)
    curve = (rows + 1) * (k + 1) + 2 * (rows + k + 2) + (k + 1) * (k + 5)
    integers = 3 * (k + 1) + rows + 7 + 6 * k
    return 3 * joints + 2 + len(limits.motors.line_rows), 3 * joints + 4 * rows + curve + 1, integers


def _numbers(motors: EmbeddedMotors, precision: Precision) -> dict[str, str]:
    places = {
        "LINE_ROWS": motors.line_rows,
        "LINE_JOINTS": motors.line_joints,
        "END_JOINTS": motors.end_joints,
    }
    return {word: ", ".join(map(str, numbers)) for word, numbers in places.items()} | {
        "LINES": str(len(motors.line_rows)),
        "ENDS": str(len(motors.end_joints)),
        "ARMATURE": c_numbers(motors.armature, precision),
        "COULOMB": c_numbers(motors.coulomb, precision),
        "VISCOUS": c_numbers(motors.viscous, precision),
        "SLOPE": c_numbers(motors.slope, precision),
        "REST": c_number(motors.rest, precision),
    }
