# SPDX-License-Identifier: MIT
"""Least and largest c² of samples, and the rows that bind there."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mrts.base.arrays import Array
from mrts.limits.rows import STANDSTILL, ActiveRow, RowName, Side
from mrts.program.motion_rows import MotionRows, binds
from mrts.program.sample_problem import SampleProblem

BINDING_TOLERANCE = 1e-7
"""A row binds if its multiplier exceeds this share of the largest, or, in closed form, its c² ties this closely."""


@dataclass(frozen=True)
class BindingRows:
    """Which of r rows bind at both ends of N samples.

    Attributes:
        names: One a row.
        limits: Their lower and upper limits as given, Shape (2, r).
        codes: At the lower and the upper ends, strongest first, Shape (2, N, k): 1 + row at its upper limit, -1 - row
            at its lower one, -1 - r for c² >= 0, 0 for none.
    """

    names: tuple[RowName, ...]
    limits: Array
    codes: NDArray[np.int32]

    def at(self, sample: int, side: Side) -> tuple[ActiveRow, ...]:
        """The rows at one end of a sample."""
        codes = self.codes[0 if side == "lower" else 1, sample]
        return tuple(self._row(code) for code in codes[codes != 0].tolist())

    def _row(self, code: int) -> ActiveRow:
        row = abs(code) - 1
        if row == len(self.names):
            return ActiveRow(STANDSTILL, "lower", 0.0)
        limit = float(self.limits[0 if code < 0 else 1, row])
        return ActiveRow(self.names[row], "lower" if code < 0 else "upper", limit)

    def with_samples(
        self, samples: NDArray[np.int_], found: NDArray[np.int32], ends: slice = slice(None)
    ) -> "BindingRows":
        """The same with other codes at some samples.

        Args:
            samples: Indices, n of them.
            found: Their codes, Shape (2, n, k).
            ends: Which ends change.
        """
        codes = _wide(self.codes, found.shape[2])
        codes[ends, samples] = _wide(found, codes.shape[2])[ends]
        return BindingRows(self.names, self.limits, codes)


def chosen_rows(sources: list[BindingRows], choice: NDArray[np.int_]) -> BindingRows:
    """The rows of each end from one of several sources of the same rows.

    Args:
        sources: S of them.
        choice: Which counts at the lower and the upper ends, Shape (2, N).
    """
    wide = max(source.codes.shape[2] for source in sources)
    codes = np.stack([_wide(source.codes, wide) for source in sources])
    side, sample = np.indices(choice.shape)
    return BindingRows(sources[0].names, sources[0].limits, codes[choice, side, sample])


def _wide(codes: NDArray[np.int32], size: int) -> NDArray[np.int32]:
    """Codes with zeros behind them, so that there are at least so many."""
    more = max(size - codes.shape[2], 0)
    return np.concatenate([codes, np.zeros((*codes.shape[:2], more), dtype=np.int32)], axis=2)


def no_codes(samples: int) -> NDArray[np.int32]:
    """Codes of samples where no row binds."""
    return np.zeros((2, samples, 0), dtype=np.int32)


def rows_of_problem(problem: SampleProblem, codes: NDArray[np.int32]) -> BindingRows:
    """Codes with the names of a problem's rows."""
    return BindingRows(problem.names, np.stack([problem.limit_lower, problem.limit_upper]), codes)


def kernel_rows(form: MotionRows, basis: NDArray[np.int16], dual: NDArray[np.float32]) -> BindingRows:
    """The rows of the kernel's bases.

    Args:
        form: The rows of a motion, of which the kernel has the r that are no caps; row r + k - 1 of a basis is c² >= 0
            at its lower side, a cap at its upper one.
        basis: As the kernel gives them, Shape (2, N, k).
        dual: Their multipliers, likewise.
    """
    given, kept = form.given, np.flatnonzero(~form.is_cap)
    size = np.abs(dual)
    order = np.argsort(-size, axis=2, kind="stable")
    sides, size = np.take_along_axis(basis, order, axis=2).astype(np.int32), np.take_along_axis(size, order, axis=2)
    strong = (size > BINDING_TOLERANCE * size[:, :, :1]) & (sides != 0)
    row, of_c2 = np.abs(sides) - 1, np.abs(sides) > len(kept)
    alike = np.append(given.alike_speeds, False)
    place = np.append(kept, len(given.names))[np.where(of_c2 | (sides == 0), len(kept), row)]
    code = np.where((sides > 0) | alike[place], 1 + place, -1 - place)
    code[of_c2 & (sides > 0)] = 0
    capped = np.any(strong & of_c2 & (sides > 0), axis=2)
    of_caps = np.where(capped[:, :, None] & binds(form.cap_share), form.cap_code, 0)
    codes = np.concatenate([of_caps, np.where(strong, code, 0)], axis=2).astype(np.int32)
    return BindingRows(given.names, np.stack([given.lower, given.upper]), codes)


@dataclass
class RangeEnds:
    """Least and largest c² of a batch, the rows that bind there, and where neither was found.

    Attributes:
        lower: Shape (N,).
        upper: Shape (N,).
        rows: At both ends.
        undecided: Shape (N,).
        fallbacks: Programs that the chosen solver did not solve and another did.
        several: Whether some sample admits other intervals of c² as well: these are the highest.
    """

    lower: Array
    upper: Array
    rows: BindingRows
    undecided: NDArray[np.bool_]
    fallbacks: int
    several: bool = False

    def replace(self, samples: NDArray[np.int_], other: "RangeEnds") -> None:
        """Take some samples from another batch."""
        self.lower[samples], self.upper[samples] = other.lower, other.upper
        self.rows = self.rows.with_samples(samples, other.rows.codes)
        self.undecided[samples] = other.undecided
        self.fallbacks += other.fallbacks
        self.several |= other.several


def codes_of_duals(
    problem: SampleProblem, dual: Array, standstill: NDArray[np.bool_] | None = None
) -> NDArray[np.int32]:
    """Codes of the rows with a multiplier, strongest first; rows of the object's balance are laws and are left out.

    Args:
        problem: Rows.
        dual: Multipliers of one end, Shape (N, r).
        standstill: Where c² >= 0 binds too, Shape (N,).
    """
    size = np.abs(dual)
    order = np.argsort(-size, axis=1, kind="stable")
    strong = (size > BINDING_TOLERANCE * np.max(size, axis=1, initial=0.0, keepdims=True)) & problem.is_limit
    codes = np.where(strong, np.where(dual > 0, 1, -1) * np.arange(1, dual.shape[1] + 1), 0)
    first = np.zeros((len(dual), 1)) if standstill is None else np.where(standstill, -1 - dual.shape[1], 0)[:, None]
    return np.concatenate([first, np.take_along_axis(codes, order, axis=1)], axis=1).astype(np.int32)
