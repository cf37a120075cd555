# SPDX-License-Identifier: MIT
"""What a study found, in words: how many variants may be played, the best, what limits it."""

import numpy as np

from mrts.base.arrays import Array
from mrts.base.words import first_names
from mrts.limits.rows import MOST_NAMES
from mrts.plots.study_table import Index, StudyTable

BEST_PART = 0.05
"""Share of the variants with a duration that counts as the best."""

OUTERMOST = 0.02
"""Share of a number's range, at either end, in which a value counts as at the end."""

SHARES = (50, 90, 95, 99)
"""Of the variants, of which the duration is told within which they finish [%]."""


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
    row = int(table.ranked[0])
    text = f"the best is {variant_text(table, row)}"
    return f"{text}, limited by {first_names(limits, MOST_NAMES)}" if (limits := table.limits(row)) else text


def variant_text(table: StudyTable, row: int) -> str:
    """Number, duration and c²⁺ of a variant; a speed that varies may be possible where no constant c² is."""
    text = f"variant {table.rows['variant'].iloc[row]}: {table.duration[row]:.4g} s"
    return f"{text}, c² = {table.c2[row]:.4g}" if np.isfinite(table.c2[row]) else text


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


def best_part(table: StudyTable) -> Index:
    """Rows of the best variants, at least one where there is any."""
    return table.ranked[: int(np.ceil(BEST_PART * len(table.ranked)))]


def best_rows(table: StudyTable, most: int) -> tuple[list[str], list[list[str]]]:
    """The best variants as a table, a row each below what was tried.

    Returns:
        Titles of the columns, and the rows.
    """
    best = table.ranked[:most]
    head = ["variant", "duration [s]", "c²⁺ [1]", *(knob.title for knob in table.knobs), "limited by"]
    tried = [table.duration[table.ranked], table.c2[table.ranked], *table.values.T]
    rows = [["from … to", *map(_span, tried), ""]]
    low, high = (end(table.values, axis=0) for end in (np.min, np.max))
    chosen = np.array([not knob.by_chance for knob in table.knobs]) & (high > low)
    near = np.minimum(table.values - low, high - table.values) <= OUTERMOST * (high - low)
    for row in best.tolist():
        at_end = (chosen & near[row]).tolist()
        values = [f"{value:.4g}{' (end)' * end}" for value, end in zip(table.values[row].tolist(), at_end, strict=True)]
        c2 = f"{table.c2[row]:.4g}" if np.isfinite(table.c2[row]) else ""
        number = str(table.rows["variant"].iloc[row])
        rows.append([number, f"{table.duration[row]:.4g}", c2, *values, first_names(table.limits(row), MOST_NAMES)])
    return head, rows


def span_texts(low: float, high: float) -> tuple[str, str]:
    """The ends of a span to a thousandth of it: what is next to 0 beside the other end is 0."""
    digits = 3 - int(np.floor(np.log10(high - low))) if high > low else 12
    return f"{round(low, digits) + 0.0:.4g}", f"{round(high, digits) + 0.0:.4g}"


def _span(values: Array) -> str:
    values = values[np.isfinite(values)]
    return " … ".join(span_texts(float(np.min(values)), float(np.max(values)))) if len(values) else ""


def percent(count: int, of: int) -> str:
    """A share in per cent, rounded down so that what falls short of all, or of a share, is seen to do so."""
    share = 100 * count / of if of else 0.0
    return f"{share:.2g} %" if 0 < share < 1 else f"{1000 * count // of / 10 if of else 0:g} %"
