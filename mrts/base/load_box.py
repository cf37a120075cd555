# SPDX-License-Identifier: MIT
"""Loads that are known only within ranges: the box, its corners, and loads drawn from it."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from itertools import permutations, product
from types import NoneType
from typing import Annotated, Any

import numpy as np

from mrts.base.arrays import Array
from mrts.base.errors import InputError, check_type, did_you_mean, is_number
from mrts.base.formats.record import Finite, Positive, Shape, check_attributes
from mrts.base.input_file import plain
from mrts.base.manifest import LOAD_ENTRIES

FACTORS = ("mass", "ixx", "iyy", "izz")
"""k_m, k_x, k_y, k_z: factors of the nominal mass and of the nominal principal moments."""

FIRST_MOMENTS = ("mx", "my", "mz")
"""Mass times offset of the centre of mass, object axes [kg m]."""

PARAMETERS = (*FACTORS, *FIRST_MOMENTS)
NOMINAL = {name: 1.0 if name in FACTORS else 0.0 for name in PARAMETERS}
UNITS = {name: "kg m" if name in FIRST_MOMENTS else "" for name in PARAMETERS}

EQUAL_MOMENTS = 1e-9
"""Principal moments that differ by less than this share are equal: their axes are then free to choose."""

AXES_TOLERANCE = 1e-9
"""Principal axes this close to the object's axes are the object's axes."""

LARGEST_DRAW = 1_000_000
"""Most loads that are drawn at once: more would fill the memory."""


def _check_ranges(ranges: dict[str, tuple[float, float]]) -> None:
    """Check the ranges of what is uncertain of a load, by parameter: docs/uncertain_load.md."""
    if not ranges:
        raise InputError("", f"needs at least one range, of {', '.join(PARAMETERS)}.")
    for name, (low, high) in ranges.items():
        if problem := _range_problem(name, low, high):
            raise InputError("", problem)


def _range_problem(name: str, low: float, high: float) -> str:
    if name not in PARAMETERS:
        return f"unknown parameter '{name}'{did_you_mean(name, PARAMETERS)} There are {', '.join(PARAMETERS)}."
    nominal = NOMINAL[name]
    what = "a factor of the nominal value" if name in FACTORS else "a difference from the nominal one"
    rules = (
        (low <= high, "the lower value exceeds the upper one"),
        (name != "mass" or low > 0, "factors of the mass must be > 0; an object without mass is none"),
        (name not in FACTORS or low >= 0, "factors of a moment of inertia must be >= 0"),
        (low <= nominal <= high, f"it is {what} and must contain {nominal:g}; change the nominal load or the range"),
    )
    broken = next((rule for holds, rule in rules if not holds), None)
    return f"{name} = [{low:g}, {high:g}]: {broken}." if broken else ""


Variation = Annotated[dict[str, tuple[Finite, Finite]], _check_ranges]
"""Least and largest value by parameter."""


@dataclass(frozen=True)
class LoadPoint:
    """One load of a box.

    Attributes:
        parameters: Values of the parameters that vary.
        load: Load vector, Shape (10,), see `mrts.base.manifest.LOAD_ENTRIES`.
    """

    parameters: Mapping[str, float]
    load: Array

    def __str__(self) -> str:
        mass = float(self.load[0])
        words = [_in_words(name, mass if name == "mass" else value) for name, value in self.parameters.items()]
        return ", ".join(words) or "the nominal load"

    def to_json(self) -> dict[str, Any]:
        """Parameters and load vector by entry."""
        entries = {name: float(value) for name, value in zip(LOAD_ENTRIES, self.load, strict=True)}
        return {"parameters": dict(self.parameters), "load": entries}


@dataclass(frozen=True)
class LoadBox:
    """Every load whose parameters lie in their ranges.

    Factors of moments are about the principal axes; those of an inertia matrix are the ones nearest to the object's.

    Attributes:
        mass: Nominal [kg].
        inertia: Nominal, at the com in object axes, Shape (3, 3) [kg m²].
        ranges: Least and largest value by parameter (`PARAMETERS`); what is left out stays nominal.
        principal_axes: Columns in object axes, Shape (3, 3).
        principal_moments: Shape (3,) [kg m²].
    """

    mass: Positive
    inertia: Annotated[Array, Shape(3, 3, finite=True)]
    ranges: Variation
    principal_axes: Array = field(init=False)
    principal_moments: Array = field(init=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "ranges", plain("ranges", self.ranges))
        check_attributes(self, LoadBox, "load box")
        object.__setattr__(self, "ranges", {name: self.ranges[name] for name in PARAMETERS if name in self.ranges})
        axes = principal_axes(self.inertia)
        object.__setattr__(self, "principal_axes", axes)
        object.__setattr__(self, "principal_moments", np.diag(axes.T @ self.inertia @ axes).copy())

    @property
    def varying(self) -> tuple[str, ...]:
        """Parameters whose range is more than a point."""
        return tuple(name for name, (low, high) in self.ranges.items() if low < high)

    @property
    def axes_are_the_objects(self) -> bool:
        """Whether the principal axes are the object's own."""
        return bool(np.array_equal(self.principal_axes, np.eye(3)))

    def load_at(self, parameters: Mapping[str, float]) -> Array:
        """Eqs. (40), (41): load vector m̄ = k_m m, Ī = K I (and first moments), Shape (10,).

        Args:
            parameters: Values by name; what is left out stays nominal (or at the one value of its range).

        Raises:
            InputError: If a parameter does not vary in this box or its value is outside its range.
        """
        check_type("parameters", parameters, Mapping)
        for name, value in parameters.items():
            if name not in self.ranges:
                known = ", ".join(self.ranges)
                raise InputError("load", f"is not a parameter of this box; those are {known}.", key=name, value=value)
            low, high = self.ranges[name]
            if not is_number(value, low, high):
                what = " of the nominal value" if name in FACTORS else f" {UNITS[name]}"
                rule = f"must be a number in [{low:g}, {high:g}]{what}: {self.description()}."
                raise InputError("load", rule, key=name, value=value)
        return self._load(self._inside() | dict(parameters))

    def nominal_point(self) -> LoadPoint:
        """The load with every parameter nominal, or as near to it as the box goes."""
        values = {name: value for name, value in self._inside().items() if name in self.varying}
        return LoadPoint(values, self.load_at(values))

    def corners(self, varying: tuple[str, ...] | None = None) -> tuple[LoadPoint, ...]:
        """Its corners: the load is affine in each parameter, so their convex hull holds the whole box.

        Args:
            varying: Parameters to vary; None varies all. Others stay nominal.

        Raises:
            InputError: If one is no parameter of this box.
        """
        check_type("varying", varying, tuple, NoneType)
        names = self.varying if varying is None else varying
        for name in names:
            if name not in self.ranges:
                known = ", ".join(self.ranges)
                raise InputError("varying", f"is not a parameter of this box; those are {known}.", value=name)
        corners = (dict(zip(names, ends, strict=True)) for ends in product(*(self.ranges[name] for name in names)))
        return tuple(LoadPoint(corner, self._load(self._inside() | corner)) for corner in corners)

    def draw(self, rng: "np.random.Generator", count: int) -> tuple[LoadPoint, ...]:
        """Random loads of the box, every parameter uniform in its range.

        Args:
            rng: Source of randomness, as `numpy.random.default_rng(seed)`.
            count: How many.

        Raises:
            InputError: If an argument is wrong.
        """
        check_type("rng", rng, np.random.Generator)
        check_type("count", count, int)
        if not 0 <= count <= LARGEST_DRAW:
            raise InputError("count", f"must be from 0 to {LARGEST_DRAW}.", value=count)
        draws = {name: rng.uniform(*self.ranges[name], size=count) for name in self.varying}
        points = []
        for index in range(count):
            parameters = {name: float(values[index]) for name, values in draws.items()}
            points.append(LoadPoint(parameters, self.load_at(parameters)))
        return tuple(points)

    def description(self) -> str:
        """The ranges in words, such as `mass 0.1 … 3 kg, izz × 0.5 … 2`."""
        scale = {"mass": self.mass}
        ends = {
            name: (low * scale.get(name, 1), high * scale.get(name, 1)) for name, (low, high) in self.ranges.items()
        }
        return ", ".join(_in_words(name, *pair) for name, pair in ends.items())

    def _inside(self) -> dict[str, float]:
        limits = {name: self.ranges.get(name, (value, value)) for name, value in NOMINAL.items()}
        return {name: min(max(value, limits[name][0]), limits[name][1]) for name, value in NOMINAL.items()}

    def _load(self, values: Mapping[str, float]) -> Array:
        moments = self.principal_moments * [values[name] for name in FACTORS[1:]]
        inertia = (self.principal_axes * moments) @ self.principal_axes.T
        return load_vector(values["mass"] * self.mass, np.array([values[name] for name in FIRST_MOMENTS]), inertia)


