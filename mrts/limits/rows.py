# SPDX-License-Identifier: MIT
"""The canonical form of every limit: named two-sided linear rows, `LimitRows`."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, lru_cache
from itertools import chain, compress
from operator import attrgetter
from typing import Any, Literal, Self

import numpy as np
from numpy.typing import NDArray

from mrts.base.arrays import Array, freeze, with_part
from mrts.base.errors import InputError
from mrts.base.words import first_names
from mrts.cell.cell import KNOWN_CELLS, Cell
from mrts.cell.hands import triple_axes
from mrts.following.coordinated_motion import CoordinatedMotion
from mrts.kernel.binding import INFINITY, filled, structure

FEW = 8
"""Rows of a polygon that are enough to tell its circle."""


def polygons(names: Sequence["RowName"]) -> dict["RowName", list[int]]:
    """Places of the rows of each name whose rows are sides of a polygon."""
    places: dict[RowName, list[int]] = {}
    for place, name in enumerate(names):
        if name.sides:
            places.setdefault(name, []).append(place)
    return places


def few_sides(names: Sequence["RowName"]) -> NDArray[np.bool_]:
    """Rows without those sides of polygons that their circles do not need, Shape (r,)."""
    kept = np.ones(len(names), dtype=bool)
    for own in polygons(names).values():
        if len(own) % FEW == 0:
            kept[own] = np.arange(len(own)) % (len(own) // FEW) == 0
    return kept


def circle(sides: Array, count: int) -> tuple[Array, Array]:
    """√(zᵀ gram z) <= bound z of the circle through the corners of a regular polygon, sides s z <= 0.

    Of `count` sides all are given, or at least three as far from each other as the last from the first, Shape
    (…, some, k); gram has Shape (…, k, k), bound (…, k).
    """
    mean = np.mean(sides, axis=-2)
    across = sides - mean[..., None, :]
    scale = 2 / sides.shape[-2] * np.cos(np.pi / count) ** 2
    gram: Array = scale * np.swapaxes(across, -1, -2) @ across
    return gram, -mean


def in_circles(names: Sequence["RowName"], above: Array, below: Array) -> None:
    """Put what the circle of each polygon is passed by at all its sides, above.

    Rows pass their limits by `above` and `below`, minus infinity where there is none, Shape (…, r).
    """
    for name, own in polygons(names).items():
        sides = np.concatenate([above[..., own], below[..., own]], axis=-1)
        gram, bound = circle(sides[..., np.isfinite(sides[(0,) * (sides.ndim - 1)]), None], name.sides)
        above[..., own], below[..., own] = np.sqrt(gram[..., 0]) - bound, -np.inf


Side = Literal["lower", "upper"]

TORQUE_SPEED = "torque-speed"
"""Kind of the rows that are lines of a motor's curve."""

SPEEDS = {"velocity", "motor speed", "acceleration"}
"""Kinds of rows that limit the motion alone, mostly alike in both directions."""

RATES = {"torque rate", "wrench rate", "jerk"}
"""Kinds of rows that limit how fast something changes."""

COLUMNS = ("rate", "speed", "square", "offset")
"""Attributes of rows with a number for each sample."""

GIVEN = ("lower", "upper", "torque_matrix", "wrench_matrix")
OF_ROWS = (*GIVEN, "object_matrix", "size")
"""Attributes with an entry for each row, which are always given, and all."""

KNOWN_LIMITS = 4 * KNOWN_CELLS
"""So many limits of one kind are kept: circles of accelerations, of which a cell has several, and stacks."""

MOST_NAMES = 3
"""Rows that a short list names."""

FAILURES = {"friction": "slips", "tilt": "tips", "torsion": "twists"}
"""What a hand does at a limit of its contact, by what of the contact is limited."""


