# SPDX-License-Identifier: MIT
"""The part of a report on a timing: durations side by side, what limits it, the phase plane."""

from mrts.report.markup import Html, Section, bar, element, section, table
from mrts.timing.result import RetimingResult

MOST_LIMITS = 12
"""Limits that are listed; the rest is counted."""


def timing_section(found: RetimingResult, plane: Html) -> Section:
    """The timing beside the best constant factor, what limits it, and the phase plane.

    Args:
        found: A result with a profile.
        plane: Its phase plane.
    """
    heads = ("timing", "duration", "of the given time", "")
    note = element("p", _note(found), class_="note")
    return section("timing", "The timing", table(heads, _durations(found)), *_limits(found), note, plane)


def _durations(found: RetimingResult) -> list[tuple[str, ...]]:
    given, best, smooth = float(found.motion.object.time[-1]), found.factor, found.smooth
    longest = max(given, found.duration or 0.0, best.duration or 0.0)

    def row(name: str, duration: float | None, more: str = "") -> tuple[str, ...]:
        if duration is None:
            return (name, "none", "", more)
        return (name, f"{duration:.4g} s", bar(duration / longest, words=f"{100 * duration / given:.4g} %"), more)

    rows = [row(smooth.what if smooth is not None else "fastest timing", found.duration, _saving(found))]
    if smooth is not None and smooth.bound is not None:
        rows.append(row("fastest without limits of rates", smooth.bound, "no timing takes less"))
    at = "" if best.c2 is None else f"c² = {best.c2:.4g}"
    return [*rows, row("best constant factor", best.duration, at), row("as given", given)]


def _saving(found: RetimingResult) -> str:
    if found.saving is None:
        return ""
    less = "less" if found.saving >= 0 else "more"
    return f"{100 * abs(found.saving):.3g} % {less} than the best constant factor"


def _limits(found: RetimingResult) -> list[Html]:
    rows = [(name, bar(share)) for name, share in found.limits[:MOST_LIMITS]]
    rest = len(found.limits) - MOST_LIMITS
    more = [element("p", f"… and {rest} more limits.")] if rest > 0 else []
    return [table(("what limits the speed", "for this share of the duration"), rows), *more] if rows else []


def _note(found: RetimingResult) -> str:
    stops = f" It stops {len(found.stops)} times on its way." if len(found.stops) > 1 else ""
    return f"Several limits may bind at once.{stops} Below: the speed along the path."
