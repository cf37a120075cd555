# SPDX-License-Identifier: MIT
"""The least reserve with which a plan survives its controller."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from math import inf
from types import NoneType
from typing import Any

from mrts.base.argument_types import Progress, check_callable, check_type
from mrts.base.errors import InputError
from mrts.base.printable import printable
from mrts.override.plan_nodes import trajectory_of
from mrts.scaling.result import ScalingResult
from mrts.simulation.controller import Controller, PlantErrors
from mrts.simulation.simulate import simulate
from mrts.timing.result import RetimingResult

Result = ScalingResult | RetimingResult

WITHIN = 0.01
"""Of the least reserve, as a share of limits."""

MOST_PLANS = 16
"""That are tried: four or five halve what the first few leave."""


@dataclass(frozen=True)
class TriedReserve:
    """A plan that was tried: its reserve, its duration, infinity without one [s], and the largest use of a limit."""

    reserve: float
    duration: float
    share: float
    limit: str
    kept: bool


@dataclass(frozen=True)
class ReserveSearch:
    """The plans that were tried, in that order, and the one with the least reserve that keeps all limits, if any."""

    found: Result | None
    tried: tuple[TriedReserve, ...]

    @property
    def reserve(self) -> float | None:
        """The least with which all limits are kept, to `WITHIN`; None if no plan does."""
        return min((each.reserve for each in self.tried if each.kept), default=None)

    def lines(self) -> Iterator[str]:
        """What came of it, and the table of the plans by their reserve."""
        if self.reserve is None:
            yield "reserve auto: no plan keeps all limits when the controller of `mrts simulate` plays it"
        else:
            yield (
                f"reserve auto: {100 * self.reserve:.3g} % of every limit, the least of {len(self.tried)} with which "
                "all are kept when the controller of `mrts simulate` plays the plan"
            )
        for each in sorted(self.tried, key=lambda each: each.reserve):
            told = f"{each.duration:.4g} s, uses {100 * each.share:.1f} % of {each.limit}" if each.limit else "no plan"
            yield printable(f"  {100 * each.reserve:5.1f} %  {told}")

    def to_json(self) -> list[dict[str, Any]]:
        """The plans by their reserve; null stands for what there is not."""
        return [
            {
                "reserve": each.reserve,
                "duration": each.duration if each.limit else None,
                "largest": each.share if each.limit else None,
                "limit": each.limit or None,
                "kept": each.kept,
            }
            for each in sorted(self.tried, key=lambda each: each.reserve)
        ]


def least_reserve(
    solve: Callable[[float], Result],
    controller: Controller | None = None,
    errors: PlantErrors | None = None,
    *,
    progress: Progress = lambda _done, _total: None,
) -> ReserveSearch:
    """Find the least reserve with which a plan keeps all limits in `mrts.simulate`, by bisection.

    Args:
        solve: Makes the plan with a reserve: `lambda reserve: mrts.retime(cell, motion, reserve=reserve)`.
        controller: As in `mrts.simulate`.
        errors: Likewise; each plan is played with them and with their opposite.
        progress: Told of the plans.

    Raises:
        InputError: As `solve` and `mrts.simulate`.
    """
    check_callable("solve", solve)
    check_callable("progress", progress)
    check_type("errors", errors, PlantErrors, NoneType)
    tried, best = list[TriedReserve](), None
    low, edge = 0.0, 1.0  # limits are passed at `low`; at `edge` they are kept, or there is no plan
    reserve, proportional = 0.0, 0.5
    while edge - low > WITHIN and len(tried) < MOST_PLANS:
        plan = solve(reserve)
        last = _tried(plan, reserve, controller, errors)
        tried.append(last)
        progress(len(tried), MOST_PLANS)
        if last.kept or not last.limit:
            edge, best = reserve, plan if last.kept else best
        else:
            low, proportional = reserve, 1 - (1 - reserve) / last.share + WITHIN
        reserve = min((low + edge) / 2, proportional)
    return ReserveSearch(best, tuple(tried))


def _tried(plan: Result, reserve: float, controller: Controller | None, errors: PlantErrors | None) -> TriedReserve:
    trajectory = trajectory_of(plan)
    if trajectory is None:
        return TriedReserve(reserve, inf, inf, "", kept=False)
    errors = PlantErrors() if errors is None else errors
    played = [simulate(trajectory, controller, each) for each in (errors, errors.opposite())]
    nearest = [used for one in played for _, used in one.uses[:1]]
    if not nearest:
        raise InputError("solve", "its cell has no limit that a reserve could be kept of.")
    worst = max(nearest, key=lambda use: use.share)
    kept = not any(one.passed for one in played)
    return TriedReserve(reserve, trajectory.duration, worst.share, str(worst.name), kept=kept)
