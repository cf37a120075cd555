# SPDX-License-Identifier: MIT
"""Which rows set the speed of a result, and which are at their limits only through the distribution."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mrts.limits.rows import RowName
from mrts.scaling.limit_use import rate_uses, used_shares
from mrts.scaling.range import SPEEDS, RangeEnd
from mrts.scaling.result import ScalingResult
from mrts.timing.profile_limits import BINDING
from mrts.timing.result import RetimingResult
from mrts.timing.smooth_piece import BINDING as AT_LIMIT

AT_END_RETIMED = 1e-2
"""Share of c² within which it is at an end of what a sample of a retimed motion admits, where the acceleration is the
mean of before and after."""


@dataclass(frozen=True)
class LimitingRows:
    """What is to be said of limits that are reached.

    Attributes:
        setting: Rows that set the speed, each with when.
        reached: Others that are at their limit, each with why.
        forced: At which samples the speed keeps a row at its limit, of those of `used_shares`, Shape (N, r): c² is at
            an end of what the sample admits, and the row sets it, or may have to be there with those that do.
    """

    setting: dict[RowName, str]
    reached: dict[RowName, str]
    forced: NDArray[np.bool_]


def limiting_rows(result: ScalingResult, timing: RetimingResult | None) -> LimitingRows:
    """What sets the speed: of a constant factor the end of the range that it is at, of a timing all along its path.

    A row that is at its limit where c² lies inside the range of its sample need not be there: with another
    distribution the motion could be faster and slower there.

    Args:
        result: A result with a trajectory.
        timing: The timing whose retimed motion it is, if known.

    Raises:
        ValueError: If there is no trajectory.
    """
    if result.trajectory is None:
        raise ValueError("there is no trajectory to draw")
    names, shares = used_shares(result.trajectory)
    forced, binding = _forced(result, names)
    rates = [use.name for use in rate_uses(result)]
    setting = (
        _of_timing(timing, [*names, *rates]) if timing is not None and timing.retimed is not None else _of_range(result)
    )
    if result.origin and timing is None:  # read from a file: what the timing was is not known
        setting = {name: "sets the speed" for name in names if name in binding}
    reached = {}
    for place in np.flatnonzero(np.any(shares >= 1 - AT_LIMIT, axis=0)).tolist():
        where = shares[:, place] >= 1 - AT_LIMIT
        if names[place] not in setting:
            kept = bool(np.any(where & forced[:, place]))
            reached[names[place]] = "reached where the speed is set" if kept else "reached through the distribution"
    return LimitingRows(setting, reached, forced)


def _of_timing(timing: RetimingResult, names: Sequence[RowName]) -> dict[RowName, str]:
    """Its limits are told by name, the two sides of a row apart; both do not bind at once."""
    shares = {
        name: sum(share for text, share in timing.limits if text == _told(name) or text.startswith(f"{name} ("))
        for name in names
    }
    return {name: f"sets the speed for {100 * share:.3g} % of the time" for name, share in shares.items() if share > 0}


def _told(name: RowName) -> str:
    """A row as a smooth timing tells of it: `rate of left/elbow torque` for its torque rate."""
    text, kind = str(name), name.kind.split()[-1]
    return f"{kind} of {text.removesuffix(f' {kind}')}" if kind in {"rate", "jerk"} else text


def _of_range(result: ScalingResult) -> dict[RowName, str]:
    if result.trajectory is None:
        return {}
    words = {"lower": "c²⁻", "upper": "c²⁺"}
    ends = result.range.ends_at(result.trajectory.c2, BINDING)
    return {row.name: _words(end, words[side]) for side, end in ends for row in end.rows}


def _words(end: RangeEnd, word: str) -> str:
    load = "" if end.load is None else f" with {end.load}"
    return f"sets {word} at {end.time:.4g} s of the given motion{load}"


def _forced(result: ScalingResult, names: tuple[RowName, ...]) -> tuple[NDArray[np.bool_], set[RowName]]:
    """`LimitingRows.forced`, and all rows that set an end at which c² is.

    Where velocities alone set the end, no torque or wrench has to be at a limit; else all that are may have to be.
    """
    found = result.range
    samples = found.samples
    at_lower, at_upper = _at_ends(result)
    forced, rows = np.zeros((len(samples.time), len(names)), dtype=bool), set()
    for sample in np.flatnonzero(at_lower | at_upper).tolist():
        binding = {row.name for row in found.binding(sample, "upper") if at_upper[sample]}
        binding |= {row.name for row in found.binding(sample, "lower") if at_lower[sample]}
        of_load = any(name.kind not in SPEEDS for name in binding)
        forced[sample] = [of_load or name in binding for name in names]
        rows |= binding
    return forced, rows


def _at_ends(result: ScalingResult) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
    """At which samples c² is at the lower and at the upper end of what they admit, each Shape (N,)."""
    done, samples = result.trajectory, result.range.samples
    assert done is not None  # noqa: S101 (its caller has a trajectory)
    near = AT_END_RETIMED if result.origin else BINDING
    at_lower = (samples.lower > 0) & (samples.lower >= done.c2 * (1 - near))
    at_upper = samples.upper <= done.c2 * (1 + near)
    return at_lower, at_upper
