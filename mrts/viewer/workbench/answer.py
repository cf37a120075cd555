# SPDX-License-Identifier: MIT
"""What follows from choices: a motion that can be played, where arms do not reach, or why there is neither."""

from dataclasses import dataclass

from mrts.base.argument_types import Progress
from mrts.base.errors import MotionError, MrtsError
from mrts.motion.object_motion import ObjectMotion
from mrts.program.excess import BETWEEN
from mrts.viewer.player_state import PlayerState
from mrts.viewer.workbench.choices import COARSE_SAMPLES, Choices, Given
from mrts.viewer.workbench.held_poses import HeldPoses, held_poses


@dataclass(frozen=True, eq=False)
class Answer:
    """What follows from choices.

    Attributes:
        choices: The choices.
        state: The motion at its first choice of speed, or at the speed that was asked for; None where there is none.
        held: Where arms are without a motion that can be played, or where none was given; None else.
        error: Why there is neither; None else.
        seconds: That it took.
        coarse: Whether it has few samples and keeps the limits at these alone; the whole answer follows.
    """

    choices: Choices
    state: PlayerState | None
    held: HeldPoses | None = None
    error: MrtsError | None = None
    seconds: float = 0.0
    coarse: bool = False

    @property
    def message(self) -> str:
        """Why the motion cannot be played; empty if it can, or none was given."""
        if self.held is not None:
            return self.held.message
        return "" if self.error is None else str(self.error)


def find_answer(given: Given, choices: Choices, speed: float | None, progress: Progress, *, coarse: bool) -> Answer:
    """Find what follows from choices, at a speed or the nearest on offer; None is the first choice.

    A coarse answer has few samples and keeps limits at these alone.
    """
    try:
        cell, motion = choices.cell(given), choices.motion(given, COARSE_SAMPLES if coarse else None)
    except MrtsError as error:
        return Answer(choices, None, error=error)
    if given.stands and isinstance(motion, ObjectMotion):
        return Answer(choices, None, held=held_poses(cell, motion))
    try:
        state = PlayerState(
            cell,
            motion,
            sharing=choices.sharing(),
            closure=given.closure,
            profile=choices.profile,
            rates=choices.torque_rate,
            between=None if coarse else BETWEEN,
            progress=progress,
        )
        if speed is not None:
            state.choose_speed(min(max(speed, state.speeds.lower), state.speeds.upper))
    except MotionError as error:
        if not isinstance(motion, ObjectMotion):
            return Answer(choices, None, error=error)
        return Answer(choices, None, held=held_poses(cell, motion, str(error)))
    except MrtsError as error:
        return Answer(choices, None, error=error)
    return Answer(choices, state, coarse=coarse)


def at_another_speed(answer: Answer, speed: float | None) -> Answer:
    """An answer that has a state, played at another speed on offer; None is the first choice."""
    assert answer.state is not None  # noqa: S101 (only such are kept)
    try:
        state = answer.state.at_speed(answer.state.speeds.start if speed is None else speed)
    except MrtsError as error:
        return Answer(answer.choices, None, error=error)
    return Answer(answer.choices, state, coarse=answer.coarse)