def _in_words(name: str, *values: float) -> str:
    shown = " … ".join(f"{value:.4g}" for value in values)
    if name in FACTORS and name != "mass":
        return f"{name} × {shown}"
    return f"{name} {shown} {UNITS[name] or 'kg'}"


def load_vector(mass: float, first_moment: Array, inertia: Array) -> Array:
    """The load in the layout `LOAD_ENTRIES`, Shape (10,)."""
    off_diagonal = [inertia[0, 1], inertia[0, 2], inertia[1, 2]]
    return np.array([mass, *first_moment, *np.diag(inertia), *off_diagonal], dtype=np.float64)


def principal_axes(inertia: Array) -> Array:
    """The principal axes nearest to the object's axes, columns of a rotation, Shape (3, 3)."""
    moments, vectors = np.linalg.eigh(inertia)
    best = -np.inf
    axes = vectors
    for order in permutations(range(3)):
        candidate = vectors[:, order].copy()
        ordered = moments[list(order)]
        alike = np.abs(ordered[:, None] - ordered) <= EQUAL_MOMENTS * np.max(ordered)
        for group in dict.fromkeys(tuple(np.flatnonzero(row).tolist()) for row in alike):
            # equal moments leave the axes free in their span: take those nearest to the object's axes
            u, _, vt = np.linalg.svd(candidate[:, group].T @ np.eye(3)[:, group])
            candidate[:, group] = candidate[:, group] @ u @ vt
        nearness = float(np.sum(np.abs(np.diag(candidate))))
        if nearness > best + AXES_TOLERANCE:
            best, axes = nearness, candidate
    axes = axes * np.where(np.diag(axes) < 0, -1.0, 1.0)
    if np.linalg.det(axes) < 0:
        axes[:, int(np.argmin(np.abs(np.diag(axes))))] *= -1
    return np.eye(3) if np.max(np.abs(axes - np.eye(3))) < AXES_TOLERANCE else axes
