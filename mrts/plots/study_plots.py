# SPDX-License-Identifier: MIT
"""What a study found: its columns, in words how many variants may be played and the best, and plots of durations."""

import re
from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from math import isqrt
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from mrts.base.arrays import Array
from mrts.base.colours import COLOURS
from mrts.base.errors import InputError
from mrts.base.words import first_names
from mrts.limits.rows import MOST_NAMES
from mrts.plots.plot import Axis, Item, Line, Panel, Plot, Points, level
from mrts.program.sample_ranges import RangeStatus
from mrts.studies.study_folder import read_study_folder
from mrts.studies.variants import FAILED, INVALID, LIMIT_SEPARATOR, UNREACHABLE

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

PLAYABLE = [status.value for status in RangeStatus if status.admits_motion]

NUMBER = re.compile(r"(?<![\w/.])[-+−]?\d+(?:\.\d+)?(?:e[-+]?\d+)?(?![\w/])")
"""Reasons that differ by such only are alike."""

READ = ("variant", "status", "reason", "upper_limit", "c2_upper", "duration")
"""Columns that are read beside those of what varies."""


SHARES = (50, 90, 95, 99)
"""Of the variants, of which the duration is told within which they finish [%]."""


SAME = 0.01
"""Share of a duration by which an axis of durations that are all alike is wide."""

MOST_VALUES = 120
"""Different values of a number that are drawn one by one; of more, neighbours share a point."""


@dataclass(frozen=True, eq=False)
class StudyTable:
    """The variants of a study that are solved: V of them, each with P numbers of its own.

    Attributes:
        name: Of the study.
        titles: What was varied, P of them: column and unit, by column.
        planned: How many variants the study has.
        rows: `pandas.DataFrame` with the columns `READ` and those of what varies; texts are categories.
        asked: What was asked of each variant, in words.
    """

    name: str
    titles: Mapping[str, str]
    planned: int
    rows: Any
    asked: Mapping[str, str] = field(default_factory=dict)

    @property
    def variants(self) -> int:
        """How many are solved."""
        return len(self.rows)

    @cached_property
    def values(self) -> Array:
        """Numbers of the variants, Shape (V, P)."""
        return np.asarray(self.rows[[*self.titles]].to_numpy(), dtype=np.float64)

    @cached_property
    def duration(self) -> Array:
        """Of the fastest motion, NaN where there is none, Shape (V,) [s]."""
        return np.asarray(self.rows["duration"].to_numpy(), dtype=np.float64)

    @cached_property
    def c2(self) -> Array:
        """c²⁺, NaN where there is none, Shape (V,)."""
        return np.asarray(self.rows["c2_upper"].to_numpy(), dtype=np.float64)

    @cached_property
    def admitted(self) -> NDArray[np.bool_]:
        """Which variants may be played at some speed, Shape (V,)."""
        return np.asarray(self.rows["status"].isin(PLAYABLE))

    @cached_property
    def ranked(self) -> Index:
        """Rows of the variants that have a duration, the shortest first; of equals, that with the lower number."""
        rows, variant = np.flatnonzero(self.admitted & np.isfinite(self.duration)), self.rows["variant"].to_numpy()
        return rows[np.lexsort((variant[rows], self.duration[rows]))]

    def limits(self, row: int) -> list[str]:
        """The limits that bind at c²⁺ of a variant; none where nothing does."""
        names = self.rows["upper_limit"].iloc[row]
        return names.split(LIMIT_SEPARATOR) if isinstance(names, str) else []

    def limit_counts(self, rows: NDArray[np.bool_]) -> list[tuple[str, int]]:
        """Which limit binds how often at some variants, Shape (V,), the most frequent first; several may at one."""
        counts: Counter[str] = Counter()
        for names, count in self.rows["upper_limit"][rows].value_counts(sort=False).items():
            counts.update(dict.fromkeys(names.split(LIMIT_SEPARATOR), count))
        return [(name, count) for name, count in counts.most_common() if count]

    def outcome_counts(self, rows: NDArray[np.bool_]) -> list[tuple[str, int]]:
        """How many of some variants, Shape (V,), have each outcome, the most frequent first."""
        counts = Counter(dict(self.rows["status"][rows].value_counts(sort=False)))
        return [(name, int(count)) for name, count in counts.most_common() if count]

    def reasons(self) -> list[tuple[str, str, int]]:
        """Outcome, reason and number of the variants without a speed, the most frequent first.

        Reasons that differ by numbers only are counted together, under the first of them.
        """
        counts: Counter[tuple[str, str]] = Counter()
        examples: dict[tuple[str, str], str] = {}
        lost = self.rows.loc[~self.admitted, ["status", "reason"]].astype(object).fillna("")
        for (outcome, text), count in lost.value_counts(sort=False).items():
            key = (outcome, NUMBER.sub("…", text))
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
    paths = {each["path"]: each["unit"] for each in study["vary"]}
    titles = {path: f"{path} [{unit}]" if unit else path for path, unit in paths.items()}
    found = opened.table([*READ, *titles])
    if not found.num_rows:
        raise InputError(folder, "no variant of this study is solved yet: let mrts sweep go on.")
    asked = {
        "study file": study["file"],
        "varied": "; ".join(each["text"] for each in study["vary"]),
        "points": study["sample"] + ("" if study["sample"] == "grid" else f", seed {study['seed']}"),
        **{name: str(value) for name, value in study["question"].items() if value not in {None, False}},
    }
    return study_table(found, study["cell"]["name"], titles, opened.variants, asked)


