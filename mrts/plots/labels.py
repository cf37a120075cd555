# SPDX-License-Identifier: MIT
"""Names as labels of a picture, printable and short enough to stand beside a plot; a range in a few words."""

from collections.abc import Sequence

from mrts.base.printable import cut, printable
from mrts.limits.rows import STANDSTILL, ActiveRow, RowName, row_labels
from mrts.scaling.range import ScalingRange

LONGEST_LABEL = 44
"""Letters of a label."""

LANE_LETTERS = 32
"""Letters of a row's name beside its lane."""

MOST_LETTERS = 128
"""Of names that are alike where they are shorter."""


def shortened(name: str, longest: int = LONGEST_LABEL) -> str:
    """A printable name whose middle is left out where it is too long."""
    return cut(printable(name), longest)


def shortened_apart(names: Sequence[str], longest: int = LANE_LETTERS) -> list[str]:
    """Names beside each other as `shortened`, as long as it takes to tell them apart."""
    short = [shortened(name, longest) for name in names]
    if len({*short}) == len({*names}) or longest >= MOST_LETTERS:
        return short
    return shortened_apart(names, 2 * longest)


def short_name(name: RowName) -> str:
    """What a row limits, whichever side: `left/elbow torque`, `left/pad slips`."""
    return name.failure or str(name)


def row_text(row: ActiveRow) -> str:
    """A row with its limit: `left/elbow torque ↑, 80 N m`, `left/pad slips: friction 100 % used`."""
    name = row.name
    if name == STANDSTILL or name.kind == "speed" or name.failure:
        return str(row)
    return f"{name}{row.arrow}, {row.limit:.4g} {name.unit}".rstrip()


def range_text(found: ScalingRange) -> str:
    """Both ends; where no c² is admissible, the outcome, and where the ends of an empty range are."""
    low, high = found.lower, found.upper
    if low is None or high is None:
        return str(found.status.value)
    if found.status.admits_motion or low.time is None or high.time is None:
        return found.text()
    return f"empty (at least {low.c2:.4g} at t = {low.time:.4g} s, but at most {high.c2:.4g} at t = {high.time:.4g} s)"


def range_facts(found: ScalingRange) -> list[str]:
    """What sets the range over the motion, or leaves none, a sentence for each end."""
    facts = []
    if found.samples.conflicts:
        worst = max(found.samples.conflicts, key=lambda conflict: conflict.widening)
        load = f" with {worst.load}" if worst.load is not None else ""
        facts.append(f"worst conflict at t = {worst.time:.4g} s{load}: {row_labels(worst.rows)}")
    for name, end in (("c²⁺", found.upper), ("c²⁻", found.lower)):
        if end is not None and end.time is not None and (name == "c²⁺" or end.c2 > 0):
            facts.append(f"{name} = {end.c2:.4g} is set {end.place()}")
    return facts
