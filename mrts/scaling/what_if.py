# SPDX-License-Identifier: MIT
"""What small changes to a cell would do to the speed of a motion, each found by solving again."""

from collections.abc import Callable, Iterator
from dataclasses import asdict, dataclass
from math import degrees, inf
from typing import Any

import numpy as np

from mrts.base.errors import InputError, MotionError, Progress, SolverError
from mrts.base.notebook import InNotebooks, NotebookTable
from mrts.base.words import aligned, first_names
from mrts.cell.cell import Cell
from mrts.cell.cell_change import SHARE, SHIFT, TURN, CellChange, cell_changes
from mrts.following.coordinated_motion import CoordinatedMotion, follow_object, following_again

NO_CHANGE = 1e-6
"""Share of the duration below which a change does nothing: programs are right to 1e-9, ends that tie to 1e-7."""

_GIVEN = (
    "bases and grasps were not moved: the joints of this motion are given, and are not those that the arms take by "
    "themselves"
)

MOST_NAMED = 3
"""Limits that bind which a line names; the rest is counted."""


@dataclass(frozen=True, kw_only=True)
class SpeedAnswer:
    """How fast a motion may be played with a cell.

    Attributes:
        status: The outcome of the range or of the timing; "unreachable" where the arms cannot follow, "invalid" where
            the change breaks a rule, "failed" where no solver answers.
        c2: c²⁺; infinity where nothing limits it, None where no c² is admissible or the speed varies along the path.
        duration: Of the motion at its fastest [s]; infinity where it can only stand, None where it cannot be played.
        limits: What binds then.
        reason: Why it cannot be played; empty if it can.
    """

    status: str
    c2: float | None = None
    duration: float | None = None
    limits: tuple[str, ...] = ()
    reason: str = ""

    def to_json(self) -> dict[str, Any]:
        """The answer as JSON values; null stands for what is not, or has no end."""
        return {
            "status": self.status,
            "c2_upper": None if self.c2 is None or np.isinf(self.c2) else self.c2,
            "duration": None if self.duration is None or np.isinf(self.duration) else self.duration,
            "limits": list(self.limits),
            "reason": self.reason or None,
        }


@dataclass(frozen=True)
class ChangedAnswer:
    """A change, and what the answer is with it.

    Attributes:
        change: What was changed.
        after: With it.
        before: Without it.
    """

    change: CellChange
    after: SpeedAnswer
    before: SpeedAnswer

    def __str__(self) -> str:
        return "; ".join(filter(None, self.row))

    @property
    def row(self) -> tuple[str, str, str, str]:
        """Texts of a table: the change, its effect, the duration, what limits it then or why it cannot be played."""
        then = first_names(self.after.limits, MOST_NAMED) or self.after.reason
        return str(self.change), self.effect, _seconds(self.after.duration), then

    @property
    def faster(self) -> float:
        """The duration before by that after: infinity where there was none, 0 where there is none."""
        before, after = (inf if one.duration is None else one.duration for one in (self.before, self.after))
        if before == after:
            return 1.0
        return before / after if after > 0 else inf

    @property
    def matters(self) -> bool:
        """Whether the change does anything to the speed, or to whether there is one."""
        return not abs(self.faster - 1) <= NO_CHANGE

    @property
    def effect(self) -> str:
        """By how much it is faster or slower, such as `time -4.3 %`; the outcome where that is no number."""
        if self.after.duration is None or not 0 < self.faster < inf:
            return self.after.status
        return f"time {100 / self.faster - 100:+.3g} %"

    def to_json(self) -> dict[str, Any]:
        """The entry of a change in the JSON result."""
        said = {"change": str(self.change), **asdict(self.change), "unit": self.change.unit}
        return said | self.after.to_json() | {"matters": self.matters}


