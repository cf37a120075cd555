# SPDX-License-Identifier: MIT
"""What a hand can exert on the object: contacts, which are named two-sided rows over its wrench, by their kinds."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from inspect import Parameter, signature
from itertools import product
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np

from mrts.base.arrays import Array
from mrts.base.errors import InputError, joined
from mrts.base.formats.record import (
    Coordinate,
    Finite,
    MadeAgain,
    Record,
    Rule,
    Shape,
    check_attributes,
    checked_fields,
)
from mrts.base.input_file import LARGEST_NUMBER
from mrts.base.manifest import WRENCH_COMPONENTS, WRENCH_UNITS
from mrts.base.rigid_transform import multiply

Frame = Literal["tip", "object", "base"]

SHORTEST_DIRECTION = 1e-9
"""A direction is given by numbers near 1: what is shorter is zero, misprinted."""

OUT_OF_PLANE = 1e-9
"""Largest entry of a rotation or direction that still counts as zero."""


@dataclass(frozen=True, repr=False, eq=False)
class Contact(MadeAgain):
    """r rows lower <= A F <= upper over the wrench F that a hand exerts **on the object** at its contact point.

    The contact point is the tip frame's origin: moments are about it in every frame. Several contacts of one robot
    must all hold for its one wrench. Those of a cell file's kinds are made by `mrts.Cell.with_values`, here row by row.

    Attributes:
        name: Such as "pad", without blanks; each contact of a robot has its own.
        frame: In which axes F is: of the "tip" link, of the "object", or of the robot's "base".
        rows: What each row limits, such as "friction +a".
        units: One a row.
        A: Shape (r, w).
        lower: Minus infinity where unbounded, Shape (r,).
        upper: Infinity where unbounded, Shape (r,). A row whose limit is 0 is measured by the largest limit of the
            contact that has its unit.
        given: The entry of a cell file that says the same, such as {"pad": {…}}; None where there is none.

    Raises:
        InputError: If an array has another shape, holds what is no number, or a row limits nothing.
    """

    name: str
    frame: Frame
    rows: Annotated[tuple[str, ...], Shape("r"), Rule(min_length=1)]
    units: Annotated[tuple[str, ...], Shape("r")]
    A: Annotated[Array, Shape("r", "w", finite=True)]
    lower: Annotated[Array, Shape("r")]
    upper: Annotated[Array, Shape("r")]
    given: Mapping[str, Any] | None = None

    def __post_init__(self) -> None:
        where = f"contact '{self.name}'"
        check_attributes(self, Contact, where)
        if not self.name or self.name != "".join(self.name.split()):
            raise InputError("contact", "its name must be text without blanks.", key="name", value=self.name)
        if len({*self.rows}) < len(self.rows):
            raise InputError(where, "must have names of their own.", key="rows", value=self.rows)
        limited = np.isfinite(self.lower) | np.isfinite(self.upper)
        sound = limited & (self.lower <= self.upper) & (self.lower < np.inf) & (self.upper > -np.inf)
        sound &= np.any(self.A != 0, axis=1) & np.all(np.abs(self.A) <= LARGEST_NUMBER, axis=1)
        if not np.all(sound):
            row = int(np.argmin(sound))
            rule = (
                f"row '{self.rows[row]}' must hold a number beside 0, none above {LARGEST_NUMBER:.0e}, and have "
                "limits, lower <= upper."
            )
            raise InputError(where, rule, key="lower, upper", value=[float(self.lower[row]), float(self.upper[row])])

    def __repr__(self) -> str:
        return f"<Contact '{self.name}': {len(self.rows)} rows in {self.frame} axes>"


def numbered(kinds: Sequence[str]) -> list[str]:
    """Names of a robot's contacts from their kinds: "pad", and a second one "pad2"."""
    before = [list(kinds[:at]).count(kind) for at, kind in enumerate(kinds)]
    return [f"{kind}{count + 1}" if count else kind for kind, count in zip(kinds, before, strict=True)]


def triple_axes(components: Sequence[str]) -> list[int]:
    """The axes that a triple of a wrench belongs to: all three, or of a planar one its forces' and its moment's."""
    return ["xyz".index(component[1]) for component in components[:3]]


