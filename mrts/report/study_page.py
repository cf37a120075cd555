# SPDX-License-Identifier: MIT
"""The page of a study: what was varied, what became of the variants, the best, and what limits them."""

import numpy as np

from mrts.base.words import first_names
from mrts.limits.rows import MOST_NAMES
from mrts.plots import study_plots as words
from mrts.plots.study_plots import OUTCOMES, StudyTable, durations_plot, numbers_plot, percent
from mrts.report.document import document
from mrts.report.tables import Entry, Styled, Table, bar

MOST_BEST = 10
"""Rows of the table of the best variants."""


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
    """The best variants; no line of a limit breaks before its arrow."""
    head = ("variant", "duration [s]", "c²⁺ [1]", *found.titles.values(), "limited by")
    rows: list[tuple[Entry, ...]] = []
    for row in found.ranked[:MOST_BEST].tolist():
        c2 = f"{found.c2[row]:.4g}" if np.isfinite(found.c2[row]) else ""
        limits = first_names(found.limits(row), MOST_NAMES).split(", ")
        numbers = (f"{found.duration[row]:.4g}", c2, *(f"{value:.4g}" for value in found.values[row].tolist()))
        rows.append((str(found.rows["variant"].iloc[row]), *numbers, tuple(Styled(limit, "whole") for limit in limits)))
    return Table(head, rows)


def _limits_table(found: StudyTable) -> Table:
    counts, total = found.limit_counts(found.admitted), int(np.sum(found.admitted))
    rows = [(name, bar(count / total)) for name, count in counts]
    return Table(("limit at c²⁺", "of all that can be played"), rows)


def _outcomes_table(found: StudyTable) -> Table:
    counts = found.outcome_counts(np.ones(found.variants, dtype=bool))
    rows = [(name, OUTCOMES[name], str(count), percent(count, found.variants)) for name, count in counts]
    return Table(("outcome", "what it means", "variants", "share"), rows)


def _reasons_table(found: StudyTable) -> Table:
    rows = [(outcome, Styled(reason, "prose"), str(count)) for outcome, reason, count in found.reasons()]
    return Table(("outcome", "reason of the first", "variants alike"), rows)