@dataclass(frozen=True)
class RowName:
    """What a row limits.

    Attributes:
        kind: "torque", "wrench", "contact", "velocity", "acceleration", "torque-speed" (a line of a motor's curve),
            "motor speed" (its end), "c2" (c² >= 0), "speed" (along the path), "torque rate", "wrench rate" and "jerk"
            where rates are kept, or what a limit of yours bounds.
        robot: Robot's name; "object" for its motion and what it carries; empty for c², and where it is of no robot.
        element: Joint, wrench component, contact and what of it is limited ("pad friction +a"), "linear" or "angular",
            or empty.
        unit: "N m", "N", "rad/s", "m/s", or empty.
        sides: Of the regular polygon in a circle whose sides the rows of this name are, two of a row with two limits; 0
            for a row of its own, as all of a limit of yours are.
    """

    kind: str
    robot: str = ""
    element: str = ""
    unit: str = ""
    sides: int = field(default=0, compare=False)

    def __str__(self) -> str:
        if self.kind == "c2":
            return "c² ≥ 0"
        if self.kind == "speed":
            return f"speed along the path {self.element}"
        if self.kind == "contact":
            return self.short
        what = f"contact {self.kind}" if self.kind.startswith("wrench") else self.kind
        return " ".join(filter(None, ["/".join(filter(None, [self.robot, self.element])), what]))

    def to_json(self) -> dict[str, str | float]:
        """Part of the entries of rows in the JSON result."""
        return {"kind": self.kind, "robot": self.robot, "element": self.element, "unit": self.unit}

    @property
    def short(self) -> str:
        """`left/elbow` for its torque, `left/fx` for that wrench, `left/elbow velocity`; in full without a robot."""
        if not self.robot:
            return str(self)
        spoken = {"torque", "wrench", "contact"}
        return f"{self.robot}/{self.element}" + ("" if self.kind in spoken else f" {self.kind}")

    @cached_property
    def group(self) -> str:
        """Key of the rows whose largest limit is 100 % of a zero limit among them: the unit, of a contact its own."""
        return self.unit if self.kind != "contact" else f"{self.contact} {self.unit}"

    @property
    def failure(self) -> str:
        """`left/pad slips`: what a hand does at this limit of its contact; empty for any other row."""
        parts = self.element.split() if self.kind == "contact" else []
        return f"{self.contact} {FAILURES[parts[1]]}" if len(parts) > 1 and parts[1] in FAILURES else ""

    @property
    def of_load(self) -> bool:
        """Whether what it limits depends on the load."""
        return self.kind not in SPEEDS and self.robot != "object"

    @property
    def rate(self) -> "RowName":
        """How fast it changes."""
        return replace(self, kind=f"{self.kind} rate", unit=f"{self.unit}/s")

    @property
    def contact(self) -> str:
        """`left/pad` for a row of that contact, empty for any other."""
        return f"{self.robot}/{self.element.split()[0]}" if self.kind == "contact" else ""


@lru_cache(maxsize=256)
def row_names(
    kind: str, robot: str, elements: tuple[str, ...], units: tuple[str, ...], per: str = ""
) -> tuple[RowName, ...]:
    """Names of rows of one kind and one robot, in these units `per` another; the same are made once."""
    return tuple(RowName(kind, robot, element, unit + per) for element, unit in zip(elements, units, strict=True))


def joint_rows(cell: Cell, kind: str, units: str, per: str = "") -> tuple[RowName, ...]:
    """Names of rows of one kind, one a joint, in the robots' "torque_units" or "position_units" `per` another."""
    names: tuple[RowName, ...] = ()
    for robot in cell.robots:
        names += row_names(kind, robot.name, robot.joints, getattr(robot, units), per)
    return names