def tip_components(components: Sequence[str], R_object_tip: Array) -> tuple[str, ...]:
    """Components of a wrench in tip axes: of a planar one the forces along both tip axes in the plane, and its moment.

    Args:
        components: Of the cell's wrenches.
        R_object_tip: Rotation of the grasp, Shape (3, 3).

    Raises:
        InputError: If a planar cell's tip link has no axis along the plane's normal.
    """
    if len(components) == len(WRENCH_COMPONENTS):
        return tuple(components)
    normal = R_object_tip[triple_axes(components)[2]]
    along = int(np.argmax(np.abs(normal)))
    if np.max(np.abs(np.delete(normal, along))) > OUT_OF_PLANE:
        rule = (
            "is in tip axes, of which one must be normal to the plane of a planar cell. Turn the tip frame in the URDF "
            "and the grasp with it, or give a box in the frame of the object or the base."
        )
        raise InputError("contact", rule)
    first, second = (axis for axis in range(3) if axis != along)
    return f"f{'xyz'[first]}", f"f{'xyz'[second]}", f"n{'xyz'[along]}"


def contact_axes(key: str, direction: Sequence[float], components: Sequence[str]) -> Array:
    """Turns each triple of a wrench from tip into contact axes: (a, b, normal), of a planar one (a, normal, moment).

    a lies along the tip's x axis, or along its y axis where the normal is nearest to x, projected along the normal;
    b = normal × a. In a planar cell a is normal to the normal, in the plane.

    Args:
        key: What the direction is called, for messages.
        direction: The normal in tip axes, a `Direction`.
        components: Of the wrench in tip axes.

    Returns:
        Shape (3, 3).
    """
    n = np.array(direction) / np.linalg.norm(direction)
    if len(components) < len(WRENCH_COMPONENTS):
        first, second, out = triple_axes(components)
        if abs(n[out]) > OUT_OF_PLANE:
            rule = (
                f"must lie in the plane of the planar cell: the tip's {'xyz'[out]} axis is normal to it. Give what "
                "holds out of the plane as a box."
            )
            raise InputError("contact", rule, key=key, value=direction)
        return np.array([[n[second], -n[first], 0.0], [n[first], n[second], 0.0], [0.0, 0.0, 1.0]])
    a = np.eye(3)[1 if np.argmax(np.abs(n)) == 0 else 0]
    a = a - (a @ n) * n
    a /= np.linalg.norm(a)
    return np.array([a, np.cross(n, a), n])


def in_object_axes(rows: Array, R_object_tip: Array, components: Sequence[str]) -> Array:
    """Rows over a wrench in tip axes as rows over it in object axes, Shape (r, w)."""
    in_tip = tip_components(components, R_object_tip)
    turn = R_object_tip[np.ix_(triple_axes(components), triple_axes(in_tip))].T
    return in_tip_axes(rows, turn)


