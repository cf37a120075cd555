# SPDX-License-Identifier: MIT
"""The range of c² where the load is known only within a box: three questions, kept apart by name."""

import re
from functools import partial

import numpy as np

from mrts.base.argument_types import Progress
from mrts.base.errors import InputError
from mrts.base.load_box import LoadBox, LoadPoint
from mrts.cell.cell import Cell
from mrts.following.coordinated_motion import CoordinatedMotion
from mrts.program.formulation import FormulationName
from mrts.program.load_sharing import LoadSharing
from mrts.program.trajectory_programs import motion_ranges
from mrts.scaling.load_study import LoadQuestion, LoadStudy, load_box
from mrts.scaling.range import ScalingRange, common_range

GRID_POINTS = 51
"""Loads of `grid` where no number is given."""

LARGEST_GRID = 10_000


def range_at_samples(
    cell: Cell,
    motion: CoordinatedMotion,
    question: str,
    formulation: FormulationName,
    sharing: LoadSharing | None,
    solver: str,
    progress: Progress = lambda _done, _total: None,
    high: float = np.inf,
) -> tuple[ScalingRange, LoadStudy | None]:
    """The range of c² at the samples of a motion (steps 1 and 2 of MMTSF), and what was asked of an uncertain load.

    Args:
        cell: As in `study_load`, and so the others.
        motion: Its motion.
        question: As there, or "nominal".
        formulation: Unknowns of the programs.
        sharing: A fixed distribution of the load, None for a free one.
        solver: Name in the registry.
        progress: Told how far the work is.
        high: Of several intervals the highest is found that does not begin above this c².

    Raises:
        InputError: If an argument breaks a rule.
        SolverError: If no solver answers.
    """
    if question == "nominal":
        return common_range(partial(motion_ranges, cell, motion, formulation, sharing, solver, None), high), None
    return study_load(cell, motion, question, formulation, sharing, solver, progress, high)


def study_load(
    cell: Cell,
    motion: CoordinatedMotion,
    question: str,
    formulation: FormulationName,
    sharing: LoadSharing | None,
    solver: str,
    progress: Progress = lambda _done, _total: None,
    high: float = np.inf,
) -> tuple[ScalingRange, LoadStudy]:
    """The range of c² of an uncertain load.

    Args:
        cell: The cell, with a load box.
        motion: Its motion.
        question: "guaranteed", "possible", or "grid:N" for N masses.
        formulation: As in `build_sample_problem`.
        sharing: Likewise.
        solver: Name in the registry.
        progress: Told how far the work is.
        high: As in `range_at_samples`.

    Raises:
        InputError: If there is no box, or the question does not fit it.
        SolverError: If no solver answers.
    """
    box = load_box(cell, question)
    from mrts.scaling.guaranteed_range import (  # noqa: PLC0415 (most loads are known)
        effective_parameters,
        for_every_load,
        guaranteed_range,
    )

    asked = LoadQuestion(
        cell=cell,
        motion=motion,
        formulation=formulation,
        sharing=sharing,
        solver=solver,
        progress=progress,
        high=high,
    )
    if question == "guaranteed":
        return guaranteed_range(asked, box, effective_parameters(cell, motion, box))
    if question == "possible":
        from mrts.scaling.possible_load import possible_range  # noqa: PLC0415 (its nonlinear program is rarely asked for)

        return possible_range(asked, box, effective_parameters(cell, motion, box))
    return for_every_load(asked, question, box, mass_grid(box, question))


def mass_grid(box: LoadBox, question: str) -> tuple[LoadPoint, ...]:
    """The paper's exhaustive search along k_m (below (46)): evenly spaced masses, both ends included.

    Args:
        box: What the load is known within.
        question: "grid", or "grid:N" for N masses.

    Raises:
        InputError: If it is another question, or the mass does not vary.
    """
    match = re.fullmatch(r"grid(?::([0-9]{1,9}))?", question)
    if not match:
        raise InputError("load", "must be nominal, guaranteed, possible, or grid:N such as grid:51.", value=question)
    if "mass" not in box.varying:
        raise InputError("load", "a grid runs along the mass, which does not vary in this cell.", value=question)
    count = int(match.group(1) or GRID_POINTS)
    if not 2 <= count <= LARGEST_GRID:  # noqa: PLR2004 (both ends)
        raise InputError("load", f"a grid takes 2 to {LARGEST_GRID} masses.", value=question)
    factors = np.linspace(*box.ranges["mass"], count).tolist()
    return tuple(LoadPoint({"mass": factor}, box.load_at({"mass": factor})) for factor in factors)