def wrench_rows(cell: Cell, kind: str, per: str = "") -> tuple[RowName, ...]:
    """Names of rows of one kind, one a wrench component."""
    names: tuple[RowName, ...] = ()
    for robot in cell.robots:
        names += row_names(kind, robot.name, cell.wrench_components, cell.wrench_units, per)
    return names


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

    @classmethod
    def of(cls, name: RowName, lower: float, upper: float, *, at_upper: bool) -> Self:
        """A row of two limits at one of them; a speed that is limited alike in both directions is at its upper one."""
        above = at_upper or (name.kind in SPEEDS and lower == -upper)
        return cls(name, "upper" if above else "lower", float(upper if above else lower))

    @property
    def arrow(self) -> str:
        """What a side is shown as; nothing of the motion's own limits, which are alike in both directions."""
        return "" if not self.name.robot or self.name.kind in SPEEDS else " ↑" if self.side == "upper" else " ↓"

    @property
    def label(self) -> str:
        """A few letters: `left/elbow ↑`, `left/elbow velocity`, `left/pad slips`."""
        return self.name.failure or self.name.short + self.arrow

    def __str__(self) -> str:
        if self.name == STANDSTILL or self.name.kind == "speed":
            return str(self.name)
        if self.name.failure:
            return f"{self.name.failure}: {self.name.element.split()[1]} 100 % used"
        line = ", of the line at standstill" if self.name.kind == TORQUE_SPEED else ""
        side = "" if self.name.kind in SPEEDS else f"{self.side}, "
        return f"{self.name} ({side}{f'{self.limit:g} {self.name.unit}'.rstrip()}{line})"

    def to_json(self) -> dict[str, str | float]:
        """Entry of "rows" in the JSON result."""
        return self.name.to_json() | {"side": self.side, "limit": self.limit}


def rows_text(rows: Iterable[ActiveRow], between: str = ", ") -> str:
    """Rows in words; those that say the same, as two directions in which a hand slips, are one."""
    return between.join(dict.fromkeys(map(str, rows)))


def row_labels(rows: Iterable[ActiveRow], most: int = MOST_NAMES) -> str:
    """The first rows in a few letters, and how many more there are."""
    return first_names(list(dict.fromkeys(row.label for row in rows)), most)


def base_axes(cell: Cell) -> tuple[Array, list[int]]:
    """Rotation of each base in the world, Shape (n, 3, 3), and the axes that are its columns.

    A spatial wrench has two triples, forces and moments along x, y, z (0, 1, 2), a planar one a single triple of two
    forces and a moment.
    """
    axes = list(triple_axes(cell.wrench_components))
    return np.array([robot.T_world_base.R[:, axes] for robot in cell.robots]), axes


def object_axes(cell: Cell, motion: CoordinatedMotion) -> Array:
    """What turns a triple of each arm's wrench from its base axes into the object's, Shape (N, n, 3, 3)."""
    base, axes = base_axes(cell)
    return np.asarray(motion.object.rotation.transpose(0, 2, 1)[:, None, axes] @ base, dtype=np.float64)


def turned(object_axes: Array, wrench: Array) -> Array:
    """All wrenches in object axes, given in base axes, or columns of a matrix that maps to them, Shape (N, n w, …)."""
    count, arms = object_axes.shape[:2]
    triples = wrench.reshape(count, arms, -1, 3, int(np.prod(wrench.shape[2:])))
    found: Array = object_axes[:, :, None] @ triples
    return found.reshape(wrench.shape)


