# SPDX-License-Identifier: MIT
"""How a parameter of a study is distributed: over levels, evenly over a range, or by chance."""

from dataclasses import dataclass

import numpy as np

from mrts.base.arrays import Array

NEAREST_TO_CERTAIN = 1e-16
"""Least distance of a probability from 0 and 1: a distribution without ends has no number there."""

VALUES_SHOWN = 6
"""Of a list."""

WORDS = {
    "normal": "normal, around {0}, standard deviation {1}{2}",
    "lognormal": "lognormal, around {0}{2}, standard deviation {1} of the logarithm",
    "triangular": "triangular, from {0} to {2}, likeliest {1}{3}",
    "uniform": "from {0} to {1}{2}",
}
"""What shapes each kind of distribution, its unit last."""


CHANCES = ("normal", "lognormal", "triangular")
"""Kinds of numbers that happen, and are not for a designer to choose."""


@dataclass(frozen=True)
class Distribution:
    """The values of a parameter.

    Attributes:
        kind: "values" and "steps" (of a range) are levels, one as likely as another; "uniform", "normal", "lognormal",
            "triangular".
        numbers: The levels, in the order in which a grid takes them; least and largest value; mean and standard
            deviation; median and standard deviation of the logarithm; least, likeliest and largest value.
    """

    kind: str
    numbers: tuple[float, ...]

    @property
    def levels(self) -> tuple[float, ...] | None:
        """The values where they can be counted; None where they cannot."""
        return self.numbers if self.kind in {"values", "steps"} else None

    @property
    def bounds(self) -> tuple[float, float] | None:
        """Least and largest value; None where there are none."""
        return None if self.kind in {"normal", "lognormal"} else (min(self.numbers), max(self.numbers))

    def at(self, probability: Array) -> Array:
        """The values that probabilities from 0 to 1 stand for, of the same Shape."""
        if self.levels is not None:
            places = (probability * len(self.levels)).astype(np.intp)
            return np.array(self.levels)[np.minimum(places, len(self.levels) - 1)]
        if self.kind == "uniform":
            low, high = self.numbers
            return low + probability * (high - low)
        from scipy import stats  # noqa: PLC0415 (slow to import, and most studies have no such number)

        p = np.clip(probability, NEAREST_TO_CERTAIN, 1 - NEAREST_TO_CERTAIN)
        match self.numbers:
            case low, peak, high:
                found = stats.triang.ppf(p, (peak - low) / (high - low), low, high - low)
            case mean, std if self.kind == "normal":
                found = stats.norm.ppf(p, mean, std)
            case median, log_std:
                found = stats.lognorm.ppf(p, log_std, scale=median)
        return np.asarray(found, dtype=np.float64)

    def text(self, unit: str) -> str:
        """The distribution for people, with the unit of its values, which may be empty."""
        spaced, shown = unit and f" {unit}", [f"{number:g}" for number in self.numbers]
        if self.kind == "steps":
            return f"from {shown[0]} to {shown[-1]}{spaced} in {len(shown)} steps"
        if self.kind == "values":
            more = f", … ({len(shown)} values)" if len(shown) > VALUES_SHOWN else ""
            return f"{', '.join(shown[:VALUES_SHOWN])}{more}{spaced}"
        return WORDS[self.kind].format(*shown, spaced)
