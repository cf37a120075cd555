# SPDX-License-Identifier: MIT
"""What small changes to a cell would do to the fastest timing, each found by timing the same path again."""

from dataclasses import replace

import numpy as np

from mrts.base.argument_types import Progress
from mrts.base.errors import InputError
from mrts.cell.cell import Cell
from mrts.cell.cell_change import ChangeSteps
from mrts.following.coordinated_motion import CoordinatedMotion
from mrts.following.following_again import following_again
from mrts.scaling.what_if import SpeedAnswer, WhatIf, ask_changes
from mrts.timing.fastest_timing import fastest_timing
from mrts.timing.result import RetimingResult


def timing_what_if(found: RetimingResult, steps: ChangeSteps, progress: Progress) -> WhatIf:
    """What changes would do to the duration of the fastest timing, at its samples.

    Args:
        found: What `mrts.retime` found without limits of rates.
        steps: How far numbers are changed.
        progress: Told how many of how many changes are done.

    Raises:
        InputError: If rates were limited: such a timing takes seconds.
        SolverError: If no solver answers for the cell as it is.
    """
    if found.smooth is not None:
        rule = "within limits of rates it would be timed again for every change, seconds each. Ask without rates."
        raise InputError("what if", rule)
    asked = found.compared
    refined = found.motion.samples > asked.motion.samples
    asked = replace(asked, options=replace(asked.options, rates=None, between=None))

    def answer(changed: Cell, motion: CoordinatedMotion) -> SpeedAnswer:
        compared = replace(asked, cell=changed, motion=motion)
        again = fastest_timing(compared, motion, found.end_speeds, lambda _done, _total: None, refined=refined)
        return _of_timing(again)

    followed = following_again(found.cell, found.motion)
    before = answer(found.cell, followed.motion)
    return ask_changes(found.cell, followed, before, steps, answer, progress)


def _of_timing(timed: RetimingResult) -> SpeedAnswer:
    """The answer of a timing: what limits it for the longest time binds."""
    if not timed.status.admits_motion:
        return SpeedAnswer(status=timed.status.value, reason=timed.explanation)
    duration = sum(float(np.sum(part.segment_times)) for part in timed.pieces)
    limits = tuple(dict.fromkeys(name.rpartition(" (")[0] or name for name, _ in timed.limits))  # without its value
    return SpeedAnswer(status="feasible", duration=duration, limits=limits)