@dataclass(frozen=True, kw_only=True, eq=False)
class RowLimits:
    """What of r rows is the same at every sample, and mostly along any motion of a cell; see `LimitRows`.

    Attributes:
        names: One a row.
        lower: Shape (r,), minus infinity where unbounded.
        upper: Shape (r,), infinity where unbounded.
        torque_matrix: M_τ, Shape (r, m).
        wrench_matrix: M_F, Shape (r, n w).
        object_matrix: M_H, Shape (r, n w); None where no row has such a term.
        base: The cell's `base_axes`; there if M_H is.
        terms: Which rows have a term in each of `COLUMNS`, Shape (4, r).
        size: What 100 % of each limit is, Shape (r,), where its sides do not tell: of limits that a reserve moved.
    """

    names: tuple[RowName, ...]
    lower: Array
    upper: Array
    torque_matrix: Array
    wrench_matrix: Array
    object_matrix: Array | None = None
    base: tuple[Array, list[int]] | None = None
    terms: NDArray[np.bool_]
    size: Array | None = None

    def __post_init__(self) -> None:
        freeze(self)

    @classmethod
    def of(
        cls, cell: Cell, names: Sequence[RowName], lower: Array, upper: Array, columns: Iterable[str] = (), **given: Any
    ) -> Self:
        """Limits of a cell whose rows all have terms in some columns, with zeros for matrices that are not `given`."""
        count, terms = len(names), np.isin(COLUMNS, [*columns])[:, None].repeat(len(names), axis=1)
        given |= {"lower": lower, "upper": upper}
        given = {name: None if value is None else np.array(value) for name, value in given.items()}  # which is frozen
        given.setdefault("torque_matrix", np.zeros((count, len(cell.joint_names))))
        given.setdefault("wrench_matrix", np.zeros((count, len(cell.robots) * len(cell.wrench_components))))
        base = None if given.get("object_matrix") is None else base_axes(cell)
        return cls(names=tuple(names), base=base, terms=terms, **given)

    @cached_property
    def units(self) -> Array:
        """What 100 % of each limit is, Shape (r,): its larger side; for a zero, the largest of its group, or 1."""
        if self.size is not None:
            return self.size
        sides = np.abs(np.array([self.lower, self.upper]))
        size = np.where(np.isfinite(sides), sides, 0.0).max(axis=0)
        zeros = (size == 0).nonzero()[0]
        if zeros.size:
            largest: dict[str, float] = {}
            for name, of_row in zip(self.names, size.tolist(), strict=True):
                largest[name.group] = max(of_row, largest.get(name.group, 0.0))
            size[zeros] = [largest[self.names[row].group] or 1.0 for row in zeros.tolist()]
        return np.asarray(size, dtype=np.float64)

    @cached_property
    def columns(self) -> list[str]:
        """Those of `COLUMNS` in which some row has a term."""
        return [name for name, terms in zip(COLUMNS, self.terms, strict=True) if terms.any()]

    @cached_property
    def is_of_speed(self) -> NDArray[np.bool_]:
        """Rows that nothing but the speed moves, Shape (r,)."""
        rate, _, _, offset = self.terms
        return np.asarray(~(self.matrix.any(axis=1) | rate | offset))

    @cached_property
    def in_squares(self) -> NDArray[np.intp]:
        """Places of the s rows with no term but one of b ṙ and e ṙ², which bound ṙ², Shape (s,)."""
        _, speed, square, _ = self.terms
        return np.flatnonzero(self.is_of_speed & ~(speed & square))

    @cached_property
    def by_speed(self) -> NDArray[np.bool_]:
        """Which rows have no term but b ṙ, Shape (r,)."""
        return np.asarray(self.is_of_speed & self.terms[1] & ~self.terms[2])

    @cached_property
    def squared(self) -> "RowLimits":
        """The same with the rows b ṙ as b |b| ṙ² between l |l| and u |u|, in units of their limits.

        ṙ >= 0, and squares with their sign keep the order. Where the speed is limited alike in both directions that is
        b² ṙ² <= u².
        """
        rows, terms, lower, upper = self.by_speed, self.terms.copy(), self.lower.copy(), self.upper.copy()
        least, most, size = lower[rows], upper[rows], self.units[rows]
        lower[rows] = np.where(least == -most, -np.inf, least * np.abs(least) / size)
        upper[rows] = most * np.abs(most) / size
        terms[1, rows], terms[2, rows] = False, True
        return replace(self, lower=lower, upper=upper, terms=terms)

    @cached_property
    def matrix(self) -> Array:
        """M_τ, M_F and, if there is one, M_H beside each other, Shape (r, m + n w) or (r, m + 2 n w)."""
        blocks = (self.torque_matrix, self.wrench_matrix)
        return np.hstack(blocks if self.object_matrix is None else (*blocks, self.object_matrix))

    @property
    def in_object_axes(self) -> Array:
        """M_H, zeros where there is none, Shape (r, n w)."""
        return np.zeros_like(self.wrench_matrix) if self.object_matrix is None else self.object_matrix

    @property
    def groups(self) -> list[int]:
        """Number of each row's `RowName.group`, from 0."""
        known: dict[str, int] = {}
        return [known.setdefault(name.group, len(known)) for name in self.names]

    def side_sizes(self) -> tuple[Array, Array]:
        """What 100 % of the lower and of the upper side is, each Shape (r,): its own size; of a zero, `units`."""
        return side_size(self.lower, self.units), side_size(self.upper, self.units)

    @cached_property
    def in_c(self) -> Any:
        """The `mrts_limits` of rows.h."""
        row, column = self.matrix.nonzero()
        base, axes = self.base or (None, (0, 1, 2))
        return filled(
            structure("rows.h", "mrts_limits"),
            rows=len(self.names),
            start=np.searchsorted(row, np.arange(len(self.names) + 1)),
            column=column,
            value=self.matrix[row, column],
            lower=np.maximum(self.lower, -INFINITY),
            upper=np.minimum(self.upper, INFINITY),
            group=self.groups,
            base=base,
            axes=axes,
        )

    @cached_property
    def _made(self) -> dict[bytes | float, "RowLimits"]:
        """What `only` and `shrunk` have made of them."""
        return {}

    def only(self, kept: NDArray[np.bool_]) -> "RowLimits":
        """Those of some of the rows."""
        key = kept.tobytes()
        if key not in self._made:
            names = tuple(compress(self.names, kept))
            self._made[key] = with_part(self, OF_ROWS, kept, names=names, terms=self.terms[:, kept])
        return self._made[key]

    def shrunk(self, reserve: float) -> "RowLimits":
        """The same with each side moved inward by a share of its size; where both are one number, it stays.

        Sides that are closer than that cross: such rows admit nothing.
        """
        if reserve not in self._made:
            low, high = self.side_sizes()
            moves = reserve * (self.lower < self.upper)
            lower, upper = self.lower + moves * low, self.upper - moves * high
            self._made[reserve] = replace(self, lower=lower, upper=upper, size=self.units)
        return self._made[reserve]


