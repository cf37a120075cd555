# SPDX-License-Identifier: MIT
"""What a limit of the registry gives, checked: C reads these arrays without asking for their sizes."""

import numpy as np

from mrts.base.errors import InputError
from mrts.cell.cell import Cell
from mrts.coordination.coordinated_motion import CoordinatedMotion
from mrts.limits.rows import LimitRows


def given_rows(limit: str, rows: object, cell: Cell, motion: CoordinatedMotion) -> LimitRows:
    """Rows that are fit to be used.

    Args:
        limit: Its name in the registry.
        rows: What it gave for the cell and the motion.
        cell: The cell.
        motion: Its motion.

    Raises:
        InputError: If that is no `LimitRows`, an array has another shape or holds what is no number, or a lower limit
            exceeds the upper one.
    """
    if not isinstance(rows, LimitRows):
        raise InputError(f"limit '{limit}'", "must give LimitRows.", value=type(rows).__name__)
    count, samples = len(rows.names), motion.samples
    shapes = {
        "lower": (count,),
        "upper": (count,),
        "torque_matrix": (count, motion.dq.shape[1]),
        "wrench_matrix": (count, len(cell.robots) * len(cell.wrench_components)),
        "rate": (samples, count),
        "speed": (samples, count),
        "square": (samples, count),
    }
    for name, shape in shapes.items():
        value = getattr(rows, name)
        if value is None and name in {"rate", "speed", "square"}:
            continue
        if np.shape(value) != shape:
            raise InputError(f"limit '{limit}'", f"must have Shape {shape}.", key=name, value=np.shape(value))
        bad = np.isnan(value) if name in {"lower", "upper"} else ~np.isfinite(value)
        if np.any(bad):
            raise InputError(f"limit '{limit}'", "must be numbers; only limits may be infinite.", key=name)
    crossed = np.asarray(rows.lower) > np.asarray(rows.upper)
    if np.any(crossed):
        name = str(rows.names[int(np.argmax(crossed))])
        raise InputError(f"limit '{limit}'", f"its lower limit of {name} must be at most the upper one.")
    return rows
