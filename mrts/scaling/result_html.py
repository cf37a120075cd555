# SPDX-License-Identifier: MIT
"""A result as a small HTML table: what a notebook shows of it."""

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from mrts.base.printable import html_text
from mrts.scaling.limit_use import limited_quantities

if TYPE_CHECKING:
    from mrts.scaling.result import ScalingResult

ROUNDING = 9
"""Decimals of a margin: what is less is the rounding of a torque at its limit."""


def result_html(result: "ScalingResult") -> str:
    """Outcome, range, chosen speed, and how near every joint comes to its torque limits.

    Args:
        result: The result.
    """
    rows = "".join(
        f"<tr><th style='text-align:left'>{html_text(name)}</th><td style='text-align:left'>{html_text(text)}</td></tr>"
        for name, text in _rows(result)
    )
    lines = [f"{result.cell.name}: {result.sentence()}", *map(str, result.warnings)]
    paragraphs = "".join(f"<p style='max-width:50em'>{html_text(line)}</p>" for line in lines)
    return f"{paragraphs}<table>{rows}</table>"


def _rows(result: "ScalingResult") -> Iterator[tuple[str, str]]:
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
