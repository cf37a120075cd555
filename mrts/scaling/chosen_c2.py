# SPDX-License-Identifier: MIT
"""Whether a motion may be played at one c²: there all rows are linear, and no interval has to be known."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from mrts.base.load_box import LoadPoint
from mrts.cell.cell import Cell
from mrts.following.coordinated_motion import CoordinatedMotion
from mrts.program.infeasibility import Conflict, conflicts_at
from mrts.program.motion_widening import motion_widening
from mrts.program.sample_problem import build_sample_problem
from mrts.scaling.load_study import LoadStudy
from mrts.scaling.result import DistributionRule


def loads_of(study: LoadStudy | None) -> tuple[LoadPoint | None, ...]:
    """Loads that a range must carry: None for the cell's, the corners of a box where none was looked at by itself."""
    return (None,) if study is None else study.points or study.box.corners(study.box.varying)


def conflict_at(
    cell: Cell,
    motion: CoordinatedMotion,
    rule: DistributionRule,
    c2: float,
    loads: Sequence[LoadPoint | None],
    solver: str,
) -> Conflict | None:
    """What forbids a c², at the sample where limits would have to move outward the most; None if nothing does.

    Args:
        cell: The cell.
        motion: Its motion.
        rule: How torques are distributed.
        c2: The c².
        loads: All must be carried; None is the cell's.
        solver: Name in the registry.

    Raises:
        SolverError: If no solver answers.
    """
    worst = None
    for point in loads:
        load = None if point is None else point.load
        share = motion_widening(
            cell, motion, np.full(motion.samples, c2), formulation=rule.formulation, sharing=rule.sharing, load=load
        )
        sample = np.array([np.argmax(share)])
        problem = build_sample_problem(
            cell, motion, formulation=rule.formulation, sharing=rule.sharing, load=load, samples=sample
        )
        (found,) = conflicts_at(problem, np.array([c2]), motion.object.time[sample], solver)
        if found is not None and (worst is None or found.widening > worst.widening):
            worst = replace(found, sample=int(sample[0]), load=point, c2=c2)
    return worst