def study_table(
    found: "pa.Table", name: str, titles: Mapping[str, str], planned: int, asked: Mapping[str, str] | None = None
) -> StudyTable:
    """The variants of a study from its columns `READ` and those of what varies, a row each.

    Raises:
        InputError: If a variant has no status that mrts gives.
    """
    rows = found.to_pandas(strings_to_categorical=True)
    status = rows["status"].cat.categories
    strange = set(status) - set(OUTCOMES)
    if strange or rows["status"].hasnans:
        rule = f"is damaged: every variant has one of {', '.join(OUTCOMES)}."
        raise InputError(name, rule, key="status", value=min(strange, default=None))
    rows["status"] = rows["status"].cat.set_categories(list(OUTCOMES))
    return StudyTable(name, titles, planned, rows, asked or {})


def outcome_text(table: StudyTable) -> str:
    """How many variants may be played, and what became of the others."""
    count, playable = table.variants, int(np.sum(table.admitted))
    of_all = "" if table.variants == table.planned else f" solved so far, of {table.planned}"
    text = f"{playable} of {count} variants{of_all} may be played ({percent(playable, count)})"
    others = ", ".join(f"{number} {name}" for name, number in table.outcome_counts(~table.admitted))
    return f"{text}; {others}" if others else text


def best_text(table: StudyTable) -> str:
    """The best variant and what limits it; where there is none, so."""
    if not len(table.ranked):
        return "no variant has a shortest duration"
    return f"the best is {variant_text(table, int(table.ranked[0]))}"


def variant_text(table: StudyTable, row: int) -> str:
    """Number, duration, c²⁺ and limits of a variant; a speed that varies may be possible where no constant c² is."""
    parts = [f"variant {table.rows['variant'].iloc[row]}: {table.duration[row]:.4g} s"]
    parts += [f"c² = {table.c2[row]:.4g}"] if np.isfinite(table.c2[row]) else []
    parts += [f"limited by {first_names(limits, MOST_NAMES)}"] if (limits := table.limits(row)) else []
    return ", ".join(parts)


