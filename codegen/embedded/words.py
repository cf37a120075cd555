# SPDX-License-Identifier: MIT
"""The numbers and names of a cell that the templates of its library want, as C writes them."""

import math
import re
from collections.abc import Iterable, Sequence
from typing import Literal

import numpy as np

from mrts.base.arrays import Array
from mrts.base.embedded_inputs import EmbeddedLimits, EmbeddedMotions, EmbeddedMotors, EmbeddedVector
from mrts.base.torque_weights import weights_by_limits
from mrts.cell.record import CellRecord

Precision = Literal["double", "float"]

UNLIMITED: dict[Precision, str] = {"double": "1e300", "float": "1e30f"}
"""What stands for infinity: `MRTS_INFINITY` of the kernel."""

PLAIN = frozenset("abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789 _-+./:^>=()")
"""Characters that mean themselves in a C string, trigraphs and format strings included."""


def c_number(value: float, precision: Precision) -> str:
    """A C literal that gives back the value, rounded to the precision.

    Args:
        value: Any but not-a-number; what the precision does not reach is unlimited.
        precision: Of the literal.
    """
    with np.errstate(over="ignore"):
        rounded = float(np.float32(value)) if precision == "float" else float(value)
    if not math.isfinite(rounded):
        return ("-" if rounded < 0 else "") + UNLIMITED[precision]
    text = f"{rounded:.9g}" if precision == "float" else repr(rounded)
    if not re.search(r"[.e]", text):
        text += ".0"
    return text + ("f" if precision == "float" else "")


def c_numbers(values: Iterable[float], precision: Precision) -> str:
    """Literals with commas between."""
    return ", ".join(c_number(float(value), precision) for value in values)


def c_string(text: str) -> str:
    """A C string literal of any text: what is not plain is written as octal escapes of its UTF-8 bytes."""
    return '"' + "".join(chr(byte) if chr(byte) in PLAIN else f"\\{byte:03o}" for byte in text.encode()) + '"'


def cell_words(cell: CellRecord, limits: EmbeddedLimits, precision: Precision) -> dict[str, str]:
    """What stands for each @WORD@ that is about the cell."""
    size, robots = len(cell.wrench_components), len(cell.robots)
    joints = sum(len(robot.joints) for robot in cell.robots)
    corners, load = _loads(cell)
    torque_limits = np.concatenate([[robot.torque_lower, robot.torque_upper] for robot in cell.robots], axis=1)
    row, column = np.nonzero(limits.matrix)
    start = np.concatenate([[0], np.cumsum(np.bincount(row, minlength=len(limits.lower)))])
    motions = limits.motions
    texts = (*limits.texts, *limits.velocity_texts, *(() if motions is None else motions.texts))
    words = {
        "NAME": cell.name,
        "REAL": precision,
        "ROBOTS": str(robots),
        "JOINTS": str(joints),
        "SIZE": str(size),
        "COMPONENTS": ", ".join(cell.wrench_components),
        "WRENCHES": str(size * robots),
        "UNKNOWNS": str(size * (robots - 1) + 1),
        "UNLIMITED": UNLIMITED[precision],
        "CORNERS": str(len(corners)),
        "LOAD_CORNERS": "\n".join(f"    {{{c_numbers(corner, precision)}}}," for corner in corners),
        "LOAD": c_numbers(load, precision),
        "WEIGHT": c_numbers(weights_by_limits(*torque_limits), precision),
        "CELL": _cell_lines(cell),
        "ROWS": str(len(limits.lower)),
        "ENTRIES": str(len(row)),
        "ROW_START": _integers(start),
        "ROW_COLUMN": _integers(column),
        "ROW_VALUE": c_numbers(limits.matrix[row, column], precision),
        "ROW_GROUP": _integers(limits.group),
        "ROW_TEXT": "\n".join(f"    {c_string(text)}," for text in texts),
        "LOWER": c_numbers(limits.lower, precision),
        "UPPER": c_numbers(limits.upper, precision),
        "VELOCITY": c_numbers(limits.velocity, precision),
    }
    if limits.base is not None:
        words |= {"BASE": c_numbers(limits.base.ravel(), precision), "AXES": _integers(limits.axes)}
    words |= {} if motions is None else _motion_words(motions, precision)
    return words | ({} if limits.motors is None else _motor_words(limits.motors, precision))