def _stacked(given: Sequence[RowLimits]) -> RowLimits:
    def joined(name: str) -> Array:
        return np.concatenate([*map(attrgetter(name), given)])

    turned = next((of for of in given if of.object_matrix is not None), None)
    return RowLimits(
        names=tuple(chain.from_iterable(map(attrgetter("names"), given))),
        **{name: joined(name) for name in GIVEN},
        object_matrix=None if turned is None else joined("in_object_axes"),
        base=None if turned is None else turned.base,
        terms=np.concatenate([of.terms for of in given], axis=1),
        size=None if all(of.size is None for of in given) else joined("units"),
    )


_known_stack = lru_cache(maxsize=KNOWN_LIMITS)(_stacked)


@dataclass(frozen=True, kw_only=True)
class LimitRows:
    """r rows lower <= M_τ τ + M_F F + M_H H + a r̈ + b ṙ + e ṙ² + g <= upper of a motion of N samples, played with r(t).

    τ are all torques, Shape (m,), F all wrenches in base axes and H the same wrenches in object axes, Shape (n w,). A
    constant factor c is ṙ = c, r̈ = 0. The columns of the speed, and g, are None where no row has such a term.

    Attributes:
        limits: Their names, limits and matrices.
        object_axes: What turns F into H (`mrts.limits.rows.object_axes`), Shape (N, n, 3, 3); there if M_H is.
        rate: a, Shape (N, r).
        speed: b, Shape (N, r).
        square: e, Shape (N, r).
        offset: g, such as what gravity does to a thing on the object, Shape (N, r).
    """

    limits: RowLimits
    object_axes: Array | None = None
    rate: Array | None = None
    speed: Array | None = None
    square: Array | None = None
    offset: Array | None = None

    @classmethod
    def of(cls, cell: Cell, names: Sequence[RowName], lower: Array, upper: Array, **terms: Any) -> Self:
        """Rows of a cell, with zeros for the matrices that are not given; `terms` are these, and attributes as here."""
        own = {name: terms.pop(name, None) for name in (*COLUMNS, "object_axes")}
        columns = [name for name, column in own.items() if column is not None]
        return cls(limits=RowLimits.of(cell, names, lower, upper, columns, **terms), **own)

    @property
    def names(self) -> tuple[RowName, ...]:
        """One a row."""
        return self.limits.names

    def value(self, torque: Array, wrench: Array, rate: Array | float, speed: Array | float) -> Array:
        """What each row is of its quantity at all samples, Shape (N, r), of τ, Shape (N, m), and F, (N, n w).

        r̈ and ṙ are one for all samples, or Shape (N,).
        """
        value: Array = torque @ self.limits.torque_matrix.T + wrench @ self.limits.wrench_matrix.T
        if self.limits.object_matrix is not None and self.object_axes is not None:
            value += turned(self.object_axes, wrench) @ self.limits.object_matrix.T
        speeds = np.reshape(np.asarray(speed, dtype=np.float64), (-1, 1))
        rates = np.reshape(np.asarray(rate, dtype=np.float64), (-1, 1))
        for column, factor in ((self.rate, rates), (self.speed, speeds), (self.square, speeds**2)):
            if column is not None:
                value += column * factor
        return value if self.offset is None else value + self.offset

    def share(self, value: Array) -> Array:
        """The share of its limit that each value uses, Shape (N, r): 1 is at the limit, the nearer of both sides."""
        (above, below), (low, high) = self._beyond(value), self.limits.side_sizes()
        return np.asarray(1 + np.maximum(above / high, below / low), dtype=np.float64)

    def excess(self, value: Array) -> Array:
        """How far each value is beyond its limits in `RowLimits.units`, below 0 within them, Shape (N, r)."""
        return np.asarray(np.maximum(*self._beyond(value)) / self.limits.units, dtype=np.float64)

    def _beyond(self, value: Array) -> tuple[Array, Array]:
        """By what each value passes its upper and its lower limit, sides of a polygon their circle."""
        above, below = value - self.limits.upper, self.limits.lower - value
        in_circles(self.names, above, below)
        return above, below

    def at(self, samples: NDArray[np.int_] | slice) -> "LimitRows":
        """The same rows at some samples only."""
        return with_part(self, (*COLUMNS, "object_axes"), samples)

    def only(self, kept: NDArray[np.bool_]) -> "LimitRows":
        """Some of the rows; a column in which they have no term is None."""
        if kept.all():
            return self
        limits, places, columns = self.limits.only(kept), kept.nonzero()[0], dict[str, Array]()
        for name in COLUMNS:
            column = getattr(self, name)
            if column is not None and (name in limits.columns or name not in self.limits.columns):
                columns[name] = column[:, places]
        return LimitRows(limits=limits, object_axes=self.object_axes, **columns)

    @cached_property
    def bounded(self) -> "LimitRows":
        """Only the rows that have a limit on some side."""
        return self.only(np.isfinite(self.limits.lower) | np.isfinite(self.limits.upper))


