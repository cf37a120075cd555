# SPDX-License-Identifier: MIT
"""What the panel says of an answer, as HTML: outcome, speed, time, and the nearest limits; needs the extra 'view'."""

from collections.abc import Sequence
from importlib.resources import files

import numpy as np

from mrts.base.errors import MrtsError, Remark, html_text
from mrts.control.simulate import Simulation
from mrts.following.clearance import Clearance
from mrts.plots.card import Card
from mrts.scaling.scaled_trajectory import Nearness
from mrts.scene.scene import FORCE, MOMENT
from mrts.viewer.player_state import HeldPoses, PlayerState

OVER = "var(--mrts-over)"
NEARNESS_COLOURS: dict[Nearness, str] = {"free": "#0072B2", "near": "#E69F00", "reached": OVER}

BAR_COLUMNS = (38, 24, 38)
"""Widths of the columns of the nearest limits: name, bar, value [%]."""

MOST_NAMED = 5
"""Limits named that are passed; the worst come first."""

PANEL = 400
"""Width of the panel beside the scene [pixels]; the scene has the rest of the window."""

STYLE = f"<style>{(files('mrts') / 'viewer' / 'viewer.css').read_text(encoding='utf-8')}</style><span data-mrts></span>"
"""Of the page."""


def verdict_html(outcome: str, error: str, *, computing: bool, outdated: bool) -> str:
    """What stands above all controls: the last outcome, why there is no newer one, and whether one is on its way.

    All that is shown fades while it is outdated: while controls have other values.
    """
    below = '<b data-text="computing">Computing …</b>' if computing else ""
    below += "<style>:root { --mrts-answer: 0.4; }</style>" if outdated else ""
    text = f"{'' if computing else error}{outcome}"
    return f"<div data-verdict><div>{text}</div>{below}</div>"


def outcome_html(state: PlayerState) -> str:
    """The answer in a line; red, with the reason, where no speed is admissible."""
    result, admits = state.result, state.found.status.admits_motion
    text = f"<b>{html_text(state.card.outcome)}</b>" if admits else html_text(state.found.sentence())
    if result.load is not None:
        text += f" Torques are those of the nominal load of {result.cell.mass:.4g} kg."
    text += "".join(f"<br>{html_text(str(remark))}" for remark in result.warnings)
    return _paragraph("outcome", text, red=not admits)


def collisions_html(near: Clearance | None, said: Sequence[Remark]) -> str:
    """How near bodies come to each other and what was not looked at, in red where they collide; empty without both."""
    text = html_text(". ".join(remark.text for remark in said))
    return _paragraph("collisions", text, red=near is not None and near.collides) if said else ""


def simulation_html(found: Simulation | MrtsError | None) -> str:
    """What became of the motion in closed loop, in red where limits are passed; empty where it was not asked."""
    if found is None:
        return ""
    if isinstance(found, MrtsError):
        return _paragraph("simulation", html_text(str(found)), red=True)
    return _paragraph("simulation", html_text(f"In closed loop {found.sentence()}."), red=not found.kept)


def held_html(held: HeldPoses) -> str:
    """What the arms hold without a motion; of one that they cannot follow, why, and how far they stay from it."""
    stands = not held.message
    lost = [
        f"{html_text(robot.name)}{'' if stands else f' at {np.count_nonzero(~reached)} of {len(reached)} samples'}, "
        f"by up to {1000 * float(np.max(gap)):.3g} mm"
        for robot, reached, gap in zip(held.scene.cell.robots, held.reached.T, held.gap.T, strict=True)
        if not np.all(reached)
    ]
    missing = f" Red in the scene is what is missing: {'; '.join(lost)}." if lost else ""
    if held.message:
        return _paragraph("outcome", f"<b>No motion:</b> {html_text(held.message)}{missing}", red=True)
    text = f"{html_text(held.scene.cell.name)} stands where its first arm holds the object at its posture. "
    text += "No motion was given: mrts view CELL MOTION plays one."
    return _paragraph("outcome", text + missing, red=bool(lost))


def speed_html(state: PlayerState | None) -> str:
    """The chosen speed, whether it is admissible, and what is shown if it is not; None leaves the place empty."""
    if state is None:
        return _paragraph("speed", "")
    done, samples = state.trajectory, len(state.excess)
    text = f"c = {done.c:.4g}, c² = {done.c2:.4g}, duration {done.duration:.4g} s, energy {done.energy:.4g} J. "
    passed, found = state.violations(), state.result.range
    interval = f" {found.text()}" if found.status.admits_motion and state.timing is None else ""
    if state.admissible:
        return _paragraph("speed", f"{text}Inside the admissible range{interval}.")
    over = int(np.count_nonzero(state.excess))
    text += f"<b>Outside the admissible range{interval}</b>: "
    if over == 0:
        load = ", though the load shown keeps all limits" if state.result.load is not None else ""
        return _paragraph("speed", f"{text}no torques are guaranteed{load}.", red=True)
    text += f"{over} of {samples} samples beyond a limit (red): "
    text += "; ".join(
        f"{html_text(use.name.short)} by {100 * (use.share - 1):.3g} % at {use.time:.3g} s"
        for use in passed[:MOST_NAMED]
    )
    text += f"; and {len(passed) - MOST_NAMED} more." if len(passed) > MOST_NAMED else "."
    return _paragraph("speed", text, red=True)


def nearest_html(card: Card) -> str:
    """The limits that are nearest all along the motion: how much of each is used at most, and when."""
    rows = []
    for bar in card.bars:
        style = f"width:{100 * min(bar.share, 1.0):.1f}%;background:{NEARNESS_COLOURS[bar.nearness]}"
        used = f"{100 * bar.share:.1f} % at {bar.time:.4g} s"
        rows.append(
            f'<tr data-bar="{bar.nearness}"><td>{html_text(bar.label)}</td>'
            f'<td><div class="track"><div style="{style}"></div></div></td><td>{used}</td></tr>'
        )
    columns = "".join(f'<col style="width:{width}%">' for width in BAR_COLUMNS)
    return f"<table data-bars><colgroup>{columns}</colgroup>{''.join(rows)}</table>" if rows else ""


def arrows_html(metres_per_newton: float, metres_per_newton_metre: float) -> str:
    """How long the arrows of wrenches are."""
    text = (
        f'Arrows: <b style="color:rgb{FORCE}">force</b>, 1 m is {1 / metres_per_newton:.4g} N; '
        f'<b style="color:rgb{MOMENT}">moment</b>, 1 m is {1 / metres_per_newton_metre:.4g} N m'
    )
    return _paragraph("arrows", text)


def keys_html(lines: Sequence[str]) -> str:
    """What was changed, a line each; empty where nothing was."""
    changed = "".join(f"<br><code>{html_text(line)}</code>" for line in lines)
    return _paragraph("keys", f"Changed, as the cell file and the motion file have it:{changed}") if lines else ""


def text_html(kind: str, text: str) -> str:
    """A text of the panel, such as a "note" or an "error"."""
    return _paragraph(kind, html_text(text), red=kind == "error")


def _paragraph(kind: str, text: str, *, red: bool = False) -> str:
    return f'<div data-text="{kind}" style="color:{OVER if red else "inherit"}">{text}</div>'
