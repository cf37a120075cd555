# SPDX-License-Identifier: MIT
"""The page of a study: what was varied, what became of the variants, the best, and what to do next."""

from dataclasses import replace
from pathlib import Path

import numpy as np

from mrts.base.argument_types import as_path
from mrts.base.atomic_file import write_text_atomically
from mrts.plots.plot import one_panel
from mrts.plots.study_map import map_remark, study_map, weights
from mrts.plots.study_plots import durations_plot, parallel_axes, parallel_figure, study_map_plot
from mrts.plots.study_table import OUTCOMES, StudyTable, read_study_table
from mrts.plots.study_words import (
    best_part,
    best_rows,
    best_text,
    managed_texts,
    next_steps,
    outcome_text,
    percent,
    span_texts,
)
from mrts.report.document import Plots, document, place_figure, placed
from mrts.report.markup import Html, bar, element, html, joined, section, table

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

    Args:
        found: The study, with at least one variant.

    Raises:
        InputError: If plotly is not installed.
    """
    plots: Plots = {}
    pieces = _sections(found, plots)
    return document(f"{found.name}: {found.variants} variants", _head(found), pieces, plots)


def _head(found: StudyTable) -> Html:
    status = "feasible" if len(found.ranked) else "infeasible"
    outcome = f"{_sentence(outcome_text(found))} {_sentence(best_text(found))}"
    return joined([element("h1", found.name), element("p", outcome, class_=f"outcome {status}")])


def _sections(found: StudyTable, plots: Plots) -> list[Html]:
    steps = element("ul", joined(element("li", step) for step in next_steps(found)))
    pieces: list[Html] = [section("next", "What to do next", steps)]
    if len(found.ranked):
        head, best = best_rows(found, MOST_BEST)
        rows = [[*values, _limit_lines(limits)] for *values, limits in best]
        note = "(end): at an end of what was tried; further may be better."
        pieces.append(section("best", "The best variants", table(head, rows), element("p", note, class_="note")))
    if found.knobs:
        remark = map_remark(found, study_map(found))
        note = f"{_sentence(remark)} Hover to read a cell.".strip()
        names = ("duration-map", "limit-map") if len(found.knobs) > 1 else ("duration-line",)
        maps = [one_panel(name, of) for name, of in zip(names, study_map_plot(found).rows[0], strict=False)]
        pieces.append(section("map", "Over the numbers", element("p", note, class_="note"), placed(plots, *maps)))
    if len(found.knobs) > 2:  # noqa: PLR2004 (up to two, the map shows all)
        lines = parallel_axes(found)
        note = f"{_sentence(lines.remark(found))} Drag along an axis to filter, drag its name to move it.".strip()
        title = "Orange: the best 5 %; blue: the others; grey: cannot be played"
        whole = element("div", place_figure(plots, "lines", title, parallel_figure(found, lines)), class_="plots")
        shown = element("div", whole, class_="wide", style=f"--axes:{len(lines.knobs) + 1}")
        pieces.append(section("lines", "All numbers at once", element("p", note, class_="note"), shown))
    pieces += [*_weights(found), *_limits(found), _outcomes(found), *_durations(found, plots), _varied(found)]
    return pieces


def _limit_lines(limits: str) -> Html:
    """Limits, a line each; none breaks before its arrow."""
    return Html(html(limits).replace(", ", "<br>").replace(" ↑", "&nbsp;↑").replace(" ↓", "&nbsp;↓"))


def _sentence(text: str) -> str:
    return f"{text[0].upper()}{text[1:]}." if text else ""


def _weights(found: StudyTable) -> list[Html]:
    """How much each number matters; nothing where there is only one."""
    if len(found.knobs) < 2:  # noqa: PLR2004 (nothing to compare)
        return []
    rows = [(found.knobs[each.knob].path, bar(each.duration), bar(each.playable)) for each in weights(found)]
    note = "What each number explains by itself; what numbers do only together is not in it."
    head = ("number", "of how the durations spread", "of whether it can be played")
    return [section("weights", "What matters", table(head, rows), element("p", note, class_="note"))]


def _limits(found: StudyTable) -> list[Html]:
    """Which limit binds how often; nothing where none does."""
    best = np.isin(np.arange(found.variants), best_part(found))
    counts, of_best = found.limit_counts(found.admitted), dict(found.limit_counts(best))
    total, total_best = int(np.sum(found.admitted)), max(1, int(np.sum(best)))
    rows = [(name, bar(count / total), bar(of_best.get(name, 0) / total_best)) for name, count in counts[:MOST_LIMITS]]
    note = "↑ at its upper limit, ↓ at its lower one. Several may bind at once: raising one alone then brings little."
    whole = table(("limit at c²⁺", "of all that can be played", "of the best 5 %"), rows)
    rest = _rest(len(counts) - MOST_LIMITS, "limits")
    return [section("limits", "What limits them", whole, *rest, element("p", note, class_="note"))] if rows else []


def _outcomes(found: StudyTable) -> Html:
    everything = np.ones(found.variants, dtype=bool)
    counts = [
        (found.outcome.names[code], OUTCOMES[found.outcome.names[code]], str(count), percent(count, found.variants))
        for code, count in found.outcome.counts(everything)
    ]
    parts = [table(("outcome", "what it means", "variants", "share"), counts)]
    reasons = found.reasons()
    if reasons:
        rows = [
            (outcome, element("div", reason, class_="prose"), str(count))
            for outcome, reason, count in reasons[:MOST_REASONS]
        ]
        parts += [
            element("h3", "Why not"),
            table(("outcome", "reason of the first", "variants alike"), rows),
            *_rest(len(reasons) - MOST_REASONS, "reasons"),
        ]
    return section("outcomes", "What became of the variants", *parts)


def _durations(found: StudyTable, plots: Plots) -> list[Html]:
    if not len(found.ranked):
        return []
    plot = replace(durations_plot(found), title="Which share of the variants finishes within which duration")
    words = _sentence("; ".join(managed_texts(found)))
    return [section("durations", "How the durations spread", element("p", words), placed(plots, plot))]


def _varied(found: StudyTable) -> Html:
    rows = []
    for number, knob in enumerate(found.knobs):
        column = found.values[:, number]
        low, high = span_texts(float(np.min(column)), float(np.max(column)))
        rows.append((knob.path, low, high, knob.unit, str(len(np.unique(column)))))
    asked = element(
        "dl", joined(joined([element("dt", name), element("dd", text)]) for name, text in found.asked.items())
    )
    whole = table(("number", "from", "to", "unit", "different values"), rows)
    return section("varied", "What was asked", *([asked] if found.asked else []), whole)


def _rest(count: int, what: str) -> list[Html]:
    return [element("p", f"… and {count} more {what}.")] if count > 0 else []
