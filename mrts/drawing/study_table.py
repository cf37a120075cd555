# SPDX-License-Identifier: MIT
"""What a study found, as the columns that pictures and words need."""

import re
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from mrts.base.arrays import Array

if TYPE_CHECKING:
    import pyarrow as pa

Index = NDArray[np.int_]

OUTCOMES = {
    "feasible": "some speed keeps all limits",
    "unbounded": "no limit depends on the speed",
    "infeasible": "at some moment no speed keeps all limits",
    "empty": "no one speed suits all moments",
    "unreachable": "the arms cannot follow the object",
    "invalid": "the numbers break a rule",
    "failed": "a solver stopped",
}
"""What may become of a variant, and what it means."""

MOMENT = re.compile(r" at t = \S+ s$")
"""When a limit binds, after its name."""

NUMBER = re.compile(r"(?<![\w/.])[-+−]?\d+(?:\.\d+)?(?:e[-+]?\d+)?(?![\w/])")
"""Reasons that differ by such only are alike."""


@dataclass(frozen=True)
class Labels:
    """A column of few different texts.

    Attributes:
        names: The texts.
        codes: Which of them a variant has, -1 for none, Shape (V,).
    """

    names: tuple[str, ...]
    codes: Index

    def counts(self, rows: NDArray[np.bool_]) -> list[tuple[int, int]]:
        """Codes of the texts that some of the rows have and how many have each, the most frequent first."""
        count = np.bincount(self.codes[rows & (self.codes >= 0)], minlength=len(self.names))
        return [(int(code), int(count[code])) for code in np.argsort(-count, kind="stable") if count[code]]


@dataclass(frozen=True)
class Knob:
    """A number that a study varies.

    Attributes:
        path: Where it stands in the cell or motion file; also the name of its column.
        unit: Empty where it has none.
        bounded: Whether it was tried from an end to another, rather than drawn from a distribution without ends.
    """

    path: str
    unit: str
    bounded: bool = True

    @property
    def title(self) -> str:
        """Path and unit."""
        return f"{self.path} [{self.unit}]" if self.unit else self.path


@dataclass(frozen=True)
class StudyTable:
    """The variants of a study: V of them, each with P numbers of its own.

    Attributes:
        name: Of the study.
        knobs: What was varied, P of them.
        planned: How many variants the study has; V are solved so far.
        variant: Number of each, Shape (V,).
        values: Shape (V, P).
        outcome: What became of each, by the names in `OUTCOMES`.
        reason: Why there is none; without a text where there is nothing to say.
        limit: What binds at c²⁺, without the moment.
        c2: c²⁺, NaN where there is none, Shape (V,).
        duration: Of the fastest motion, NaN where there is none, Shape (V,) [s].
    """

    name: str
    knobs: tuple[Knob, ...]
    planned: int
    variant: Index
    values: Array
    outcome: Labels
    reason: Labels
    limit: Labels
    c2: Array
    duration: Array

    @property
    def variants(self) -> int:
        """How many are solved."""
        return len(self.variant)

    @cached_property
    def admitted(self) -> NDArray[np.bool_]:
        """Which variants may be played at some speed, Shape (V,)."""
        return np.isin(self.outcome.codes, [list(OUTCOMES).index(name) for name in ("feasible", "unbounded")])

    @cached_property
    def ranked(self) -> Index:
        """Rows of the variants that have a duration, the shortest first; of equals, that with the lower number."""
        rows = np.flatnonzero(self.admitted & np.isfinite(self.duration))
        return rows[np.lexsort((self.variant[rows], self.duration[rows]))]

    def reasons(self) -> list[tuple[str, str, int]]:
        """Outcome, reason and number of the variants without a speed, the most frequent first.

        Reasons that differ by numbers only are counted together, under the first of them.
        """
        counts: Counter[tuple[str, str]] = Counter()
        examples: dict[tuple[str, str], str] = {}
        pairs = self.outcome.codes[~self.admitted] * (len(self.reason.names) + 1) + self.reason.codes[~self.admitted] + 1
        for pair, count in zip(*np.unique(pairs, return_counts=True), strict=True):
            outcome, code = divmod(int(pair), len(self.reason.names) + 1)
            text = self.reason.names[code - 1] if code else ""
            key = (self.outcome.names[outcome], NUMBER.sub("…", text))
            counts[key] += int(count)
            examples.setdefault(key, text)
        return [(key[0], examples[key], count) for key, count in counts.most_common()]


def study_table(found: "pa.Table", name: str, knobs: Sequence[Knob], planned: int) -> StudyTable:
    """Take from a study's table what pictures need.

    Args:
        found: One row a variant, with the columns of a study.
        name: Of the study.
        knobs: What was varied, each the name of a column.
        planned: Number of variants of the whole study.
    """
    columns = [_numbers(found, knob.path) for knob in knobs]
    outcome = _labels(found, "status")
    places = np.array([list(OUTCOMES).index(name) for name in outcome.names], dtype=int)
    variant = np.asarray(found["variant"].to_numpy(), dtype=int)
    return StudyTable(
        name=name,
        knobs=tuple(knobs),
        planned=planned,
        variant=variant,
        values=np.stack(columns, axis=1) if columns else np.empty((len(variant), 0)),
        outcome=Labels(tuple(OUTCOMES), places[outcome.codes] if len(places) else outcome.codes),
        reason=_labels(found, "reason"),
        limit=_without_moments(_labels(found, "upper_limit")),
        c2=_numbers(found, "c2_upper"),
        duration=_numbers(found, "duration"),
    )


def _numbers(found: "pa.Table", name: str) -> Array:
    """A column, NaN for what is missing."""
    return np.asarray(found[name].to_numpy(), dtype=np.float64)


def _labels(found: "pa.Table", name: str) -> Labels:
    coded = found[name].combine_chunks().dictionary_encode()
    codes = np.asarray(coded.indices.fill_null(-1).to_numpy(zero_copy_only=False), dtype=int)
    return Labels(tuple(coded.dictionary.to_pylist()), codes)


def _without_moments(limit: Labels) -> Labels:
    names = [MOMENT.sub("", name) for name in limit.names]
    merged = {name: code for code, name in enumerate(dict.fromkeys(names))}
    codes = np.array([*(merged[name] for name in names), -1], dtype=int)
    return Labels(tuple(merged), codes[limit.codes])
