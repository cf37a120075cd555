# SPDX-License-Identifier: MIT
"""The numbers of a study that are a layout: where bases stand, how hands hold, near which postures arms start."""

from dataclasses import dataclass
from typing import Any, Self

import numpy as np

from mrts.base.arrays import Array
from mrts.base.errors import InputError
from mrts.base.manifest import GRAVITY_SIZE, ROBOT_SIZE
from mrts.base.rigid_transform import rpy_entries
from mrts.cell.cell import Cell
from mrts.studies.parameters import Parameter
from mrts.studies.study import Study
from mrts.studies.variant_numbers import POSES, Entry, base_numbers, target_entries, variant_numbers

PARTS = (*POSES, "posture")
"""Arrays of `mrts.studies.variant_numbers` that are a layout."""

DIGITS = 5
"""Decimals of the numbers of an answer: 10 µm and 10 µrad, less than anyone can set up."""

SAME_PLACE = 1e-9
"""Largest difference of numbers that are the same after rounding [m, rad]."""

NOT_A_LAYOUT = (
    "is no number of a layout. What mrts place moves are base, grasp and posture of robots, poses by xyz and rpy; "
    "leave it out, or compare its values by mrts sweep."
)


@dataclass(frozen=True, kw_only=True)
class LayoutNumbers:
    """P numbers that move arms, hands and postures, all of which are affine in them.

    Attributes:
        parameters: Of the study.
        lower: Least values, Shape (P,).
        upper: Largest values, Shape (P,).
        given: What the files of the study have: the arrays of `PARTS` one after the other, Shape (12 n + m,).
        offset: The same with all parameters at zero.
        slope: By the parameters, Shape (12 n + m, P).
    """

    parameters: tuple[Parameter, ...]
    lower: Array
    upper: Array
    given: Array
    offset: Array
    slope: Array

    @classmethod
    def of(cls, study: Study, cell: Cell) -> Self:
        """The numbers of a study.

        Raises:
            InputError: If it varies what is no layout, or not between two values.
        """
        base = base_numbers(study, cell)
        entries: list[Entry] = []
        for column, parameter in enumerate(study.parameters):
            for target in parameter.targets:
                places = target_entries(target, column, study, cell)
                if not places or places[0].name not in PARTS:
                    raise InputError(study.path, NOT_A_LAYOUT, key=f"vary: {target.path}")
                entries += places

        def rows(points: Array) -> Array:
            """The arrays of `PARTS` one after the other, Shape (V, 12 n + m)."""
            numbers = variant_numbers(base, entries, points)
            parts = [np.repeat(of, len(points) // len(of), axis=0) for of in (numbers[name] for name in PARTS)]
            return np.concatenate([part.reshape(len(points), -1) for part in parts], axis=1)

        P = len(study.parameters)
        offset = rows(np.zeros((1, P)))[0]
        slope = (rows(np.eye(P)) - offset).T
        given = np.concatenate([base[name].ravel() for name in PARTS])
        lower, upper = np.array([_bounds(study, parameter) for parameter in study.parameters]).T
        return cls(parameters=study.parameters, lower=lower, upper=upper, given=given, offset=offset, slope=slope)

    def nearest_given(self) -> tuple[Array, bool]:
        """The values nearest to what the files have, within bounds, Shape (P,), and whether they give just that."""
        values = np.linalg.lstsq(self.slope, self.given - self.offset, rcond=None)[0]
        inside = np.clip(values, self.lower, self.upper)
        off = np.max(np.abs(self.offset + self.slope @ inside - self.given))
        return inside, bool(off <= SAME_PLACE)

    def rounded(self, values: Array) -> Array:
        """Values as they are written, within their bounds and at a bound that they round to, Shape (P,)."""
        rounded = np.clip(np.round(values, DIGITS), self.lower, self.upper)
        for bound in (self.lower, self.upper):
            rounded = np.where(np.abs(values - bound) < 10.0**-DIGITS / 2, bound, rounded)
        return rounded

    def geometry(self, cell: Cell, values: Any) -> Any:
        """The geometry of the cell at symbols of the values, Shape (g,); poses that do not move are numbers.

        Args:
            cell: The cell.
            values: CasADi symbols, Shape (P,).
        """
        import casadi as ca  # noqa: PLC0415 (here it is symbols; reading a study does without)

        n = len(cell.robots)
        numbers = ca.DM(self.offset) + ca.sparsify(ca.DM(self.slope)) @ values
        entries = ca.SX(cell.geometry)
        for robot in range(n):
            for frame in range(2):
                xyz, rpy = (slice(first := 3 * (n * part + robot), first + 3) for part in (2 * frame, 2 * frame + 1))
                if np.any(self.slope[xyz]) or np.any(self.slope[rpy]):
                    cosines_and_sines = (turn(numbers[rpy][axis]) for axis in range(3) for turn in (ca.cos, ca.sin))
                    start = GRAVITY_SIZE + (2 * robot + frame) * ROBOT_SIZE // 2
                    entries[start : start + 9] = ca.vec(ca.blockcat(rpy_entries(*cosines_and_sines)).T)
                    entries[start + 9 : start + 12] = numbers[xyz]
        return entries

    def postures(self, cell: Cell, values: Any) -> Any:
        """All postures at symbols of the values, Shape (m,) [rad or m]."""
        import casadi as ca  # noqa: PLC0415 (likewise)

        rows = slice(12 * len(cell.robots), None)
        return ca.DM(self.offset[rows]) + ca.sparsify(ca.DM(self.slope[rows])) @ values


def _bounds(study: Study, parameter: Parameter) -> tuple[float, float]:
    distribution = parameter.distribution
    if distribution.kind in {"uniform", "steps"}:
        return distribution.numbers[0], distribution.numbers[-1]
    raise InputError(
        study.path,
        "must be given by 'from' and 'to', between which the best layout is searched.",
        key=f"vary: {parameter.path}",
        value=distribution.text(parameter.unit),
    )
