# SPDX-License-Identifier: MIT
"""A plan at the rate of a controller: its own motion at equal steps, with torques there."""

from dataclasses import replace

import numpy as np

from mrts.base.errors import InputError, MrtsError, SolverError, is_number
from mrts.following.coordinated_motion import CoordinatedMotion
from mrts.following.denser_motion import between_samples
from mrts.motion.joint_table import joint_contradictions
from mrts.scaling.result import END_TOLERANCE, ScalingResult
from mrts.scaling.scale import SelectionError, admissible_range, with_torques

MOST_ROWS = 1_000_000
"""Of a plan: as many as a table may have that is read."""

ATTEMPTS = 10
"""Durations that are tried, each by what the one before passed its limits."""

WHOLE = 1e-9
"""Share of a step by which a duration may miss a whole number of steps: rounding."""


def at_rate(result: ScalingResult, rate: float) -> ScalingResult:
    """See `mrts.ScalingResult.at_rate`."""
    done = result.trajectory
    if done is None:
        raise InputError("rate", "there is no trajectory to sample: no c² was chosen.", value=rate)
    if not is_number(rate, 1 / done.duration, MOST_ROWS / done.duration):
        rule = f"must be a number of rows per second, at least one and at most {MOST_ROWS} in {done.duration:.4g} s."
        raise InputError("rate", rule, value=rate)
    if result.options.sharing is not None and result.options.sharing.varies:
        raise InputError("rate", "an internal wrench that is given for each sample is not known at others.", value=rate)
    options = replace(result.options, load="nominal", select=1.0, rates=None)
    steps, refused = int(np.ceil(done.duration * rate * (1 - WHOLE))), MrtsError("")
    for _ in range(ATTEMPTS):
        motion = _sampled(result, steps, float(rate))
        found, _, excess_at = admissible_range(done.cell, motion, options)
        ends, c2 = found.range, found.range.admitted(1.0, END_TOLERANCE)
        if c2 is None:
            refused = SelectionError(f"at {rate:g} Hz: {found.sentence()}", found)
            least, most = (0.0 if end is None else end.c2 for end in (ends.lower, ends.upper))
            slower = int(np.ceil(steps / np.sqrt(most))) if most > 0 else 0
            steps = int(steps / np.sqrt(least)) if least > 1 else max(steps + 1, slower)
            continue
        own_range = ends if found.motion is motion else None
        excess = excess_at and excess_at(c2)
        own = replace(options, rates=result.options.rates)  # a plan has its own rows alone, whatever was looked at
        try:
            sampled = with_torques(replace(found, motion=motion, found=own_range, c2=c2, options=own, excess=excess))
        except SolverError as error:  # where rates do not suit
            steps, refused = steps + 1, error
            continue
        played = sampled.trajectory
        assert played is not None and played.holding is not None  # noqa: S101, PT018 (c² is in the range)
        played = replace(played, holding=replace(played.holding, rate=float(rate)))
        return replace(sampled, trajectory=played, origin=f"sampled at {rate:g} Hz")
    raise refused


def _sampled(result: ScalingResult, steps: int, rate: float) -> CoordinatedMotion:
    """The motion as it is played, at equal steps from its first sample to its last, slower by less than one of them."""
    assert result.trajectory is not None  # noqa: S101 (the caller has looked)
    given, time = result.motion, np.arange(steps + 1) / rate
    end = float(given.object.time[-1])
    some = between_samples(result.trajectory.cell, given, time[1:-1] * (end / time[-1]))
    c = end / float(time[-1])
    carried = some.object.played(time, c * some.object.twist, c**2 * some.object.acceleration)
    q, dq, ddq = some.q, c * some.dq, c**2 * some.ddq
    for found in joint_contradictions(result.cell.joint_names, time, q, dq, ddq):
        raise InputError("rate", f"is too low for this plan: {found}", value=rate)
    return CoordinatedMotion(carried, q, dq, ddq, travel=some.travel)
