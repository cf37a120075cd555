# SPDX-License-Identifier: MIT
"""The limits of many variants of one cell as the native calls take them, and the names of the rows that they return."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from mrts.base.arrays import Array
from mrts.base.manifest import GRAVITY_SIZE, ROBOT_SIZE
from mrts.cell.cell import Cell
from mrts.following.coordinated_motion import CoordinatedMotion
from mrts.kernel.cell_library import SparseLimits
from mrts.limits import limit_rows
from mrts.limits.cell_limits import torque_limits, velocity_limits, wrench_limits
from mrts.limits.rows import ActiveRow, RowName
from mrts.program.motion_rows import binds
from mrts.studies.variant_numbers import LIMITS, VariantNumbers


class VariantLimits:
    """The rows of one cell, and the sides and values that variants of it have.

    Args:
        cell: The cell, unvaried.
        motion: Any motion of it.
        reserve: Share of every limit that variants keep free.

    Attributes:
        rows: Those that programs take: all but those of velocities.
        sparse: The same as C reads them.
    """

    def __init__(self, cell: Cell, motion: CoordinatedMotion, reserve: float) -> None:
        self._cell, self._reserve = cell, reserve
        given = limit_rows(cell.with_reserve(0.0), motion)
        self.rows = given.only(np.array([name.kind != "velocity" for name in given.names], dtype=bool))
        self._speeds = velocity_limits(replace(cell, enforces_velocity_limits=True), motion).names
        self._in_tip = tuple(self._rows_in_tip_axes())
        every = {"torque": torque_limits(cell, motion).names, "wrench": wrench_limits(cell, motion).names}
        self._places = {kind: self._places_of(kind, names) for kind, names in every.items()}
        matrix, turned = self.rows.matrix, self.rows.object_axes
        pattern = matrix != 0
        for places, columns, block in self._in_tip:
            pattern[np.array(places)[:, None], columns] |= np.repeat(np.any(block != 0, axis=2), 3, axis=1)
        self.sparse = SparseLimits(
            matrix=matrix,
            lower=self.rows.lower,
            upper=self.rows.upper,
            group=[name.group for name in self.rows.names],
            base=None if turned is None else turned.base,
            axes=(0, 1, 2) if turned is None else turned.axes,
            pattern=pattern,
        )

    def of(self, numbers: VariantNumbers, geometry: Array) -> dict[str, Array]:
        """The sides "lower" and "upper", "velocity" and "values" of V variants, as `variant_ranges` takes them.

        Args:
            numbers: Of the variants.
            geometry: Likewise, Shape (V or 1, 3 + 24 n + h).
        """
        sides = {"lower": self.rows.lower[None], "upper": self.rows.upper[None]}
        if numbers.any_of(LIMITS):
            sides = {side: np.repeat(limits, numbers.count, axis=0) for side, limits in sides.items()}
            for kind, (rows, places) in self._places.items():
                for side, limits in sides.items():
                    limits[:, rows] = numbers[f"{kind}_{side}"][:, places]
        joints = np.concatenate([robot.velocity_limit for robot in self._cell.robots])
        of_object = numbers["object_velocity"]
        velocity = np.column_stack([np.repeat(joints[None], len(of_object), axis=0), of_object])
        if not self._cell.enforces_velocity_limits:
            velocity = np.full_like(velocity, np.inf)
        if self._reserve:
            sides["lower"], sides["upper"] = self._shrunk(sides["lower"], sides["upper"])
            velocity = (1 - self._reserve) * velocity
        return {**sides, "velocity": velocity, "values": self._values(numbers, geometry)}

    def named(self, codes: Array, lower: Array, upper: Array) -> list[ActiveRow]:
        """Rows at their limits.

        Args:
            codes: 1 + row at an upper, -1 - row at a lower limit.
            lower: Of the variant, Shape (r,).
            upper: Likewise.
        """
        names = self.rows.names
        return [
            ActiveRow(names[code - 1], "upper", float(upper[code - 1]))
            if code > 0
            else ActiveRow(names[-code - 1], "lower", float(lower[-code - 1]))
            for code in codes.tolist()
        ]

    def velocities_at(self, dq: Array, twist: Array, limit: Array) -> list[list[ActiveRow]]:
        """The velocities that bound c² the most, of each variant at a sample of its own.

        Args:
            dq: q', Shape (V, m).
            twist: Of the object, Shape (V, 6).
            limit: As "velocity" of `of`, Shape (V, m + 2).
        """
        of_object = np.sqrt(np.sum(twist.reshape(-1, 2, 3) ** 2, axis=2))
        bound = binds((np.concatenate([np.abs(dq), of_object], axis=1) / limit) ** 2)
        rows: list[list[ActiveRow]] = [[] for _ in range(len(dq))]
        for variant, row in np.argwhere(bound).tolist():
            rows[variant].append(ActiveRow(self._speeds[row], "upper", float(limit[variant, row])))
        return rows

    def _places_of(self, kind: str, every: tuple[RowName, ...]) -> tuple[list[int], list[int]]:
        rows = [row for row, name in enumerate(self.rows.names) if name.kind == kind]
        return rows, [every.index(self.rows.names[row]) for row in rows]

    def _rows_in_tip_axes(self) -> Iterator[tuple[list[int], NDArray[np.intp], Array]]:
        """Of each contact in tip axes: its rows, its columns in object axes, and itself by triples, Shape (r, t, 3)."""
        first = self.rows.torque_matrix.shape[1] + self.rows.wrench_matrix.shape[1]
        places = {name: row for row, name in enumerate(self.rows.names)}
        for robot in self._cell.robots:
            columns = first + np.arange(self.rows.wrench_matrix.shape[1])[self._cell.wrench_slices[robot.name]]
            for contact in robot.contacts:
                if contact.frame == "tip":
                    names = zip(contact.rows, contact.units, strict=True)
                    named = [RowName("contact", robot.name, f"{contact.name} {row}", unit) for row, unit in names]
                    yield [places[name] for name in named], columns, contact.A.reshape(len(named), -1, 3)

    def _values(self, numbers: VariantNumbers, geometry: Array) -> Array:
        """What stands in the rows, Shape (V or 1, e): contacts in tip axes turn with their grasps."""
        if not self._in_tip or "grasp_rpy" not in numbers.varied:
            return self.sparse.values[None]
        V = len(geometry)
        matrix = np.repeat(self.rows.matrix[None], V, axis=0)
        width = len(self._cell.wrench_components)
        for places, columns, block in self._in_tip:
            robot = (columns[0] - self.rows.torque_matrix.shape[1] - self.rows.wrench_matrix.shape[1]) // width
            start = GRAVITY_SIZE + ROBOT_SIZE * robot + ROBOT_SIZE // 2
            rotation = geometry[:, start : start + 9].reshape(V, 1, 3, 3)
            turned = block @ np.swapaxes(rotation, 2, 3)
            matrix[:, np.array(places)[:, None], columns] = turned.reshape(V, len(places), -1)
        row, column = self.sparse.entries
        return np.ascontiguousarray(matrix[:, row, column])

    def _shrunk(self, lower: Array, upper: Array) -> tuple[Array, Array]:
        """As `LimitRows.shrunk`, of many variants, each Shape (V, r)."""
        moved = [
            replace(self.rows, lower=low, upper=high).shrunk(self._reserve)
            for low, high in zip(lower, upper, strict=True)
        ]
        return np.array([rows.lower for rows in moved]), np.array([rows.upper for rows in moved])
