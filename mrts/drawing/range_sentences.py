# SPDX-License-Identifier: MIT
"""The range over the motion and what sets it, in a few words."""

from mrts.drawing.labels import row_labels
from mrts.scaling.range import RangeEnd, ScalingRange


def range_text(found: ScalingRange) -> str:
    """Both ends; where no c² is admissible, the outcome, and where the ends of an empty range are."""
    low, high = found.lower, found.upper
    if low is None or high is None:
        return str(found.status.value)
    if found.status.admits_motion or low.time is None or high.time is None:
        return found.text()
    return f"empty (at least {low.c2:.4g} at t = {low.time:.4g} s, but at most {high.c2:.4g} at t = {high.time:.4g} s)"


def range_facts(found: ScalingRange) -> list[str]:
    """What sets the range over the motion, or leaves none, a sentence for each end.

    Args:
        found: The range over the motion.
    """
    facts = []
    if found.samples.conflicts:
        worst = max(found.samples.conflicts, key=lambda conflict: conflict.widening)
        load = f" with {worst.load}" if worst.load is not None else ""
        facts.append(f"worst conflict at t = {worst.time:.4g} s{load}: {row_labels(worst.rows)}")
    for name, end in (("c²⁺", found.upper), ("c²⁻", found.lower)):
        if end is not None and end.time is not None and (name == "c²⁺" or end.c2 > 0):
            facts.append(f"{name} = {end.c2:.4g} is {_set_by(end)}")
    return facts


def _set_by(end: RangeEnd) -> str:
    load = f" with {end.load}" if end.load is not None else ""
    return f"set at t = {end.time:.4g} s{load} by {row_labels(end.rows)}"