@dataclass(frozen=True, repr=False)
class WhatIf(InNotebooks):
    """What `ScalingResult.what_if` or `RetimingResult.what_if` found.

    Attributes:
        before: The answer as it is, at the samples of the result.
        changes: All changes, what gains most first, what cannot be played last.
        left_out: What could not be asked, a sentence; empty if nothing.
    """

    before: SpeedAnswer
    changes: tuple[ChangedAnswer, ...]
    left_out: str = ""

    def __repr__(self) -> str:
        return f"<WhatIf: {len(self.changes)} changes, {sum(one.matters for one in self.changes)} matter>"

    def __str__(self) -> str:
        return "\n".join(self.lines())

    @property
    def without_effect(self) -> tuple[str, ...]:
        """What may be changed up and down and the speed stays as it is."""
        matter = {one.change.what for one in self.changes if one.matters}
        return tuple(dict.fromkeys(one.change.what for one in self.changes if one.change.what not in matter))

    def lines(self) -> Iterator[str]:
        """The question and the answer before, a table of the changes that matter, and what does nothing."""
        question, *others = self.notebook_words()
        yield question
        for table in self.notebook_tables():
            yield from (f"  {line}" for line in aligned((table.head, *table.rows)))
        yield from others

    def notebook_words(self) -> list[str]:
        """The question and the answer before, and what does nothing."""
        before, poses = self.before, f", {1000 * SHIFT:.4g} mm and {degrees(TURN):.4g}° of bases and grasps"
        moved = any(one.change.moves_arms for one in self.changes)
        now = before.status if before.duration is None else _seconds(before.duration)
        now += f" at c² = {before.c2:.4g}" if before.c2 is not None and before.duration else ""
        question = f"what if: ±{100 * SHARE:.4g} % of limits and mass{poses if moved else ''}; now {now}"
        stays = "the speed stays" if before.duration is not None else "it still cannot be played"
        count = len(self.without_effect)
        others = f"each of {count} others may be changed as much, one at a time, and {stays}" if count else ""
        return [question, *filter(None, [others, self.left_out])]

    def notebook_tables(self) -> Iterator[NotebookTable]:
        """What matters: what gains most first, what cannot be played last."""
        if rows := [one.row for one in self.changes if one.matters]:
            yield NotebookTable(("change", "effect", "duration", "then limited by"), rows)

    def to_json(self) -> dict[str, Any]:
        """The entry "what_if" of the JSON result."""
        return {
            "before": self.before.to_json(),
            "changes": [one.to_json() for one in self.changes],
            "without_effect": list(self.without_effect),
            "left_out": self.left_out or None,
        }


def _seconds(duration: float | None) -> str:
    if duration is None:
        return "cannot be played"
    if duration == 0:
        return "as fast as you like"
    return f"{duration:.4g} s" if np.isfinite(duration) else "stands still"


SpeedQuestion = tuple[Cell, CoordinatedMotion, Callable[[Cell, CoordinatedMotion, SpeedAnswer | None], SpeedAnswer]]
"""A cell, its motion, and what answers for a changed cell and its motion, told the answer for the cell as it is."""


def what_if(question: SpeedQuestion, progress: Progress) -> WhatIf:
    """Change every number of a cell, one at a time up and down, and ask again.

    Arms whose base or grasp is moved follow the same motion of the object again, from the same postures.
    """
    cell, motion, answer = question
    follows, motion = following_again(cell, motion)
    before = answer(cell, motion, None)
    changes, left_out = cell_changes(cell), ""
    if follows is None:
        changes, left_out = tuple(change for change in changes if not change.moves_arms), _GIVEN
    found = []
    for number, change in enumerate(changes):
        progress(number, len(changes))
        start = follows if follows is not None and change.moves_arms else cell
        try:
            changed = change.applied(start)
            path = follow_object(changed, motion.object) if change.moves_arms else motion
            after = answer(changed, path, before)
        except InputError as error:
            after = SpeedAnswer(status="invalid", reason=str(error))
        except MotionError as error:
            after = SpeedAnswer(status="unreachable", reason=str(error).partition(". ")[0])  # without advice
        except SolverError as error:
            after = SpeedAnswer(status="failed", reason=str(error))
        found.append(ChangedAnswer(change, after, before))
    progress(len(changes), len(changes))
    found.sort(key=lambda one: inf if one.after.duration is None else one.after.duration)
    return WhatIf(before, tuple(found), left_out)
