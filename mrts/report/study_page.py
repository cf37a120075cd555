# SPDX-License-Identifier: MIT
"""The page of a study: what was varied, what became of the variants, the best, and what limits them."""

import numpy as np

from mrts.base.arrays import Array
from mrts.base.words import first_names
from mrts.limits.rows import MOST_NAMES
from mrts.plots import study_table as words
from mrts.plots.study_plots import durations_plot, numbers_plot
from mrts.plots.study_table import OUTCOMES, StudyTable, best_part, percent
from mrts.report.document import document
from mrts.report.tables import Entry, Styled, Table, bar, more

MOST_BEST = 10
"""Rows of the table of the best variants."""

OUTERMOST = 0.02
"""Share of a number's range, at either end, in which a value counts as at the end."""

MOST_REASONS = 12
MOST_LIMITS = 15
"""Rows of the tables of reasons and limits; the rest is counted."""


def study_html(found: StudyTable) -> str:
    """The report of what a sweep has found so far as text."""
    return document(
        "study.html",
        f"{found.name}: {found.variants} variants",
        {},
        study=found,
        words=words,
        best_table=_best_table,
        durations_plot=durations_plot,
        limits_table=_limits_table,
        numbers_plot=numbers_plot,
        outcomes_table=_outcomes_table,
        reasons_table=_reasons_table,
    )


def _best_table(found: StudyTable) -> Table:
    """The best variants below what was tried; no line of a limit breaks before its arrow."""
    head = ("variant", "duration [s]", "c²⁺ [1]", *(knob.title for knob in found.knobs), "limited by")
    tried = [found.duration[found.ranked], found.c2[found.ranked], *found.values.T]
    rows: list[tuple[Entry, ...]] = [("from … to", *map(_span, tried), "")]
    low, high = (end(found.values, axis=0) for end in (np.min, np.max))
    chosen = np.array([not knob.by_chance for knob in found.knobs]) & (high > low)
    near = np.minimum(found.values - low, high - found.values) <= OUTERMOST * (high - low)
    for row in found.ranked[:MOST_BEST].tolist():
        marks = (" (end)" if at_end else "" for at_end in chosen & near[row])
        values = [f"{value:.4g}{mark}" for value, mark in zip(found.values[row].tolist(), marks, strict=True)]
        c2 = f"{found.c2[row]:.4g}" if np.isfinite(found.c2[row]) else ""
        limits = first_names(found.limits(row), MOST_NAMES).split(", ")
        number, duration = str(found.rows["variant"].iloc[row]), f"{found.duration[row]:.4g}"
        rows.append((number, duration, c2, *values, tuple(Styled(limit, "whole") for limit in limits)))
    return Table(head, rows)


def _span(values: Array) -> str:
    """Its ends to a thousandth of it: what is next to 0 beside the other end is 0."""
    values = values[np.isfinite(values)]
    if not len(values):
        return ""
    low, high = float(np.min(values)), float(np.max(values))
    digits = 3 - int(np.floor(np.log10(high - low))) if high > low else 12
    return f"{round(low, digits) + 0.0:.4g} … {round(high, digits) + 0.0:.4g}"


def _limits_table(found: StudyTable) -> Table:
    best = np.isin(np.arange(found.variants), best_part(found))
    counts, of_best = found.limit_counts(found.admitted), dict(found.limit_counts(best))
    total, total_best = int(np.sum(found.admitted)), max(1, int(np.sum(best)))
    rows = [(name, bar(count / total), bar(of_best.get(name, 0) / total_best)) for name, count in counts[:MOST_LIMITS]]
    head = ("limit at c²⁺", "of all that can be played", "of the best 5 %")
    return Table(head, rows, more(len(counts) - MOST_LIMITS, "limits"))


def _outcomes_table(found: StudyTable) -> Table:
    counts = found.outcome_counts(np.ones(found.variants, dtype=bool))
    rows = [(name, OUTCOMES[name], str(count), percent(count, found.variants)) for name, count in counts]
    return Table(("outcome", "what it means", "variants", "share"), rows)


def _reasons_table(found: StudyTable) -> Table:
    reasons = found.reasons()
    rows = [(outcome, Styled(reason, "prose"), str(count)) for outcome, reason, count in reasons[:MOST_REASONS]]
    head = ("outcome", "reason of the first", "variants alike")
    return Table(head, rows, more(len(reasons) - MOST_REASONS, "reasons"))
