# SPDX-License-Identifier: MIT
"""How much of its limits a played motion uses along time, and which of them set its speed."""

from collections.abc import Sequence
from dataclasses import dataclass
from math import sqrt
from typing import TYPE_CHECKING

import numpy as np

from mrts.base.arrays import Array
from mrts.limits.rows import ActiveRow, RowName
from mrts.scaling.limit_use import limited_rates, used_shares
from mrts.scaling.result import ScalingResult
from mrts.scaling.scaled_trajectory import ScaledTrajectory

if TYPE_CHECKING:
    from mrts.timing.result import RetimingResult

TITLES = {
    "torque": "Joint torques",
    "wrench": "Contact wrenches",
    "velocity": "Velocities",
    "acceleration": "Accelerations",
    "contact": "Contacts: friction, tilting, normal force",
    "motor speed": "Motor speeds",
    "torque-speed": "Torques at speed",
    "torque rate": "Rates of joint torques",
    "wrench rate": "Rates of contact wrenches",
    "jerk": "Joint jerks",
}
"""Of kinds of limits in the order of their pictures; others come after them by their own name."""

REACHED = 0.9995
"""Share of a limit from which it reads 100 %."""

AT_LIMIT = 1e-4
"""Share of a limit by which what is drawn as reached may miss it: interior points come near limits, not to them."""

AT_END = 1e-6
"""Share of c² within which it is at an end of what a sample admits: ends that tie are right to 1e-7."""


@dataclass(frozen=True)
class LimitShares:
    """The limits of one kind.

    Attributes:
        kind: As in `mrts.limits.rows.RowName`.
        labels: A line each, the one that comes nearest to its limit first: `left/elbow`.
        share: Of its limit that each line uses, 1 at the limit, never below 0, Shape (N, lines).
    """

    kind: str
    labels: tuple[str, ...]
    share: Array

    @classmethod
    def ranked(cls, kind: str, labels: Sequence[str], share: Array) -> "LimitShares":
        """Lines in any order."""
        order = np.argsort(-np.max(share, axis=0), kind="stable")
        return cls(kind, tuple(labels[line] for line in order), share[:, order])

    @property
    def title(self) -> str:
        """What they are, for people."""
        return TITLES.get(self.kind, self.kind.capitalize())


def played(result: ScalingResult) -> ScaledTrajectory:
    """The trajectory of a result.

    Raises:
        ValueError: If there is none.
    """
    if result.trajectory is None:
        raise ValueError("there is no trajectory to draw")
    return result.trajectory


def limit_shares(done: ScaledTrajectory) -> list[LimitShares]:
    """The shares of all limits that there are, velocities also where their limits are reported only."""
    return shares_by_kind(*used_shares(done))


def shares_by_kind(names: Sequence[RowName], share: Array) -> list[LimitShares]:
    """The lines of every kind; the rows of one hand that fail alike make one."""
    found = []
    for kind in dict.fromkeys([*TITLES, *(name.kind for name in names)]):
        lines: dict[str, list[int]] = {}
        for row, name in enumerate(names):
            if name.kind == kind:
                label = name.failure or (f"{name.robot}/{name.element}" if name.robot else str(name))
                lines.setdefault(label, []).append(row)
        if lines:
            largest = [np.max(share[:, members], axis=1, initial=0.0) for members in lines.values()]
            found.append(LimitShares.ranked(kind, [*lines], np.column_stack(largest)))
    return found


def all_shares(result: ScalingResult) -> tuple[tuple[RowName, ...], Array]:
    """What is limited, rates included, and the share of its limit that each uses at each sample, Shape (N, r).

    Raises:
        ValueError: If there is no trajectory.
    """
    names, share = used_shares(played(result))
    rates = limited_rates(result)
    return (names, share) if rates is None else (names + rates.rows, np.hstack([share, rates.share]))


def setting_rows(
    result: ScalingResult, timing: "RetimingResult | None", names: Sequence[RowName]
) -> dict[RowName, str]:
    """What sets the speed, each with when; of a timing by falling share of the time.

    Of a constant factor it is the end of the range that it is at, of a timing what binds along its path. Another row
    that is at its limit need not set the speed: it may be there by how the load is distributed.

    Args:
        result: A result with a trajectory.
        timing: The timing whose retimed motion it is, if known.
        names: What is limited, rates included, as `all_shares` has it.
    """
    if timing is not None and timing.retimed is not None:
        return _of_timing(timing, names)
    return {} if result.origin else _of_range(result)  # what sets that of a retimed motion, its timing alone tells


def _of_timing(timing: "RetimingResult", names: Sequence[RowName]) -> dict[RowName, str]:
    """Its limits are told segment by segment, the two sides of a row apart; both do not bind at once."""
    segments = timing.segment_limits
    binds = np.array([[_binds(name, of_segment) for name in names] for of_segment, _ in segments], dtype=bool)
    share = np.array([time for _, time in segments]) @ binds
    says = "set the speed before it made room" if timing.made_room else "sets the speed"
    return {
        names[place]: f"{says} for {100 * share[place]:.3g} % of the time"
        for place in np.argsort(-share, kind="stable").tolist()
        if share[place] > 0
    }


def _binds(name: RowName, told: Sequence[ActiveRow | str]) -> bool:
    """Whether a row limits a timing; a smooth one names `rate of left/elbow torque` for its torque rate."""
    text, kind = str(name), name.kind.split()[-1]
    rate = f"{kind} of {text.removesuffix(f' {kind}')}" if kind in {"rate", "jerk"} else text
    return any(of in {text, rate} if isinstance(of, str) else of.name == name for of in told)


def _of_range(result: ScalingResult) -> dict[RowName, str]:
    words, told = {"lower": "c²⁻", "upper": "c²⁺"}, dict[RowName, str]()
    for side, end in result.range.ends_at(played(result).c2, AT_END):
        load = "" if end.load is None else f" with {end.load}"
        said = f"sets {words[side]} at {(end.time or 0.0) / sqrt(end.c2):.4g} s{load}"
        told |= dict.fromkeys((row.name for row in end.rows), said)
    return told
