# SPDX-License-Identifier: MIT
"""The canonical form of every constraint: named two-sided rows `lower <= M_τ τ + M_F F <= upper`."""

from dataclasses import dataclass
from typing import Literal

import numpy as np

from mrts.base.arrays import Array

Side = Literal["lower", "upper"]


@dataclass(frozen=True)
class RowName:
    """What a row limits.

    Attributes:
        kind: "torque", "wrench", "velocity", "balance" (of the object), "c2" (c² >= 0), "speed"
            (along the path), or what a constraint of yours
            limits.
        robot: Robot's name; "object" for its velocity; empty for its balance and for c².
        element: Joint, wrench component, "linear" or "angular", or empty.
        unit: "N m", "N", "rad/s", "m/s", or empty.
    """

    kind: str
    robot: str = ""
    element: str = ""
    unit: str = ""

    def __str__(self) -> str:
        if self.kind == "c2":
            return "c² ≥ 0"
        if self.kind == "speed":
            return f"speed along the path {self.element}"
        if self.kind == "balance":
            return f"balance of the object ({self.element})"
        what = "contact wrench" if self.kind == "wrench" else self.kind
        return f"{self.robot}/{self.element} {what}"

    @property
    def short(self) -> str:
        """`left/elbow` for its torque, `left/fx` for that wrench, `left/elbow velocity`; in full without a robot."""
        if not self.robot:
            return str(self)
        return f"{self.robot}/{self.element}" + ("" if self.kind in {"torque", "wrench"} else f" {self.kind}")


STANDSTILL = RowName("c2")
"""The row c² >= 0: where it binds, the cell may stand still."""


@dataclass(frozen=True)
class ActiveRow:
    """A row at one of its limits.

    Attributes:
        name: What it limits.
        side: Which limit.
        limit: Value of that limit in the row's unit.
    """

    name: RowName
    side: Side
    limit: float

    def __str__(self) -> str:
        if self.name == STANDSTILL or self.name.kind == "speed":
            return str(self.name)
        return f"{self.name} ({self.side}, {self.limit:g} {self.name.unit})"

    def to_json(self) -> dict[str, str | float]:
        """Entry of "rows" in the JSON result."""
        name = self.name
        return {
            "kind": name.kind,
            "robot": name.robot,
            "element": name.element,
            "side": self.side,
            "limit": self.limit,
            "unit": name.unit,
        }


@dataclass(frozen=True)
class LimitRows:
    """r rows over all torques τ, Shape (m,), and all wrenches F, Shape (n w,).

    Attributes:
        names: One a row.
        torque_matrix: M_τ, Shape (r, m).
        wrench_matrix: M_F, Shape (r, n w).
        lower: Shape (r,), minus infinity where unbounded.
        upper: Shape (r,), infinity where unbounded.
    """

    names: tuple[RowName, ...]
    torque_matrix: Array
    wrench_matrix: Array
    lower: Array
    upper: Array

    def units(self) -> Array:
        """What 100 % of each limit is, Shape (r,): its larger side; for a zero, the largest of its unit, or 1."""
        sides = np.stack([np.abs(self.lower), np.abs(self.upper)])
        size = np.max(np.where(np.isfinite(sides), sides, 0.0), axis=0)
        for row in np.flatnonzero(size == 0):
            alike = [size[other] for other, name in enumerate(self.names) if name.unit == self.names[row].unit]
            size[row] = max(alike) or 1.0
        return np.asarray(size, dtype=np.float64)

    def bounded(self) -> "LimitRows":
        """Only the rows that have a limit on some side."""
        keep = np.isfinite(self.lower) | np.isfinite(self.upper)
        names = tuple(name for name, kept in zip(self.names, keep, strict=True) if kept)
        return LimitRows(names, self.torque_matrix[keep], self.wrench_matrix[keep], self.lower[keep], self.upper[keep])


def stack_rows(pieces: list[LimitRows]) -> LimitRows:
    """All rows of several constraints, in order."""
    return LimitRows(
        tuple(name for piece in pieces for name in piece.names),
        np.concatenate([piece.torque_matrix for piece in pieces]),
        np.concatenate([piece.wrench_matrix for piece in pieces]),
        np.concatenate([piece.lower for piece in pieces]),
        np.concatenate([piece.upper for piece in pieces]),
    )
