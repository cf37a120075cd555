# SPDX-License-Identifier: MIT
"""The answers of a study: one row a variant, whatever becomes of it."""

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mrts.base.argument_types import check_type
from mrts.base.arrays import Array
from mrts.base.errors import InputError, MotionError, MrtsError
from mrts.collisions.clearance import clearance
from mrts.following.coordinate import coordinate
from mrts.program.range_status import RangeStatus
from mrts.scaling.options import Options
from mrts.scaling.range import RangeEnd, ScalingRange
from mrts.scaling.scale import admissible_range
from mrts.studies.parameters import ANSWERS
from mrts.studies.study import Study

UNREACHABLE, INVALID, FAILED = "unreachable", "invalid", "failed"
"""Statuses of a variant beside those of a range: the arms cannot follow, its numbers break a rule, a solver stopped."""

LIMIT_SEPARATOR = ", "
"""Between the limits that bind together."""

Row = dict[str, Any]
Columns = dict[str, Any]
"""A column by name: an array of numbers, or a list with None where there is nothing."""


def column_types(study: Study) -> dict[str, str]:
    """Names and types ("int64", "float64", "string") of the columns of a study's table, in order."""
    types = {"variant": "int64"} | {parameter.path: "float64" for parameter in study.parameters}
    return types | ANSWERS | dict.fromkeys(["clearance"] * study.question.clearance, "float64")


def solve_variants(study: Study, first: int, last: int) -> Columns:
    """The rows of some variants of a study.

    Returns:
        By column (`column_types`), one entry a variant. A variant that cannot be solved has a status and a reason.

    Raises:
        InputError: If there are no such variants.
    """
    check_type("study", study, Study)
    from mrts.studies.variant_batch import batch_for  # noqa: PLC0415 (what it does not settle is solved here)

    points, batch = study.points(first, last), batch_for(study)
    return solve_one_by_one(study, points, first) if batch is None else batch.solve(points, first)


def solve_one_by_one(study: Study, points: Array, first: int) -> Columns:
    """The rows of variants at points, Shape (V, P), from a first number, each solved as `mrts.scale` does."""
    study = study.at_hand()
    return columns_of(study, points, first, [solved_row(study, point) for point in points])


def columns_of(study: Study, points: Array, first: int, rows: Sequence[Row]) -> Columns:
    """The rows of variants at points, Shape (V, P), from a first number as columns; rows have what is found alone."""
    columns: Columns = {"variant": np.arange(first, first + len(points))}
    columns |= {parameter.path: points[:, place] for place, parameter in enumerate(study.parameters)}
    return columns | {name: [row.get(name) for row in rows] for name in column_types(study) if name not in columns}


def _labels(end: RangeEnd) -> str:
    return LIMIT_SEPARATOR.join(dict.fromkeys(row.label for row in end.rows))


def fastest_first(variant: NDArray[np.int_], duration: Array) -> NDArray[np.intp]:
    """Rows of the variants that have a duration, Shape (V,), the shortest first; of equals, the lower number."""
    rows = np.flatnonzero(np.isfinite(duration))
    return rows[np.lexsort((variant[rows], duration[rows]))]


def solved_row(study: Study, point: Array) -> Row:
    """What is found of a variant, at a point of a study as from `Study.at_hand`, Shape (P,), as `mrts.scale` does."""
    try:
        return _answer(study, *study.descriptions(point))
    except InputError as error:
        return {"status": INVALID, "reason": str(error)}
    except MotionError as error:
        return {"status": UNREACHABLE, "reason": str(error)}
    except MrtsError as error:
        return {"status": FAILED, "reason": str(error)}
    except Exception as error:  # noqa: BLE001 (a defect in one variant must not take the others with it)
        return {"status": FAILED, "reason": f"{type(error).__name__}: {error}"}


def _answer(study: Study, keys: dict[str, Any], motion_keys: dict[str, Any]) -> Row:
    cell, motion, question = study.cell_of(keys), study.motion_of(motion_keys), study.question
    cell = cell if question.reserve is None else cell.with_reserve(question.reserve)
    options = Options(load=question.load, between=question.between).checked(cell)
    found = admissible_range(cell, coordinate(cell, motion, None), options)[0]
    row = range_row(found.range, float(found.motion.object.time[-1]))
    if question.clearance:
        near = clearance(cell, motion)
        row["clearance"] = near.distance if near.pair else None
    return row


def range_row(found: ScalingRange, given_duration: float) -> Row:
    """What the range of c² says of a variant whose given motion lasts some time [s]."""
    row: Row = {"status": found.status.value}
    if found.status is not RangeStatus.FEASIBLE:
        row["reason"] = found.explain() or found.status.advice
    lower, upper = found.lower, found.upper
    if not found.status.admits_motion or lower is None or upper is None:
        return row
    row["c2_lower"] = lower.c2
    if lower.c2 > 0 and lower.time is not None:
        row |= {"lower_limit": _labels(lower), "lower_time": lower.time}
    if upper.time is not None:
        row |= {"c2_upper": upper.c2, "upper_limit": _labels(upper), "upper_time": upper.time}
        row["duration"] = given_duration / math.sqrt(upper.c2) if upper.c2 > 0 else None
    return row