def side_size(limit: Array, units: Array) -> Array:
    """What 100 % of one side of each row is, Shape (r,): the limit's size, of a zero its unit; 1 without a limit."""
    size = np.where(limit == 0, units, np.abs(limit))
    return np.where(np.isfinite(limit), size, 1.0)


def counted_sizes(lower: Array, upper: Array, units: Array) -> Array:
    """What 100 % of the lower and of the upper side of each row is, as a share of its unit, Shape (2, r).

    It is 0 where both sides are one number: such a row is kept, and of its limit no share is told.
    """
    return np.stack([side_size(lower, units), side_size(upper, units)]) / units * (lower < upper)


def stack_rows(given: Sequence[LimitRows], *, known: bool = True) -> LimitRows:
    """All rows of several limits along one motion, in order; `known` are limits that are asked for again and again."""
    limits = (_known_stack if known else _stacked)(tuple(piece.limits for piece in given))
    axes, start = None, 0
    columns: dict[str, Array] = {}
    for piece in given:
        rows = slice(start, start + len(piece.names))
        for name in COLUMNS:
            part = getattr(piece, name)
            if part is not None:  # row by row in memory: rows without the term cost nothing
                columns.setdefault(name, np.zeros((len(limits.names), len(part))).T)[:, rows] = part
        axes, start = axes if piece.object_axes is None else piece.object_axes, rows.stop
    return LimitRows(limits=limits, object_axes=axes, **columns)


