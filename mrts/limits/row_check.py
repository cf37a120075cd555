# SPDX-License-Identifier: MIT
"""What a limit gives is rows of this cell and this motion, or an error that names the limit and what is wrong."""

from collections.abc import Callable

import numpy as np

from mrts.base.errors import InputError
from mrts.cell.cell import Cell
from mrts.following.coordinated_motion import CoordinatedMotion
from mrts.limits.rows import LimitRows, RowName


def limit_name(limit: Callable[..., object]) -> str:
    """What a limit is called in messages and files."""
    return str(getattr(limit, "__name__", repr(limit)))


def checked_rows(limit: Callable[..., object], cell: Cell, motion: CoordinatedMotion) -> LimitRows:
    """The rows of a limit as they are.

    Raises:
        InputError: If they are no rows of this cell along this motion: other shapes, no numbers, reversed limits.
    """
    where, rows = f"limit '{limit_name(limit)}'", limit(cell, motion)
    if not isinstance(rows, LimitRows):
        raise InputError(where, f"must give LimitRows, not {type(rows).__name__}.")
    if not all(isinstance(name, RowName) for name in rows.names):
        raise InputError(where, "must name its rows by RowName.", key="names")
    count, samples = len(rows.names), motion.samples
    wrenches = ((count, len(cell.robots) * len(cell.wrench_components)), "(r, wrench components of all arms)")
    shapes = {
        "lower": ((count,), "(r,)"),
        "upper": ((count,), "(r,)"),
        "torque_matrix": ((count, motion.q.shape[1]), "(r, joints)"),
        "wrench_matrix": wrenches,
        "object_matrix": wrenches,
        "rate": ((samples, count), "(samples, r)"),
        "speed": ((samples, count), "(samples, r)"),
        "square": ((samples, count), "(samples, r)"),
        "size": ((count,), "(r,)"),
    }
    for field, (shape, meaning) in shapes.items():
        values = getattr(rows, field)
        if values is None and field in {"object_matrix", "rate", "speed", "square", "size"}:
            continue
        if not isinstance(values, np.ndarray) or values.dtype.kind not in "fiu" or values.shape != shape:
            given = (
                f"{values.dtype} of shape {values.shape}" if isinstance(values, np.ndarray) else type(values).__name__
            )
            rule = f"must be real numbers of shape {shape}: {meaning}, r = {count} names; not {given}."
            raise InputError(where, rule, key=field)
        bounds = field in {"lower", "upper"}
        wrong = np.argwhere(np.isnan(values) if bounds else ~np.isfinite(values))
        if len(wrong):
            along_motion = field in {"rate", "speed", "square"}
            row, place = wrong[0][-1 if along_motion else 0], f" at sample {wrong[0][0]}" if along_motion else ""
            rule = "may not be NaN; a side without a limit is infinite." if bounds else "must be finite."
            raise InputError(where, f"{rows.names[row]}{place}: {rule}", key=field)
    if rows.object_matrix is not None and not (rows.object_axes and rows.object_axes.fit(cell, motion)):
        rule = "must be mrts.limits.object_axes.object_axes(cell, motion) where there is an object_matrix."
        raise InputError(where, rule, key="object_axes")
    in_order = (rows.lower <= rows.upper) & (rows.lower < np.inf) & (rows.upper > -np.inf)
    if not in_order.all():
        row = int(np.argmin(in_order))
        rule = f"{rows.names[row]}: no number is from {rows.lower[row]:g} to {rows.upper[row]:g}."
        raise InputError(where, rule, key="lower, upper")
    return rows
