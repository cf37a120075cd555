# SPDX-License-Identifier: MIT
"""The numbers and names of a cell that the templates of its library want, as C writes them."""

import math
import re
from collections.abc import Sequence
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from mrts.base.embedded_inputs import EmbeddedLimits, EmbeddedPlan, EmbeddedVector
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


def c_numbers(values: NDArray[Any], precision: Precision) -> str:
    """Literals of all entries with commas between."""
    if values.dtype.kind != "f":
        return ", ".join(str(int(value)) for value in values.flat)
    return ", ".join(c_number(float(value), precision) for value in values.flat)


def c_string(text: str) -> str:
    """A C string literal of any text: what is not plain is written as octal escapes of its UTF-8 bytes."""
    return '"' + "".join(chr(byte) if chr(byte) in PLAIN else f"\\{byte:03o}" for byte in text.encode()) + '"'


def cell_words(cell: CellRecord, limits: EmbeddedLimits, precision: Precision) -> dict[str, str]:
    """What stands for each @WORD@ that is about the cell."""
    size, robots = len(cell.wrench_components), len(cell.robots)
    joints = sum(len(robot.joints) for robot in cell.robots)
    corners = [cell.load] if cell.load_box is None else [corner.load for corner in cell.load_box.corners()]
    torque_limits = np.concatenate([[robot.torque_lower, robot.torque_upper] for robot in cell.robots], axis=1)
    row, column = np.nonzero(limits.matrix)
    tables = {
        "LOAD": cell.load,
        "WEIGHT": weights_by_limits(*torque_limits),
        "ROW_START": np.concatenate([[0], np.cumsum(np.bincount(row, minlength=len(limits.matrix)))]),
        "ROW_COLUMN": column,
        "ROW_VALUE": limits.matrix[row, column],
        **limits.tables,
    }
    counted = {"LINES": "LINE_ROWS", "ENDS": "END_JOINTS", "POINTS": "POINT_SPEED", "THINGS": "FRICTION"}
    return {
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
        "CELL": _cell_lines(cell),
        "ROWS": str(len(limits.matrix)),
        "ENTRIES": str(len(row)),
        "ROW_TEXT": "\n".join(f"    {c_string(text)}," for text in limits.texts),
        **{count: str(len(tables[word])) for count, word in counted.items() if word in tables},
        **{word: c_numbers(table, precision) for word, table in tables.items()},
    }


def vector_words(
    vectors: Sequence[EmbeddedVector], path_samples: int, precision: Precision, limits: EmbeddedLimits, macro: str
) -> dict[str, str]:
    """What stands for each @WORD@ of the vectors' header."""
    fastest, changing = (max((abs(vector.inputs[k]).max() for vector in vectors), default=0.0) for k in (1, 2))
    rest, place = (float(limits.tables["REST"]), macro) if "REST" in limits.tables else (0.0, None)
    return {
        "VECTORS": str(len(vectors)),
        "PATH_SAMPLES": str(path_samples),
        "VECTOR_ROWS": "\n".join(_vector_row(vector, precision, place) for vector in vectors),
        "REST_SPEED": c_number(rest * fastest, precision),
        "REST_ACCELERATION": c_number(rest * changing, precision),
    }


def plan_words(plan: EmbeddedPlan, precision: Precision) -> dict[str, str]:
    """What stands for each @WORD@ of a plan's tables."""

    def of(name: str) -> str:
        return c_numbers(getattr(plan, name), precision)

    return {
        "NODES": str(len(plan.nodes)),
        "NODE_ROWS": "\n".join(f"    {_braces(node, precision)}," for node in plan.nodes),
        "LIMIT_TEXT": "\n".join(f"    {c_string(text)}," for text in plan.limits),
        "SWITCHES": f"{int(plan.backwards)}, {int(plan.varies)}, {plan.keeps_rates}",
        **{f"PLAN_{name.upper()}": of(name) for name in ("load", "armature", "coulomb", "viscous")},
    }


def _braces(value: Any, precision: Precision) -> str:
    """A structure or an array, of which the last axis stands in one line."""
    if isinstance(value, np.void):
        parts = [_braces(np.asarray(value[name]), precision) for name in value.dtype.names or ()]
    elif value.ndim > 1:
        parts = [_braces(part, precision) for part in value]
    else:
        text = c_numbers(value, precision)
        return f"{{{text}}}" if value.ndim else text
    return f"{{{', '.join(parts)}}}"


def _vector_row(vector: EmbeddedVector, precision: Precision, macro: str | None) -> str:
    sample = ", ".join(f"{{{c_numbers(part, precision)}}}" for part in vector.inputs)
    if macro is not None:
        sample += f", {macro}_{vector.place.upper()}"
    low, high, share_low, share_high = (c_number(end, "double") for end in (*vector.ends, *vector.share_ends))
    return (
        f"    {{{{{sample}}}, {c_number(vector.mass, precision)}, {vector.status}, {low}, {high}, "
        f"{vector.share_status}, {share_low}, {share_high}, {c_number(vector.c2, 'double')}, "
        f"{{{c_numbers(vector.torque, 'double')}}}}},"
    )


def _cell_lines(cell: CellRecord) -> str:
    # text from a URDF without what Markdown or HTML would read as markup
    return "\n".join(
        re.sub(r"[^\w .,:/+\-]", "?", f"- {robot.name}: joints {', '.join(robot.joints)}") for robot in cell.robots
    )
