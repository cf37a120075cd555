# SPDX-License-Identifier: MIT
"""Configurations of the arms, ranked by how fast they let the motion be played."""

import numpy as np
from matplotlib.axes import Axes

from mrts.drawing.colours import CONFLICT, END_COLOURS
from mrts.drawing.labels import row_labels
from mrts.figures.style import NotebookFigure, plain, plain_text
from mrts.program.range_status import RangeStatus
from mrts.studies.configurations import Configuration, ConfigurationStudy

MOST_BARS = 64
"""Configurations that are drawn, the best first."""

BAR_INCHES = 0.2


def draw_ranking(axes: Axes, study: ConfigurationStudy) -> None:
    """c²⁺ of every configuration as a bar, the best above, with what limits it; infeasible ones are crosses.

    Args:
        axes: Where to draw.
        study: What `rank_configurations` found.
    """
    shown = study.ranked[:MOST_BARS]
    finite = [found.c2_upper for found in shown if np.isfinite(found.c2_upper)]
    longest = max(finite, default=0.0) or 1.0
    for row, found in enumerate(shown):
        c2 = found.c2_upper
        if c2 == -np.inf:
            axes.plot(0, row, "x", color=CONFLICT, markersize=6, clip_on=False)
        elif c2 == np.inf:
            axes.barh(row, 1.1 * longest, height=0.72, color="white", edgecolor=END_COLOURS["upper"], hatch="///")
        else:
            axes.barh(row, c2, height=0.72, color=END_COLOURS["upper"])
            axes.annotate(f"{c2:.4g}", (c2, row), (3, 0), textcoords="offset points", va="center", fontsize="x-small")
    names = [", ".join(f"{plain(branch.robot)} {branch.number}" for branch in found.branches) for found in shown]
    axes.set_yticks(range(len(shown)), names, fontsize="x-small")
    axes.set_xlim(0, 1.1 * longest)
    axes.set_ylim(len(shown) - 0.4, -0.6)
    axes.set_xlabel("c²⁺ [1]")
    axes.grid(visible=True, axis="x", alpha=0.3)
    axes.set_axisbelow(True)
    reasons = axes.secondary_yaxis("right")
    reasons.set_yticks(range(len(shown)), [_reason(found) for found in shown], fontsize="x-small")
    reasons.tick_params(length=0)


def _reason(configuration: Configuration) -> str:
    """What limits a configuration, in a few words."""
    found = configuration.range
    if found.status is RangeStatus.INFEASIBLE:
        worst = max(found.samples.conflicts, key=lambda conflict: conflict.widening)
        return f"infeasible: {row_labels(worst.rows)}"
    if found.upper is None or found.upper.time is None:
        return str(found.status.value)
    if found.status is RangeStatus.EMPTY:
        return f"empty: {row_labels(found.upper.rows)}"
    return f"{found.upper.time:.3g} s: {row_labels(found.upper.rows)}"


def ranking_figure(study: ConfigurationStudy, title: str) -> NotebookFigure:
    """The best configurations as bars.

    Args:
        study: What `rank_configurations` found.
        title: Title of the figure.
    """
    shown = min(len(study.ranked), MOST_BARS)
    figure = NotebookFigure(figsize=(8.5, 1.6 + BAR_INCHES * shown), layout="constrained")
    axes = figure.subplots()
    more = f" (the best {shown} of {len(study.ranked)})" if shown < len(study.ranked) else ""
    figure.suptitle(plain_text(f"{title}{more}"), fontsize="medium")
    if not shown:
        axes.text(0.5, 0.5, "no configuration reaches the end of the motion", ha="center", va="center")
        axes.set_axis_off()
        return figure
    draw_ranking(axes, study)
    axes.set_ylabel("branch of each arm")
    axes.set_title("limited at t by", loc="right", fontsize="small")
    return figure
