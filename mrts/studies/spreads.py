# SPDX-License-Identifier: MIT
"""How a number of a study is spread: levels, a range, or a distribution."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from mrts.base.arrays import Array

NEAREST_TO_CERTAIN = 1e-16
"""Least distance of a probability from 0 and 1: a distribution without ends has no number there."""


VALUES_SHOWN = 6
"""Of a list."""

WORDS = {
    "normal": "around {0}, standard deviation {1}{2}",
    "lognormal": "around {0}{2}, standard deviation {1} of the logarithm",
    "triangular": "from {0} to {2}, likeliest {1}{3}",
}
"""What shapes each kind of distribution, its unit last."""


@dataclass(frozen=True)
class Levels:
    """Some values, one as likely as another.

    Attributes:
        values: The values, in the order in which a grid takes them.
        between: Whether they are the steps of a range, for people.
    """

    values: tuple[float, ...]
    between: bool = False

    @property
    def bounds(self) -> tuple[float, float]:
        """Least and largest value."""
        return min(self.values), max(self.values)

    def at(self, probability: Array) -> Array:
        """The values that probabilities from 0 to 1 stand for, of the same Shape."""
        places = (probability * len(self.values)).astype(np.intp)
        return np.array(self.values)[np.minimum(places, len(self.values) - 1)]

    def text(self, unit: str) -> str:
        """The values for people, with their unit, which may be empty."""
        if self.between:
            return f"from {self.values[0]:g} to {self.values[-1]:g}{_spaced(unit)} in {len(self.values)} steps"
        shown = ", ".join(f"{value:g}" for value in self.values[:VALUES_SHOWN])
        more = f", … ({len(self.values)} values)" if len(self.values) > VALUES_SHOWN else ""
        return f"{shown}{more}{_spaced(unit)}"


@dataclass(frozen=True)
class Range:
    """Every value from one to another, one as likely as another.

    Attributes:
        low: Least value.
        high: Largest value.
    """

    low: float
    high: float

    @property
    def bounds(self) -> tuple[float, float]:
        """Least and largest value."""
        return self.low, self.high

    def at(self, probability: Array) -> Array:
        """The values that probabilities from 0 to 1 stand for, of the same Shape."""
        return self.low + probability * (self.high - self.low)

    def text(self, unit: str) -> str:
        """The range for people, with its unit, which may be empty."""
        return f"from {self.low:g} to {self.high:g}{_spaced(unit)}"


@dataclass(frozen=True)
class Distribution:
    """Values of which some are likelier than others.

    Attributes:
        kind: "normal", "lognormal" or "triangular".
        numbers: What shapes it: mean and standard deviation; median and standard deviation of the logarithm; least,
            likeliest and largest value.
    """

    kind: str
    numbers: tuple[float, ...]

    @property
    def bounds(self) -> tuple[float, float] | None:
        """Least and largest value; None where there are none."""
        return (self.numbers[0], self.numbers[2]) if self.kind == "triangular" else None

    def at(self, probability: Array) -> Array:
        """The values that probabilities from 0 to 1 stand for, of the same Shape."""
        uncertain = np.clip(probability, NEAREST_TO_CERTAIN, 1 - NEAREST_TO_CERTAIN)
        return QUANTILES[self.kind](self.numbers, uncertain)

    def text(self, unit: str) -> str:
        """The distribution for people, with the unit of its values, which may be empty."""
        return f"{self.kind}, {WORDS[self.kind].format(*(f'{number:g}' for number in self.numbers), _spaced(unit))}"


Spread = Levels | Range | Distribution


def _spaced(unit: str) -> str:
    return unit and f" {unit}"


def _standard_normal(p: Array) -> Array:
    from scipy.special import ndtri  # noqa: PLC0415 (slow to import, and most studies have no such number)

    return np.asarray(ndtri(p), dtype=np.float64)


def _normal(numbers: tuple[float, ...], p: Array) -> Array:
    mean, deviation = numbers
    return mean + deviation * _standard_normal(p)


def _lognormal(numbers: tuple[float, ...], p: Array) -> Array:
    median, deviation = numbers
    return median * np.exp(deviation * _standard_normal(p))


def _triangular(numbers: tuple[float, ...], p: Array) -> Array:
    low, peak, high = numbers
    width = high - low
    up = low + np.sqrt(p * width * (peak - low))
    down = high - np.sqrt((1 - p) * width * (high - peak))
    return np.where(p * width < peak - low, up, down)


QUANTILES: dict[str, Callable[[tuple[float, ...], Array], Array]] = {
    "normal": _normal,
    "lognormal": _lognormal,
    "triangular": _triangular,
}
"""Value of each kind at a probability."""