def in_tip_axes(rows: Array, axes: Array) -> Array:
    """Rows over a wrench in contact axes as rows over it in tip axes, Shape (r, w)."""
    return np.hstack([multiply(part, axes) for part in np.split(rows, rows.shape[1] // 3, axis=1)])


def _check_direction(direction: list[float]) -> None:
    if np.linalg.norm(direction) < SHORTEST_DIRECTION:
        raise InputError("", "must not have zero length: it is a direction, such as [0, 0, 1].", value=direction)


Direction = Annotated[list[Coordinate], Rule(min_length=3, max_length=3), _check_direction]
"""Of any length, Shape (3,)."""

Size = Annotated[float, Rule(ge=1e-6, le=LARGEST_NUMBER)]
"""A coefficient of friction, a half width [m] or a force [N]: what is smaller is a misprint, or zero."""

HalfWidths = Annotated[list[Size], Rule(min_length=1, max_length=2)]
"""Of a surface along its axes a and b (`contact_axes`), Shape (2,) [m]; in a plane [a]."""

Side = list[Finite | None] | None
"""One side of the limits of n values, Shape (n,); None is unbounded, a value or the whole side."""

Sides = tuple[float, float]
"""Lower and upper limit of a row."""


class Bounds(Record):
    """Limits of each component or joint, as a cell file has them."""

    lower: Side = None
    upper: Side = None


def one_each(
    where: Path | str,
    key: str,
    given: float | Sequence[float | None],
    names: Sequence[str],
    unbounded: float | None = None,
) -> Array:
    """A number for each name, Shape (n,), a single one for all; null counts as `unbounded`."""
    values = given if isinstance(given, Sequence) else [given] * len(names)
    if len(values) != len(names):
        null = "" if unbounded is None else "; null is unbounded"
        raise InputError(where, f"must have {len(names)} values ({', '.join(names)}){null}.", key=key, value=values)
    return np.array([unbounded if value is None else value for value in values], dtype=np.float64)


def limit_sides(where: Path | str, key: str, lower: Side, upper: Side, names: Sequence[str]) -> tuple[Array, Array]:
    """Lower and upper limits of named values, each Shape (n,), infinite where there is none."""
    least = one_each(where, joined(key, "lower"), -np.inf if lower is None else lower, names, -np.inf)
    return least, one_each(where, joined(key, "upper"), np.inf if upper is None else upper, names, np.inf)


def _box(
    components: Sequence[str],
    *,
    lower: Side = None,
    upper: Side = None,
    frame: Frame = "tip",  # noqa: ARG001 (the components are those of its axes)
) -> dict[str, Any]:
    """Two-sided limits lower <= F <= upper, component by component; those without a limit make no row."""
    least, most = limit_sides("contact", "", lower, upper, components)
    limited = np.flatnonzero(np.isfinite(least) | np.isfinite(most)).tolist()
    if not limited:
        raise InputError("contact", "must limit something: give numbers in lower or upper, or leave the box out.")
    return {
        "rows": tuple(components[place] for place in limited),
        "units": tuple(WRENCH_UNITS[components[place]] for place in limited),
        "A": np.eye(len(components))[limited],
        "lower": least[limited],
        "upper": most[limited],
    }


def _rows(components: Sequence[str], *, A: list[list[Finite]], upper: list[Finite]) -> dict[str, Any]:
    """Rows A F <= upper over the wrench in tip axes.

    A row with the limit 0 is measured by the largest limit among the rows, by 1 if all are 0.
    """
    if len(A) != len(upper) or any(len(row) != len(components) for row in A):
        rule = f"must have {len(upper)} rows, as many as upper has numbers, each of {', '.join(components)}."
        raise InputError("contact", rule, key="A", value=A)
    names = tuple(str(row) for row in range(1, len(A) + 1))
    return {
        "rows": names,
        "units": ("",) * len(names),
        "A": np.array(A),
        "lower": np.full(len(names), -np.inf),
        "upper": np.array(upper),
    }


def _pad(
    components: Sequence[str],
    *,
    friction: Size,
    normal: Direction,
    half_width: HalfWidths,
    force: tuple[Finite, Finite],
    pull: bool = False,  # noqa: ARG001 (whoever knows the object's shape looks at it)
) -> dict[str, Any]:
    """A pad that presses with f_n = normal · f, least <= f_n <= most, and needs no more than that: 17 rows.

    The rows of friction, tilt and torsion are in N: the normal force that lacks, at most 0.
    """
    least, most = force
    if not 0 <= least < most:
        rule = "must be [least, most] normal force in N with 0 <= least < most: a pad presses and cannot pull."
        raise InputError("contact", rule, key="force", value=force)
    rows = _pressed_rows(_pyramid(friction, components), _half_widths(half_width, components))
    return _friction_rows(rows, contact_axes("normal", normal, components), (least, most), (-np.inf, 0.0))


def _suction(
    components: Sequence[str],
    *,
    holding_force: Size,
    friction: Size,
    radius: Size,
    normal: Direction,
    pull: bool = False,  # noqa: ARG001
) -> dict[str, Any]:
    """A cup that the vacuum presses on the object with its holding force, so that f_n >= -holding_force: 17 rows.

    Its lip bears holding_force + f_n, f_n = normal · f, by friction, at the corners of the square inside its circle: so
    what the rows admit a round lip of that radius bears. They are in N: the normal force that it takes, at most the
    holding force.
    """
    in_space = len(components) == len(WRENCH_COMPONENTS)
    rows = _pressed_rows(_pyramid(friction, components), [radius / np.sqrt(2)] * 2 if in_space else [radius])
    axes = contact_axes("normal", normal, components)
    return _friction_rows(rows, axes, (-holding_force, np.inf), (-np.inf, holding_force))


def _gripper(
    components: Sequence[str], *, force: Size, friction: Size, half_width: HalfWidths, axis: Direction
) -> dict[str, Any]:
    """Two pads, one from each side, whose normal forces add up to twice the grip force: 30 rows, in a plane 3.

    What the object pulls along the axis one pad bears more and the other less, as where the jaws are coupled. The pads
    count as lying in one plane at the tip's origin: how far the jaws are open adds no lever. The rows are in N: the sum
    of both normal forces that it takes.
    """
    mu, widths = _pyramid(friction, components), _half_widths(half_width, components)
    rows = _in_plane(mu, *widths) if len(widths) == 1 else _in_space(mu, *widths)
    both = (-2 * force, 2 * force)
    return _friction_rows(rows, contact_axes("axis", axis, components), both, both)


KINDS: dict[str, Callable[..., dict[str, Any]]] = {
    "box": _box,
    "pad": _pad,
    "suction": _suction,
    "gripper": _gripper,
    "rows": _rows,
}
"""By kind of `contact` in a cell file, what makes attributes of `Contact` of its keys and components of a wrench."""


def check_contact(entry: dict[str, dict[str, Any]]) -> None:
    """Check that an entry of `contact` in a cell file names a function of `KINDS` and suits its arguments."""
    if len(entry) != 1 or not {*entry} <= {*KINDS}:
        rule = (
            f"each entry of 'contact' is one of {', '.join(KINDS)}, such as "
            "'- pad: {friction: 0.5, normal: [0, 0, 1], half_width: [0.03, 0.02], force: [0, 100]}'."
        )
        raise InputError("", rule, value=[*entry])
    ((kind, keys),) = entry.items()
    _, *own = signature(KINDS[kind]).parameters.values()
    defaults = {one.name: one.default for one in own if one.default is not Parameter.empty}
    try:
        checked_fields({one.name: one.annotation for one in own}, defaults, keys)
    except InputError as error:
        raise error.inside("", kind) from None


def read_contacts(
    where: Path | str,
    key: str,
    entries: Sequence[Mapping[str, Mapping[str, Any]]],
    components: Sequence[str],
    R_object_tip: Array,
) -> tuple[Contact, ...]:
    """The contacts of one robot by entries of a cell file that keep to `check_contact`."""
    contacts = []
    given = [pair for entry in entries for pair in entry.items()]
    for place, ((kind, keys), name) in enumerate(zip(given, numbered([kind for kind, _ in given]), strict=True)):
        frame = keys.get("frame", "tip")
        try:
            there = tip_components(components, R_object_tip) if frame == "tip" else components
            contacts.append(Contact(name=name, frame=frame, given=entries[place], **KINDS[kind](there, **keys)))
        except InputError as error:
            raise error.inside(where, f"{key}[{place}].{kind}") from None
    return tuple(contacts)


def _pyramid(friction: float, components: Sequence[str]) -> float:
    """Largest tangential over normal force along one contact axis, by itself.

    In space the pyramid is the one inside Coulomb's round cone, friction / √2 along each axis, so that a surface which
    keeps it keeps the cone. In a plane there is one direction, and both are the same.
    """
    return friction / np.sqrt(2) if len(components) == len(WRENCH_COMPONENTS) else friction


def _half_widths(values: list[float], components: Sequence[str]) -> list[float]:
    count = 2 if len(components) == len(WRENCH_COMPONENTS) else 1
    if len(values) != count:
        what = "[a, b], both half widths" if count > 1 else "[a]: in a planar cell the contact is a line"
        raise InputError("contact", f"must be {what}, in m.", key="half_width", value=values)
    return values


def _pressed_rows(mu: float, widths: Sequence[float]) -> dict[str, Array]:
    """The normal force f_n, and of each demand what it needs of that beyond f_n: a surface can exert F if none is > 0.

    Of a rectangle the 16 rows of S. Caron, Q.-C. Pham, Y. Nakamura, "Stability of surface contacts for humanoid
    robots: closed-form formulae of the contact wrench cone for rectangular support areas", IEEE ICRA 2015; of a line in
    a plane 4. They are exactly the wrenches of forces at its corners inside friction pyramids.

    Args:
        mu: Of the pyramid, from `_pyramid`.
        widths: Half widths of the surface.

    Returns:
        By name rows over (f_a, f_b, f_n, m_a, m_b, m_n) or (f_a, f_n, m), Shape (6,) or (3,), in N of normal force.
    """
    found: dict[str, Array] = {}
    if len(widths) == 1:
        (width,), (f_a, f_n, m) = widths, np.eye(3)
        for name, row in (("friction {}a", f_a / mu), ("tilt {}", m / width)):
            found |= {name.format(sign): float(f"{sign}1") * row - f_n for sign in "+-"}
        return {"normal force": f_n, **found}
    X, Y = widths
    f_a, f_b, f_n, m_a, m_b, m_n = np.eye(6)
    for name, row in (("friction", f_a / mu), ("friction", f_b / mu), ("tilt", m_a / Y), ("tilt", m_b / X)):
        axis = "a" if row[0] or row[3] else "b"
        found |= {f"{name} {sign}{axis}": float(f"{sign}1") * row - f_n for sign in "+-"}
    for number, (turn, first, second) in enumerate(product((1, -1), repeat=3), start=1):
        row = turn * m_n + first * (Y * f_a + turn * mu * m_a) + second * (X * f_b + turn * mu * m_b)
        found[f"torsion {number}"] = row / (mu * (X + Y)) - f_n
    return {"normal force": f_n, **found}


def _friction_rows(rows: dict[str, Array], axes: Array, first: Sides, others: Sides) -> dict[str, Any]:
    """Rows in contact axes, the first between sides of its own [N]."""
    lower, upper = np.array([first, *[others] * (len(rows) - 1)], dtype=np.float64).T
    A = in_tip_axes(np.array([*rows.values()]), axes)
    return {"rows": (*rows,), "units": ("N",) * len(rows), "A": A, "lower": lower, "upper": upper}


def _in_plane(mu: float, width: float) -> dict[str, Array]:
    f_a, f_n, m = np.eye(3)
    return {"friction a": f_a / mu, "along the axis": f_n, "tilt": m / width}


def _in_space(mu: float, X: float, Y: float) -> dict[str, Array]:
    """Rows over (f_a, f_b, f_n, m_a, m_b, m_n): the sum of normal forces that each demand takes, of both signs.

    Corner i at (x_i, y_i) carries d_i n along the axis, |d_i| <= s_i, and friction |f_a|, |f_b| <= μ s_i, where the
    s_i >= 0 add up to both normal forces. These rows are the facets of what the corners reach together. Reflection of
    a, of b and of the axis, and friction the other way, turn one facet into others: of each kind one is written down.
    """
    f_a, f_b, f_n, m_a, m_b, m_n = np.eye(6)
    found = {
        "friction a": f_a / mu,
        "friction b": f_b / mu,
        "along the axis": f_n,
        "tilt a": m_a / Y,
        "tilt b": m_b / X,
        "torsion": m_n / (mu * (X + Y)),
    }
    around = Y * f_a / mu + X * f_b / mu + m_n / mu
    kinds = (
        (Y * (f_a / mu + f_n) + m_a + m_n / mu) / (2 * Y + X),
        (X * (f_b / mu + f_n) + m_b + m_n / mu) / (2 * X + Y),
        (around + (X + Y) * f_n + m_a + m_b) / (2 * (X + Y)),
        (around + (X - Y) * f_n - m_a + m_b) / (2 * (X + Y)),
    )
    reflections = np.array([[-1, 1, 1, 1, -1, -1], [1, -1, 1, -1, 1, -1], [1, 1, -1, -1, -1, 1], [-1, -1, 1, 1, 1, -1]])
    for kind in kinds:
        for chosen in product((False, True), repeat=4):
            row = kind * np.prod(reflections[list(chosen)], axis=0)
            if not any(np.array_equal(row, side) or np.array_equal(row, -side) for side in found.values()):
                found[f"combined {len(found) - 5}"] = row
    return found