def managed(table: StudyTable, share: int) -> float | None:
    """The duration within which a share [%] of all variants finishes [s]; None if fewer have one at all."""
    needed = -(-share * table.variants // 100)
    return float(table.duration[table.ranked[needed - 1]]) if needed <= len(table.ranked) else None


def managed_texts(table: StudyTable) -> list[str]:
    """Such as "95 % of variants finish within 0.52 s", for some shares; the last says how far they go."""
    texts: list[str] = []
    for share in SHARES:
        duration = managed(table, share)
        if duration is None:
            having = percent(len(table.ranked), table.variants)
            return [*texts, f"no duration suits {share} % of the variants: {having} have one"]
        texts.append(f"{share} % of variants finish within {duration:.4g} s")
    return texts


def percent(count: int, of: int) -> str:
    """A share in per cent, rounded down so that what falls short of all, or of a share, is seen to do so."""
    share = 100 * count / of if of else 0.0
    return f"{share:.2g} %" if 0 < share < 1 else f"{1000 * count // of / 10 if of else 0:g} %"


def numbers_plot(table: StudyTable) -> Plot:
    """The shortest duration over each number; where its values are no grid, the best of neighbours is drawn."""
    panels = [
        _number_panel(table, name, values) for name, values in zip(table.titles.values(), table.values.T, strict=True)
    ]
    rows = [panels[at : at + 2] for at in range(0, len(panels), 2)]
    return Plot(name="numbers", title=_title(table), rows=rows)


def _title(table: StudyTable, *remarks: str) -> str:
    return "\n".join([f"{table.name}: {outcome_text(table)}", best_text(table), *filter(None, remarks)])


def _number_panel(table: StudyTable, name: str, values: Array) -> Panel:
    if not len(table.ranked):
        return Panel(x=Axis(label=name), note="no variant has a duration")
    places, group = np.unique(values, return_inverse=True)
    in_grid = len(places) < table.variants or len(table.titles) == 1
    most = MOST_VALUES if in_grid else min(MOST_VALUES, max(2, isqrt(table.variants)))
    if len(places) > most:
        edges = np.linspace(places[0], places[-1], most + 1)
        places, group = (edges[1:] + edges[:-1]) / 2, np.searchsorted(edges[1:-1], values, "right")
    best = np.full(len(places), -1)
    best[group[table.ranked[::-1]]] = table.ranked[::-1]  # the last one written stays: the best
    texts = [variant_text(table, row) if row >= 0 else "" for row in best.tolist()]
    duration = np.where(best >= 0, table.duration[best], np.nan)
    first = table.ranked[:1]
    items: list[Item] = [
        Line(x=places, y=duration, unit="s", texts=texts),
        Points(x=values[first], y=table.duration[first], symbol="star", color="#fff"),
    ]
    y = Axis(label="duration [s]")
    return Panel(
        title="Shortest duration (star: the best)", x=Axis(label=name, hover=f"{name} = {{}}"), y=y, items=items
    )


def durations_plot(table: StudyTable) -> Plot:
    """Which share of all variants finishes within a duration."""
    title = _title(table, "; ".join(managed_texts(table)) if len(table.ranked) else "")
    if not len(table.ranked):
        return Plot(name="durations", title=title, rows=[[Panel(note="no variant has a duration")]])
    durations = table.duration[table.ranked]
    percent = 100 * np.arange(1, len(durations) + 1) / table.variants
    marks = [(share, end) for share in SHARES if (end := managed(table, share)) is not None]
    share, at = (np.array([mark[part] for mark in marks], dtype=np.float64) for part in (0, 1))
    ends = (float(durations[0]), max(float(durations[-1]), (1 + SAME) * float(durations[0])))
    x = Axis(label="shortest duration [s]", ends=ends, hover="{} s")
    items: list[Item] = [
        Line(x=durations, y=percent, label="finish within this duration", unit="%", steps=True),
        level(float(percent[-1]), x, color=COLOURS[1], dash=1, label="can be played at all"),
        Points(x=at, y=share),
    ]
    panel = Panel(x=x, y=Axis(label="share of all variants [%]", ends=(0.0, 104.0)), items=items)
    return Plot(name="durations", title=title, rows=[[panel]])
