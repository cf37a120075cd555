# SPDX-License-Identifier: MIT
"""What a study found, as the columns that pictures and words need."""

import re
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from mrts.base.arrays import Array
from mrts.base.errors import InputError
from mrts.plots.labels import limit_label
from mrts.program.range_status import RangeStatus
from mrts.studies.distributions import CHANCES
from mrts.studies.ranking import fastest_first
from mrts.studies.study_folder import read_study_folder
from mrts.studies.variant_rows import FAILED, INVALID, UNREACHABLE

if TYPE_CHECKING:
    import pyarrow as pa

Index = NDArray[np.int_]

OUTCOMES = {
    RangeStatus.FEASIBLE.value: "some speed keeps all limits",
    RangeStatus.UNBOUNDED.value: "no limit depends on the speed",
    RangeStatus.INFEASIBLE.value: "at some moment no speed keeps all limits",
    RangeStatus.EMPTY.value: "no one speed suits all moments",
    UNREACHABLE: "the arms cannot follow the object",
    INVALID: "the numbers break a rule",
    FAILED: "a solver stopped",
}
"""What may become of a variant, and what it means."""

MOMENT = re.compile(r" at t = \S+ s(?: with .*)?$")
"""When a limit binds and with which load, after its name."""

BETWEEN_LIMITS = re.compile(r", (?![^()]*\))")
"""Between the limits that bind together, not within the value of one."""

LIMIT = re.compile(r"(.*?)(?: torque| contact wrench)? \((?:(upper|lower)(?:, )?)?[^()]*\)")
"""Name, side and value of a limit; a speed has no side, and the value may be what varies."""

USED = re.compile(r": \S+ 100 % used$")
"""What stands behind the name of a hand's limit."""

NUMBER = re.compile(r"(?<![\w/.])[-+−]?\d+(?:\.\d+)?(?:e[-+]?\d+)?(?![\w/])")
"""Reasons that differ by such only are alike."""


