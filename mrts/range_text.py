# SPDX-License-Identifier: MIT
"""The range over the motion and what sets it, in a few words."""

import numpy as np

from mrts.binding_rows import row_labels
from mrts.scaling_range import ScalingRange


def range_text(found: ScalingRange) -> str:
    """Both ends as an interval, or the name of the outcome where there is none."""
    if found.lower is None or found.upper is None or not found.status.admits_motion:
        return str(found.status.value)
    return f"[{found.lower.c2:.4g}, {f'{found.upper.c2:.4g}]' if np.isfinite(found.upper.c2) else '∞)'}"


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
            load = f" with {end.load}" if end.load is not None else ""
            facts.append(f"{name} = {end.c2:.4g} is set at t = {end.time:.4g} s{load} by {row_labels(end.rows)}")
    return facts
