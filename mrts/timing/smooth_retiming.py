# SPDX-License-Identifier: MIT
"""From the fastest timing of a motion to the best one whose torques and accelerations change at limited rates."""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from mrts.base.argument_types import Progress, check_type, is_number
from mrts.base.errors import InputError
from mrts.base.input_file import LARGEST_NUMBER
from mrts.base.remark import Remark
from mrts.following.coordinated_motion import CoordinatedMotion
from mrts.program.smooth_program import Goal
from mrts.program.successive_steps import CONVERGED
from mrts.scaling.motion_remarks import lasting
from mrts.timing.between_samples import refined_timing, with_excess
from mrts.timing.path_pieces import NoPath
from mrts.timing.played_result import played_result
from mrts.timing.result import RetimingResult, RetimingStatus
from mrts.timing.retimed_motion import TimedPiece
from mrts.timing.smooth_excess import smooth_excess
from mrts.timing.smooth_path import smooth_nodes
from mrts.timing.smooth_piece import SmoothAnswer, fastest_pieces, smooth_pieces
from mrts.timing.smooth_timing import SmoothQuestion, smooth_timing, torque_plan

NEAR = 0.3
"""Share of the tolerance from which a segment gets a node once one passes it: each round solves all programs anew."""

WEIGHTS = ("time", "energy")
"""What `weigh` may weigh."""


def smooth_goal(weigh: Mapping[str, float] | None, least_energy_in: float | None) -> Goal:
    """What is to be least.

    Args:
        weigh: Weights of "time" [1/s] and "energy" [1/(N² m² s)]; None is the time alone.
        least_energy_in: The longest duration, where the energy is to be least [s].

    Raises:
        InputError: If a name or a number breaks a rule.
    """
    if weigh is not None and least_energy_in is not None:
        raise InputError("weigh", "does not go with least_energy_in, which weighs the energy alone.")
    if least_energy_in is not None:
        if not is_number(least_energy_in, 0, LARGEST_NUMBER) or least_energy_in == 0:
            raise InputError("least_energy_in", "must be a duration > 0 [s].", value=least_energy_in)
        return Goal(0.0, 1.0, float(least_energy_in))
    if weigh is None:
        return Goal()
    check_type("weigh", weigh, Mapping)
    for name, weight in weigh.items():
        if name not in WEIGHTS:
            raise InputError("weigh", f"may have the keys {' and '.join(WEIGHTS)} only.", value=name)
        if not is_number(weight, 0, LARGEST_NUMBER):
            raise InputError("weigh", f"must be >= 0 and at most {LARGEST_NUMBER:.0e}.", key=name, value=weight)
    goal = Goal(float(weigh.get("time", 0.0)), float(weigh.get("energy", 0.0)))
    if goal.time == 0:
        rule = "must be > 0: with the energy alone a motion may last for ever. Or ask for the least in a duration."
        raise InputError("weigh", rule, key="time", value=goal.time)
    return goal


def smooth_retiming(
    fastest: RetimingResult, question: SmoothQuestion, tolerance: float, progress: Progress, *, adds: bool
) -> RetimingResult:
    """The best timing within limits of rates, with its torques.

    Args:
        fastest: The fastest timing without limits of rates, or why there is none.
        question: What is asked.
        tolerance: Share of a limit by which it may be overstepped between nodes.
        progress: Told how many steps are done.
        adds: Whether nodes are added where it is.

    Raises:
        InputError: If the question does not fit the motion.
        MotionError: If the arms cannot hold the object between the samples.
        SolverError: If no solver answers.
    """
    if not (fastest.status.admits_motion or fastest.status is RetimingStatus.UNBOUNDED):
        return fastest
    nodes = smooth_nodes(fastest.cell, question.constant.motion, question.end_speeds)
    if isinstance(nodes, NoPath):
        return fastest

    before: list[TimedPiece] = []

    def timed(motion: CoordinatedMotion) -> RetimingResult:
        found = smooth_timing(question, motion, before, progress)
        before[:] = found.pieces
        return replace(found, smooth=_answer(question, fastest, found))

    found = refined_timing(
        timed(nodes), timed, lambda one: smooth_excess(one, tolerance), tolerance, adds=adds, near=NEAR
    )
    if not found.pieces or found.excess is None:
        return found
    plan = torque_plan(question, found.pieces)
    answer, constant = _answer(question, fastest, found), question.constant
    kept = replace(constant.options, rates=question.rates)
    played = played_result(
        constant.cell, found.motion, kept, found.pieces, answer.what, warnings=lasting(constant.warnings), torques=plan
    )
    played = replace(played, origin=f"{played.origin}. {answer}", warnings=played.warnings + _stopped(answer, found))
    return with_excess(replace(found, retimed=played, smooth=answer), found.excess)


def _stopped(answer: SmoothAnswer, found: RetimingResult) -> tuple[Remark, ...]:
    """What a search that met its bounds leaves; nothing where it came to its end."""
    left = []
    if answer.gain is None or answer.gain >= CONVERGED:
        left.append("a faster profile may be near")
    if found.excess is not None and found.excess.passes:
        left.append(f"between {found.motion.samples} nodes limits are overstepped by {100 * found.excess.share:.2g} %")
    if not left:
        return ()
    return (Remark("search-stopped", f"this is the best timing found in {answer.steps} steps: {', and '.join(left)}."),)


def _answer(question: SmoothQuestion, fastest: RetimingResult, found: RetimingResult) -> SmoothAnswer:
    pieces = smooth_pieces(found.pieces)
    steps = [part.steps for part in pieces]
    return SmoothAnswer(
        rates=question.rates,
        goal=question.goal,
        duration=sum(float(np.sum(part.segment_times)) for part in pieces) if pieces else None,
        bound=question.fastest,
        steps=question.solver.steps,
        gain=None if any(one.gain is None for one in steps) else max((one.gain or 0.0 for one in steps), default=0.0),
        fastest=fastest_pieces(fastest.pieces),
    )