def _motion_words(motions: EmbeddedMotions, precision: Precision) -> dict[str, str]:
    arrays = {
        "ACCELERATION_LOWER": motions.acceleration[0],
        "ACCELERATION_UPPER": motions.acceleration[1],
        "OBJECT_ACCELERATION": motions.object_acceleration,
        "POINT_SPEED": motions.point_limits[:, 0],
        "POINT_ACCELERATION": motions.point_limits[:, 1],
        "POINT_PLACE": motions.points,
        "JOINT_AXIS": motions.axes,
        "JOINT_POINT": motions.axis_points,
        "THING_AXES": motions.thing_axes,
        "THING_CENTRE": motions.thing_centres,
        "FRICTION": motions.friction,
        "TILT": motions.tilt,
        "GRAVITY": motions.gravity,
    }
    return {word: c_numbers(array.ravel(), precision) for word, array in arrays.items()} | {
        "POINTS": str(len(motions.points)),
        "THINGS": str(len(motions.friction)),
        "JOINT_SLIDES": _integers(motions.slides),
        "POINT_FIRST": _integers(first for first, _ in motions.point_joints),
        "POINT_JOINTS": _integers(joints for _, joints in motions.point_joints),
    }


def _motor_words(motors: EmbeddedMotors, precision: Precision) -> dict[str, str]:
    return {
        "LINES": str(len(motors.line_rows)),
        "ENDS": str(len(motors.end_joints)),
        "LINE_ROWS": _integers(motors.line_rows),
        "LINE_JOINTS": _integers(motors.line_joints),
        "END_JOINTS": _integers(motors.end_joints),
        "ARMATURE": c_numbers(motors.armature, precision),
        "COULOMB": c_numbers(motors.coulomb, precision),
        "VISCOUS": c_numbers(motors.viscous, precision),
        "SLOPE": c_numbers(motors.slope, precision),
        "REST": c_number(motors.rest, precision),
    }


def vector_words(
    vectors: Sequence[EmbeddedVector],
    path_samples: int,
    precision: Precision,
    motors: EmbeddedMotors | None,
    macro: str,
) -> dict[str, str]:
    """What stands for each @WORD@ of the vectors' header."""
    fastest, changing = (max((abs(vector.inputs[k]).max() for vector in vectors), default=0.0) for k in (1, 2))
    rest = 0.0 if motors is None else motors.rest
    return {
        "VECTORS": str(len(vectors)),
        "PATH_SAMPLES": str(path_samples),
        "VECTOR_ROWS": "\n".join(_vector_row(vector, precision, macro if motors else None) for vector in vectors),
        "REST_SPEED": c_number(rest * fastest, precision),
        "REST_ACCELERATION": c_number(rest * changing, precision),
    }


def _vector_row(vector: EmbeddedVector, precision: Precision, macro: str | None) -> str:
    sample = ", ".join(f"{{{c_numbers(part.ravel(), precision)}}}" for part in vector.inputs)
    if macro is not None:
        sample += f", {macro}_{vector.place.upper()}"
    low, high, share_low, share_high = (c_number(end, "double") for end in (*vector.ends, *vector.share_ends))
    return (
        f"    {{{{{sample}}}, {c_number(vector.mass, precision)}, {vector.status}, {low}, {high}, "
        f"{vector.share_status}, {share_low}, {share_high}, {c_number(vector.c2, 'double')}, "
        f"{{{c_numbers(vector.torque, 'double')}}}}},"
    )


def _loads(cell: CellRecord) -> tuple[list[Array], Array]:
    """Corners of the load variation (the load itself if it is known), and the load."""
    box = cell.load_box
    return [cell.load] if box is None else [corner.load for corner in box.corners()], cell.load


def _cell_lines(cell: CellRecord) -> str:
    # text from a URDF without what Markdown or HTML would read as markup
    return "\n".join(
        re.sub(r"[^\w .,:/+\-]", "?", f"- {robot.name}: joints {', '.join(robot.joints)}") for robot in cell.robots
    )


def _integers(values: Iterable[int]) -> str:
    return ", ".join(str(int(value)) for value in values)
