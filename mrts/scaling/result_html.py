# SPDX-License-Identifier: MIT
"""Tables of results as a notebook shows them."""

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from mrts.base.notebook.in_notebooks import NotebookTable
from mrts.scaling.limit_use import limited_quantities

if TYPE_CHECKING:
    from mrts.scaling.range import ScalingRange
    from mrts.scaling.result import ScalingResult
    from mrts.scaling.what_if import WhatIf

ROUNDING = 9
"""Decimals of a margin: what is less is the rounding of a torque at its limit."""

MOST_CHANGES = 8
"""Changes that are shown of those that gain, that lose, and that cannot be played."""


def result_rows(result: "ScalingResult") -> Iterator[tuple[str, str]]:
    """Outcome, range, chosen speed, and how near every joint comes to its torque limits.

    Args:
        result: The result.
    """
    yield "outcome", result.status.value
    if result.status.admits_motion:
        yield "range of c²", result.range.text()
    done = result.trajectory
    if done is None:
        return
    yield "chosen c²", f"{done.c2:.4g}"
    yield "duration", f"{done.duration:.4g} s, as given {result.motion.object.time[-1]:.4g} s"
    for robot in result.cell.robots:
        torques = limited_quantities(result, "torque", robot.name)
        margins = np.min(np.minimum(torques.values - torques.lower, torques.upper - torques.values), axis=0)
        for joint, margin, lower, upper, unit in zip(
            torques.names, margins, robot.torque_lower, robot.torque_upper, torques.units, strict=True
        ):
            limits = f"limits [{lower:g}, {upper:g}] {unit}"
            yield f"{robot.name}/{joint}", f"margin {max(round(margin, ROUNDING), 0.0):.3g} {unit}, {limits}"


def range_ends(found: "ScalingRange") -> NotebookTable:
    """Both ends of every interval, and what sets them.

    Args:
        found: The range.
    """
    rows = []
    for low, high in reversed(found.intervals):
        for name, end in (("c²⁺", high), ("c²⁻", low)):
            speed = f"{np.sqrt(max(end.c2, 0.0)):.4g} ×" if np.isfinite(end.c2) else "∞"
            place = "nothing limits it" if end.time is None else end.place()
            rows.append((name, f"{end.c2:.6g}" if np.isfinite(end.c2) else "∞", speed, place))
    return NotebookTable(("end", "c²", "speed", "set"), rows)


def changes_table(found: "WhatIf") -> NotebookTable:
    """What gains most, what loses most, and with what the motion cannot be played.

    Args:
        found: What changes would do.
    """
    rows = [
        (str(one.change), one.amount if one.after.duration is not None else one.after.status,
         ", ".join(one.after.limits) or one.after.reason)
        for group in found.sorted()
        for one in group[:MOST_CHANGES]
    ]  # fmt: skip
    return NotebookTable(("change", "effect", "then limited by"), rows)
