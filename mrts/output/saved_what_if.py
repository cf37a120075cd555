# SPDX-License-Identifier: MIT
"""What changes to a cell would do, as a part of a saved result."""

from math import inf, isinf

from mrts.cell.cell_change import CellChange, ChangeSteps
from mrts.output.saved_json import AnswerEntry, ChangeEntry, WhatIfEntry
from mrts.program.range_status import RangeStatus
from mrts.scaling.what_if import ChangedAnswer, SpeedAnswer, WhatIf


def what_if_entry(found: WhatIf | None) -> WhatIfEntry | None:
    """Entry of what changes would do; None where that was not asked.

    Args:
        found: What was found.
    """
    if found is None:
        return None

    def entry(one: ChangedAnswer) -> ChangeEntry:
        change = one.change
        return ChangeEntry(
            kind=change.kind, robot=change.robot, element=change.element, step=change.step, after=_entry(one.after)
        )

    steps = found.steps
    return WhatIfEntry(
        share=steps.share,
        shift=steps.shift,
        turn=steps.turn,
        before=_entry(found.before),
        changes=list(map(entry, found.changes)),
        left_out=found.left_out,
    )


def read_what_if(said: WhatIfEntry | None) -> WhatIf | None:
    """What changes would do, of a saved result.

    Args:
        said: What the file says.

    Raises:
        InputError: If a step breaks a rule.
    """
    if said is None:
        return None
    before = _answer(said.before)
    steps = ChangeSteps(share=said.share, shift=said.shift, turn=said.turn)
    changes = tuple(
        ChangedAnswer(
            CellChange(kind=one.kind, robot=one.robot, element=one.element, step=one.step), _answer(one.after), before
        )
        for one in said.changes
    )
    return WhatIf(steps, before, changes, said.left_out)


def _entry(answer: SpeedAnswer) -> AnswerEntry:
    def finite(value: float | None) -> float | None:
        return None if value is None or isinf(value) else value

    moves = bool(answer.duration)  # what nothing limits takes no time
    return AnswerEntry(
        status=answer.status,
        c2=finite(answer.c2),
        duration=finite(answer.duration) if moves else None,
        limits=list(answer.limits),
        reason=answer.reason,
    )


def _answer(said: AnswerEntry) -> SpeedAnswer:
    c2, duration = said.c2, said.duration
    if said.status == RangeStatus.UNBOUNDED.value:
        c2, duration = inf, 0.0
    elif c2 == 0:
        duration = inf
    return SpeedAnswer(status=said.status, c2=c2, duration=duration, limits=tuple(said.limits), reason=said.reason)