def limit_name(limit: Callable[..., object]) -> str:
    """What a limit is called in messages and files."""
    return str(getattr(limit, "__name__", repr(limit)))


def checked_rows(limit: Callable[..., object], cell: Cell, motion: CoordinatedMotion) -> LimitRows:
    """The rows of a limit as they are, with terms where there are numbers.

    Raises:
        InputError: If they are no rows of this cell along this motion: other shapes, no numbers, reversed limits.
    """
    where = f"limit '{limit_name(limit)}'"
    try:
        rows = limit(cell, motion)
    except Exception as error:
        error.add_note(f"(raised by {where})")
        raise
    if not isinstance(rows, LimitRows):
        raise InputError(where, f"must give LimitRows, not {type(rows).__name__}.")
    if not all(isinstance(name, RowName) and not name.sides for name in rows.names):
        raise InputError(where, "must name its rows by RowName, without sides.", key="names")
    count = len(rows.names)
    wrenches = count, len(cell.robots) * len(cell.wrench_components)
    shapes: dict[str, tuple[int, ...]] = {
        **dict.fromkeys(("lower", "upper", "size"), (count,)),
        "torque_matrix": (count, motion.q.shape[1]),
        **dict.fromkeys(("wrench_matrix", "object_matrix"), wrenches),
        **dict.fromkeys(COLUMNS, (motion.samples, count)),
    }
    for key, shape in shapes.items():
        values = getattr(rows.limits if key in OF_ROWS else rows, key)
        if values is None and key in {"object_matrix", "size", *COLUMNS}:
            continue
        if not isinstance(values, np.ndarray) or values.dtype.kind not in "fiu" or values.shape != shape:
            given = f"{type(values).__name__} {getattr(values, 'dtype', '')} {getattr(values, 'shape', '')}".rstrip()
            raise InputError(where, f"must be real numbers of shape {shape} for {count} names; not {given}.", key=key)
        wrong = np.argwhere(np.isnan(values) if key in {"lower", "upper"} else ~np.isfinite(values))
        if len(wrong):
            along_motion = key in COLUMNS
            row, place = wrong[0][-1 if along_motion else 0], f" at sample {wrong[0][0]}" if along_motion else ""
            rule = "must be finite, but for a side without a limit, which is infinite."
            raise InputError(where, f"{rows.names[row]}{place}: {rule}", key=key)
    axes = rows.object_axes
    if rows.limits.object_matrix is not None and (axes is None or not np.array_equal(axes, object_axes(cell, motion))):
        rule = "must be mrts.limits.rows.object_axes(cell, motion) where there is an object_matrix."
        raise InputError(where, rule, key="object_axes")
    lower, upper = rows.limits.lower, rows.limits.upper
    in_order = (lower <= upper) & (lower < np.inf) & (upper > -np.inf)
    if not in_order.all():
        row = int(np.argmin(in_order))
        rule = f"{rows.names[row]}: no number is from {lower[row]:g} to {upper[row]:g}."
        raise InputError(where, rule, key="lower, upper")
    columns = [getattr(rows, name) for name in COLUMNS]
    terms = [np.zeros(count, dtype=bool) if column is None else column.any(axis=0) for column in columns]
    return replace(rows, limits=replace(rows.limits, terms=np.array(terms)))
