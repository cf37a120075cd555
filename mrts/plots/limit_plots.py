# SPDX-License-Identifier: MIT
"""How much of its limits a played motion uses along time, and which of them set its speed."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from mrts.base.arrays import Array
from mrts.limits.rows import RowName
from mrts.plots.colours import COLOURS
from mrts.plots.labels import contact_failure, short_name
from mrts.plots.plot import Axis, Cells, HeatMap, Item, Line, Panel, Plot, Rule, look, one_panel
from mrts.scaling.limit_use import limited_rate_kinds, limited_rates, used_shares
from mrts.scaling.range import SPEEDS, RangeEnd
from mrts.scaling.result import ScalingResult
from mrts.scaling.scaled_trajectory import ScaledTrajectory

if TYPE_CHECKING:
    from mrts.timing.result import RetimingResult

TITLES = {
    "torque": "Joint torques",
    "wrench": "Contact wrenches",
    "velocity": "Joint velocities",
    "contact": "Hands: friction, tilting, normal force",
    "motor speed": "Motor speeds",
    "torque-speed": "Torques at speed",
    "torque rate": "Rates of joint torques",
    "wrench rate": "Rates of contact wrenches",
    "jerk": "Joint jerks",
}
"""Of kinds of limits in the order of their pictures; others come after them by their own name."""

NAMED = 5
"""Limits of a kind with a colour and a name: those of which most is used."""

HIGHEST = 160.0
"""Per cent of limits up to which a picture reaches at most."""

MOST_ROWS = 24
"""Limits on the map, those of which most is used."""

MOST_TIMES = 200
"""Columns of the map; each has the largest use of the samples in it."""

MAP_COLORS = ("#fff", "#0072B2")
"""From 0 to 100 %; a dark page has dark for the first and light for the second."""

AT_LIMIT = 1e-4
"""Share of a limit by which what is drawn as reached may miss it: interior points come near limits, not to them."""

AT_END = 1e-6
"""Share of c² within which it is at an end of what a sample admits: ends that tie are right to 1e-7."""

AT_END_RETIMED = 1e-2
"""Share of c² within which it is at an end of what a sample of a retimed motion admits, where the acceleration is the
mean of before and after."""


@dataclass(frozen=True)
class LimitShares:
    """The limits of one kind.

    Attributes:
        kind: As in `mrts.limits.rows.RowName`.
        labels: A line each: `left/elbow`.
        share: Of its limit that each line uses, 1 at the limit, never below 0, Shape (N, lines).
    """

    kind: str
    labels: tuple[str, ...]
    share: Array

    @property
    def title(self) -> str:
        """What they are, for people."""
        return TITLES.get(self.kind, self.kind.capitalize())

    @property
    def largest(self) -> Array:
        """Of all lines at each sample, Shape (N,)."""
        largest: Array = np.max(self.share, axis=1)
        return largest

    @property
    def ranked(self) -> list[int]:
        """Lines, the one that comes nearest to its limit first."""
        return [int(line) for line in np.argsort(-np.max(self.share, axis=0), kind="stable")]


def limit_shares(done: ScaledTrajectory) -> list[LimitShares]:
    """The shares of all limits that there are, velocities also where their limits are reported only."""
    return _by_kind(*used_shares(done), lambda name: name.contact)


def _by_kind(names: Sequence[RowName], share: Array, together: Callable[[RowName], str]) -> list[LimitShares]:
    """The lines of every kind; rows that are named alike by `together` make one."""
    found = []
    for kind in dict.fromkeys([*TITLES, *(name.kind for name in names)]):
        lines: dict[str, list[int]] = {}
        for row, name in enumerate(names):
            if name.kind == kind:
                label = together(name) or (f"{name.robot}/{name.element}" if name.robot else str(name))
                lines.setdefault(label, []).append(row)
        if lines:
            largest = [np.max(share[:, members], axis=1, initial=0.0) for members in lines.values()]
            found.append(LimitShares(kind, tuple(lines), np.column_stack(largest)))
    return found


def all_shares(result: ScalingResult) -> tuple[tuple[RowName, ...], Array]:
    """What is limited, rates included, and the share of its limit that each uses at each sample, Shape (N, r).

    Raises:
        ValueError: If there is no trajectory.
    """
    if result.trajectory is None:
        raise ValueError("there is no trajectory to draw")
    names, share = used_shares(result.trajectory)
    shares = [share]
    for kind in limited_rate_kinds(result):
        for robot in result.cell.robots:
            rates = limited_rates(result, kind, robot.name)
            rates = rates.only(np.isfinite(rates.upper[0]).tolist())
            names, shares = names + rates.rows, [*shares, np.abs(rates.values) / rates.upper]
    return names, np.hstack(shares)


def limits_plot(result: ScalingResult, title: str, without: Sequence[str] = ()) -> Plot:
    """How much of its limits the motion uses along time [%], a panel for each kind.

    Args:
        result: A result with a trajectory.
        title: Above it.
        without: Kinds that are left out.

    Raises:
        ValueError: If there is no trajectory.
    """
    kinds = _by_kind(*all_shares(result), contact_failure)
    panels = [_percent_panel(of, result) for of in kinds if of.kind not in without]
    return Plot(
        name="limits", title=title, rows=[panels[at : at + 2] for at in range(0, len(panels), 2)], clock="played"
    )


def _percent_panel(of: LimitShares, result: ScalingResult) -> Panel:
    """The limit of which most is used first and thick, the others of little use grey."""
    assert result.trajectory is not None  # noqa: S101 (checked by its callers)
    time, percent = result.trajectory.time, 100 * of.share
    steps = of.kind in {"torque rate", "wrench rate", "jerk"}
    items: list[Item] = [
        Line(x=time, y=percent[:, line], color="#bbb", width=0.8, unit=None, steps=steps) for line in of.ranked[NAMED:]
    ]
    for place, line in enumerate(of.ranked[:NAMED]):
        label = f"{of.labels[line]}: {np.max(percent[:, line]):.3g} %"
        items.append(Line(x=time, y=percent[:, line], label=label, unit="%", steps=steps, width=1.2 if place else 2.8,
                          **look(place)))  # fmt: skip
    items.append(Rule(at=100.0, color=COLOURS[1], dash=1))
    top = 1.06 * min(max(100.0, float(np.max(percent))), HIGHEST)
    time_axis = Axis(label="time [s]", ends=(float(time[0]), float(time[-1])), hover="t = {} s")
    return Panel(title=of.title, x=time_axis, y=Axis(label="of the limit [%]", ends=(0.0, top)), items=items)


def limit_map(result: ScalingResult, limiting: "LimitingRows") -> Plot:
    """Per cents of the limits of which most is used, all along the motion; those that set the speed come first.

    Raises:
        ValueError: If there is no trajectory.
    """
    names, shares = all_shares(result)
    assert result.trajectory is not None  # noqa: S101 (else there are no shares)
    time, most = result.trajectory.time, np.max(shares, axis=0)
    first = {name: place for place, name in enumerate(limiting.setting)}
    rows: dict[str, list[int]] = {}
    for row in sorted(range(len(names)), key=lambda row: (first.get(names[row], len(first)), -most[row])):
        rows.setdefault(short_name(names[row]), []).append(row)
    shown = dict(list(rows.items())[:MOST_ROWS])

    def largest(values: Array) -> tuple[Array, Array]:
        """Edges of the columns, and of each row and column the largest value."""
        edges, columns = _columns(time, np.stack([np.max(values[:, members], axis=1) for members in shown.values()], 1))
        return edges, columns.T

    edges, percent = largest(100 * shares)
    at_limit = shares >= 1 - AT_LIMIT
    codes = np.where(at_limit, np.where(limiting.forced, 1.0, 0.0), -1.0)
    grid: dict[str, Any] = {"x": edges, "y": np.arange(len(shown) + 1, dtype=np.float64) - 0.5}
    reached = Cells(
        **grid,
        code=largest(codes)[1].astype(int),
        names=("at the limit through the distribution", "at the limit where the speed is set"),
        colors=(COLOURS[4], COLOURS[1]),
    )
    used = HeatMap(**grid, z=percent, colors=MAP_COLORS, low=0.0, high=100.0, title="of the limit [%]", unit="%")
    panel = Panel(
        title="Per cent of limits along the motion",
        x=Axis(label="time [s]", ends=(float(time[0]), float(time[-1]))),
        y=Axis(names=list(shown), strong=[names[members[0]] in first for members in shown.values()]),
        items=[used, reached],
    )
    return one_panel("limit-map", panel, "played")


def _columns(time: Array, shares: Array) -> tuple[Array, Array]:
    """Edges of columns of about one width, and the largest share of the samples that touch each."""
    count = min(len(time) - 1, MOST_TIMES)
    starts = np.unique(np.searchsorted(time, np.linspace(time[0], time[-1], count + 1)[:-1], side="right") - 1)
    edges = np.append(time[starts], time[-1])
    ends = np.append(starts[1:], len(time) - 1)
    largest = [np.max(shares[start : end + 1], axis=0) for start, end in zip(starts, ends, strict=True)]
    return edges, np.stack(largest)


@dataclass(frozen=True)
class LimitingRows:
    """What is to be said of limits that are reached.

    Attributes:
        setting: Rows that set the speed, each with when; those of a timing by falling share of the time.
        reached: Others that are at their limit, each with why.
        forced: At which samples the speed keeps a row at its limit, of those of `all_shares`, Shape (N, r).
    """

    setting: dict[RowName, str]
    reached: dict[RowName, str]
    forced: NDArray[np.bool_]


def limiting_rows(result: ScalingResult, timing: "RetimingResult | None") -> LimitingRows:
    """What sets the speed: of a constant factor the end of the range that it is at, of a timing all along its path.

    A row that is at its limit where c² lies inside the range of its sample need not be there: with another
    distribution the motion could be faster and slower there.

    Args:
        result: A result with a trajectory.
        timing: The timing whose retimed motion it is, if known.

    Raises:
        ValueError: If there is no trajectory.
    """
    names, shares = all_shares(result)
    assert result.trajectory is not None  # noqa: S101 (else there are no shares)
    if timing is not None and timing.retimed is not None:
        forced, setting = _of_timing(timing, names)
    else:
        forced, binding = _forced(result, names)
        setting = {name: "sets the speed" for name in names if name in binding} if result.origin else _of_range(result)
    at_limit = shares >= 1 - AT_LIMIT
    reached = {}
    for place in np.flatnonzero(np.any(at_limit, axis=0)).tolist():
        if names[place] not in setting:
            kept = bool(np.any(at_limit[:, place] & forced[:, place]))
            reached[names[place]] = "reached where the speed is set" if kept else "reached through the distribution"
    return LimitingRows(setting, reached, forced)


def _of_timing(timing: "RetimingResult", names: Sequence[RowName]) -> tuple[NDArray[np.bool_], dict[RowName, str]]:
    """Its limits are told by name, segment by segment, the two sides of a row apart; both do not bind at once."""
    segments = timing.segment_limits
    binds = np.array([[_binds(name, of_segment) for name in names] for of_segment, _ in segments], dtype=bool)
    share = np.array([time for _, time in segments]) @ binds
    setting = {
        names[place]: f"sets the speed for {100 * share[place]:.3g} % of the time"
        for place in np.argsort(-share, kind="stable").tolist()
        if share[place] > 0
    }
    return np.vstack([binds[:1], binds]) | np.vstack([binds, binds[-1:]]), setting


def _binds(name: RowName, told: Sequence[str]) -> bool:
    """Whether a row is among limits as a timing tells them: `rate of left/elbow torque` for its torque rate."""
    text, kind = str(name), name.kind.split()[-1]
    rate = f"{kind} of {text.removesuffix(f' {kind}')}" if kind in {"rate", "jerk"} else text
    return any(of in {text, rate} or of.startswith(f"{text} (") for of in told)


def _of_range(result: ScalingResult) -> dict[RowName, str]:
    assert result.trajectory is not None  # noqa: S101 (its caller has a trajectory)
    words = {"lower": "c²⁻", "upper": "c²⁺"}
    ends = result.range.ends_at(result.trajectory.c2, AT_END)
    return {row.name: _words(end, words[side]) for side, end in ends for row in end.rows}


def _words(end: RangeEnd, word: str) -> str:
    load = "" if end.load is None else f" with {end.load}"
    return f"sets {word} at {end.time:.4g} s of the given motion{load}"


def _forced(result: ScalingResult, names: tuple[RowName, ...]) -> tuple[NDArray[np.bool_], set[RowName]]:
    """`LimitingRows.forced` of c² at an end of what its sample admits, and all rows that set an end at which c² is.

    Where velocities alone set the end, no torque or wrench has to be at a limit; else all that are may have to be.
    """
    found, done = result.range, result.trajectory
    assert done is not None  # noqa: S101 (its caller has a trajectory)
    near = AT_END_RETIMED if result.origin else AT_END
    at_lower = (found.samples.lower > 0) & (found.samples.lower >= done.c2 * (1 - near))
    at_upper = found.samples.upper <= done.c2 * (1 + near)
    forced, rows = np.zeros((len(found.samples.time), len(names)), dtype=bool), set()
    for sample in np.flatnonzero(at_lower | at_upper).tolist():
        binding = {row.name for row in found.binding(sample, "upper") if at_upper[sample]}
        binding |= {row.name for row in found.binding(sample, "lower") if at_lower[sample]}
        of_load = any(name.kind not in SPEEDS for name in binding)
        forced[sample] = [of_load or name in binding for name in names]
        rows |= binding
    return forced, rows