READ = ("variant", "status", "reason", "upper_limit", "c2_upper", "duration")
"""Columns that are read beside those of what varies."""


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
        by_chance: Whether it has a distribution, so that it is not for a designer to choose.
    """

    path: str
    unit: str
    by_chance: bool = False

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
        limit: What binds at c²⁺, several limits with ", " between them: `left/elbow ↑, left/fx ↓`.
        c2: c²⁺, NaN where there is none, Shape (V,).
        duration: Of the fastest motion, NaN where there is none, Shape (V,) [s].
        asked: What was asked of each variant, in words.
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
    asked: Mapping[str, str]

    @property
    def variants(self) -> int:
        """How many are solved."""
        return len(self.variant)

    @cached_property
    def admitted(self) -> NDArray[np.bool_]:
        """Which variants may be played at some speed, Shape (V,)."""
        playable = [status.value for status in RangeStatus if status.admits_motion]
        return np.isin(self.outcome.codes, [self.outcome.names.index(name) for name in playable])

    @cached_property
    def ranked(self) -> Index:
        """Rows of the variants that have a duration, the shortest first; of equals, that with the lower number."""
        return fastest_first(self.variant, np.where(self.admitted, self.duration, np.nan))

    def limits(self, row: int) -> list[str]:
        """The limits that bind at c²⁺ of a variant; none where nothing does."""
        code = self.limit.codes[row]
        return self.limit.names[code].split(", ") if code >= 0 else []

    def limit_counts(self, rows: NDArray[np.bool_]) -> list[tuple[str, int]]:
        """Which limit binds how often, the most frequent first; several may bind at a variant.

        Args:
            rows: Which variants count, Shape (V,).
        """
        counts: Counter[str] = Counter()
        for code, count in self.limit.counts(rows):
            counts.update(dict.fromkeys(self.limit.names[code].split(", "), count))
        return counts.most_common()

    def reasons(self) -> list[tuple[str, str, int]]:
        """Outcome, reason and number of the variants without a speed, the most frequent first.

        Reasons that differ by numbers only are counted together, under the first of them.
        """
        counts: Counter[tuple[str, str]] = Counter()
        examples: dict[tuple[str, str], str] = {}
        kinds, without = len(self.reason.names) + 1, ~self.admitted
        pairs = self.outcome.codes[without] * kinds + self.reason.codes[without] + 1
        for pair, count in zip(*np.unique(pairs, return_counts=True), strict=True):
            outcome, code = divmod(int(pair), kinds)
            text = self.reason.names[code - 1] if code else ""
            key = (self.outcome.names[outcome], NUMBER.sub("…", text))
            counts[key] += int(count)
            examples.setdefault(key, text)
        return [(key[0], examples[key], count) for key, count in counts.most_common()]


def read_study_table(folder: Path) -> StudyTable:
    """What a sweep has found so far.

    Raises:
        InputError: If it holds no study, or none of its variants is solved.
    """
    opened = read_study_folder(folder)
    study = opened.record["study"]
    knobs = [Knob(each["path"], each["unit"], each["kind"] in CHANCES) for each in study["vary"]]
    found = opened.table([*READ, *(knob.path for knob in knobs)])
    if not found.num_rows:
        raise InputError(folder, "no variant of this study is solved yet: let mrts sweep go on.")
    asked = {
        "study file": study["file"],
        "varied": "; ".join(each["text"] for each in study["vary"]),
        "points": study["sample"] + ("" if study["sample"] == "grid" else f", seed {study['seed']}"),
        **{name: str(value) for name, value in study["question"].items() if value not in {None, False}},
    }
    return study_table(found, study["cell"]["name"], knobs, opened.variants, asked)


def study_table(
    found: "pa.Table", name: str, knobs: Sequence[Knob], planned: int, asked: Mapping[str, str] = MappingProxyType({})
) -> StudyTable:
    """Take from a study's table what pictures need.

    Args:
        found: One row a variant, with the columns of a study.
        name: Of the study.
        knobs: What was varied, each the name of a column.
        planned: Number of variants of the whole study.
        asked: What was asked of each variant, in words.

    Raises:
        InputError: If a variant has no status that mrts gives.
    """
    columns = [_numbers(found, knob.path) for knob in knobs]
    outcome = _labels(found, "status")
    strange = set(outcome.names) - set(OUTCOMES)
    if strange or np.any(outcome.codes < 0):
        rule = f"is damaged: every variant has one of {', '.join(OUTCOMES)}."
        raise InputError(name, rule, key="status", value=min(strange, default=None))
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
        limit=_short_limits(_labels(found, "upper_limit")),
        c2=_numbers(found, "c2_upper"),
        duration=_numbers(found, "duration"),
        asked=asked,
    )


def _numbers(found: "pa.Table", name: str) -> Array:
    """A column, NaN for what is missing."""
    return np.asarray(found[name].to_numpy(), dtype=np.float64)


def _labels(found: "pa.Table", name: str) -> Labels:
    coded = found[name].combine_chunks().dictionary_encode()
    codes = np.asarray(coded.indices.fill_null(-1).to_numpy(zero_copy_only=False), dtype=int)
    return Labels(tuple(coded.dictionary.to_pylist()), codes)


def _short_limits(limit: Labels) -> Labels:
    """The names of limits alone; texts that then are alike become one."""
    names = [", ".join(dict.fromkeys(map(_short, BETWEEN_LIMITS.split(MOMENT.sub("", name))))) for name in limit.names]
    merged = {name: code for code, name in enumerate(dict.fromkeys(names))}
    codes = np.array([*(merged[name] for name in names), -1], dtype=int)
    return Labels(tuple(merged), codes[limit.codes])


def _short(limit: str) -> str:
    found = LIMIT.fullmatch(limit)
    return USED.sub("", limit) if found is None else limit_label(found[1], found[2] or "upper")
