# SPDX-License-Identifier: MIT
"""How a parameter of a study is distributed: over levels, evenly over a range, or normally."""

from dataclasses import dataclass

import numpy as np

from mrts.base.arrays import Array

NEAREST_TO_CERTAIN = 1e-16
"""Least distance of a probability from 0 and 1: a distribution without ends has no number there."""

VALUES_SHOWN = 6
"""Of a list."""


@dataclass(frozen=True)
class Distribution:
    """The values of a parameter.

    Attributes:
        kind: "values" and "steps" (of a range) are levels, one as likely as another; "uniform"; "normal", of numbers
            that happen and are not for a designer to choose.
        numbers: The levels, in the order in which a grid takes them; least and largest value; mean and standard
            deviation.
    """

    kind: str
    numbers: tuple[float, ...]

    @property
    def levels(self) -> tuple[float, ...] | None:
        """The values where they can be counted; None where they cannot."""
        return self.numbers if self.kind in {"values", "steps"} else None

    def at(self, probability: Array) -> Array:
        """The values that probabilities from 0 to 1 stand for, of the same Shape."""
        if self.levels is not None:
            places = (probability * len(self.levels)).astype(np.intp)
            return np.array(self.levels)[np.minimum(places, len(self.levels) - 1)]
        first, second = self.numbers
        if self.kind == "uniform":
            return first + probability * (second - first)
        from scipy.special import ndtri  # noqa: PLC0415 (slow to import, and most studies have no such number)

        quantile: Array = ndtri(np.clip(probability, NEAREST_TO_CERTAIN, 1 - NEAREST_TO_CERTAIN))
        return first + second * quantile

    def text(self, unit: str) -> str:
        """The distribution for people, with the unit of its values, which may be empty."""
        spaced, shown = unit and f" {unit}", [f"{number:g}" for number in self.numbers]
        if self.kind == "steps":
            return f"from {shown[0]} to {shown[-1]}{spaced} in {len(shown)} steps"
        if self.kind == "values":
            more = f", … ({len(shown)} values)" if len(shown) > VALUES_SHOWN else ""
            return f"{', '.join(shown[:VALUES_SHOWN])}{more}{spaced}"
        if self.kind == "normal":
            return f"normal, around {shown[0]}, standard deviation {shown[1]}{spaced}"
        return f"from {shown[0]} to {shown[1]}{spaced}"
