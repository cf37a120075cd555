# SPDX-License-Identifier: MIT
"""The page of a study: what was varied, what became of the variants, the best, and what matters."""

from pathlib import Path

import numpy as np

from mrts.base.argument_types import as_path
from mrts.base.atomic_file import write_text_atomically
from mrts.plots import study_table as words
from mrts.plots.study_plots import durations_plot, map_remark, study_map, study_map_plot, weights
from mrts.plots.study_table import OUTCOMES, StudyTable, best_part, best_rows, percent, read_study_table
from mrts.report.document import document
from mrts.report.tables import Entry, Styled, Table, bar, more

MOST_BEST = 10
"""Rows of the table of the best variants."""

MOST_REASONS = 12
MOST_LIMITS = 15
"""Rows of the tables of reasons and limits; the rest is counted."""


def write_study_report(study: StudyTable | Path | str, path: Path | str) -> None:
    """Write the report of what a sweep has found so far: one HTML file that opens offline.

    Args:
        study: The table, or the folder of the study, as `mrts sweep -o` wrote it.
        path: The file.

    Raises:
        InputError: If there is no study, none of its variants is solved, plotly is not installed, or the file cannot
            be written.
    """
    found = study if isinstance(study, StudyTable) else read_study_table(as_path("study", study))
    write_text_atomically(as_path("path", path), study_html(found))


def study_html(found: StudyTable) -> str:
    """The report of a study as text; the same study gives the same text.

    Raises:
        InputError: If plotly is not installed.
    """
    return document(
        "study.html",
        f"{found.name}: {found.variants} variants",
        {},
        study=found,
        words=words,
        best_table=_best_table,
        durations_plot=durations_plot,
        limits_table=_limits_table,
        map_remark=map_remark(found, study_map(found)),
        study_map_plot=study_map_plot,
        outcomes_table=_outcomes_table,
        reasons_table=_reasons_table,
        weights_table=_weights_table,
    )


def _best_table(found: StudyTable) -> Table:
    """No line of a limit breaks before its arrow."""
    head, best = best_rows(found, MOST_BEST)
    rows: list[tuple[Entry, ...]] = [
        (*values, tuple(Styled(limit, "whole") for limit in limits.split(", "))) for *values, limits in best
    ]
    return Table(head, rows)


def _weights_table(found: StudyTable) -> Table:
    shares = zip(found.knobs, weights(found), strict=True)
    ranked = sorted(shares, key=lambda entry: -float(np.max(entry[1])))
    rows = [(knob.path, bar(float(duration)), bar(float(playable))) for knob, (duration, playable) in ranked]
    return Table(("number", "of how the durations spread", "of whether it can be played"), rows)


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
