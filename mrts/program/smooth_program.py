# SPDX-License-Identifier: MIT
"""A path with rows whose values and rates of change are limited: what is solved for a smooth timing."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import compress
from operator import itemgetter
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from mrts.base.arrays import Array, with_part
from mrts.cell.cell import Cell
from mrts.following.coordinated_motion import CoordinatedMotion
from mrts.kernel.binding import filled, structure
from mrts.limits.rows import RowName, circle, joint_rows, polygons, wrench_rows
from mrts.program.motion_rows import motor_terms
from mrts.program.rate_limits import RateLimits
from mrts.program.sample_problem import SampleProblem, moved_by

OF_ROWS = ("square", "rate", "root", "offset", "lower", "upper", "low", "high", "change", "weight", "sizes")
"""Attributes whose last axis are the rows."""

PROGRAM = structure("smooth_timing.c", "mrts_smooth_program")
AS_THEY_ARE = ("step", "gram", "bound", "q1", "q2", "q3", "jerk")
"""Attributes that C takes as they are."""
ABSENT = dict.fromkeys(("square", "rate", "root", "offset", "low", "high", "weight"), 0.0)
ABSENT |= {"lower": -np.inf, "upper": np.inf}
"""Attributes of rows that C takes, as they are of a row that does not count."""
SELDOM = "root", "weight"
"""What is null where it is 0."""
LANES = 4
"""C takes so many rows at a time, `MRTS_LANES` of lane_types.h."""
ENDS = ("given_start", "given_end", "held_start", "held_end")
"""Whether x and F are given at the ends, as C has them."""


def segment_times(step: Array, x: Array, rise: Array | None = None) -> Array:
    """Duration of each segment, Shape (n - 1,) [s]; infinity where both ends stand still.

    With v = ṡ at its ends it is 2 Δs / (v_0 + v_1) artanh(z) / z with z² = Δs (s̈_1 - s̈_0) / (v_0 + v_1)², the time
    that s̈ = a s + b takes, and arctan where z² < 0.

    Args:
        step: Length of each segment, Shape (n - 1,).
        x: ṡ² at its ends, Shape (n,).
        rise: By how much s̈ rises along each segment, Shape (n - 1,); None where s̈ is constant on all.
    """
    speed = np.sqrt(x)
    with np.errstate(divide="ignore", invalid="ignore"):  # of all elements: of some numpy finds them one by one
        duration: Array = 2 * step / (speed[:-1] + speed[1:])
        if rise is not None and rise.any():
            share = stop_share(step, x, rise)
            z = np.sqrt(np.abs(share))
            duration *= np.where(share == 0, 1.0, np.where(share > 0, np.arctanh(z), np.arctan(z)) / z)
    return duration


def stop_share(step: Array, x: Array, rise: Array) -> Array:
    """The rise of s̈ on each segment as a share of that with which it would come to rest inside, Shape (n - 1,)."""
    speed = np.sqrt(x)
    with np.errstate(divide="ignore", invalid="ignore"):
        share: Array = np.where(rise == 0, 0.0, step * rise / np.square(speed[:-1] + speed[1:]))
    return share


@dataclass(frozen=True, kw_only=True, eq=False)
class SmoothProgram:
    """Limits along a path σ with n nodes, on x = σ̇², u = σ̈ and free unknowns F (contact wrenches) at each of them.

    Between nodes u is linear in σ, so x_{k+1} = x_k + h_k (u_k + u_{k+1}) exactly. At node k row j has the value
    v = square x + rate u + root √x + free F + offset, and

        lower <= v_k + low s, v_k - high s <= upper                     at every node
        √(zᵀ gram z) <= bound z with z = (u, x, 1)                      at every node, of each cone
        |v_{k+1} - v_k| <= change Δt_k                                  on every segment
        |q' (u_{k+1} - u_k) / h_k + 3 q'' u + q''' x| <= jerk / √x      at both ends of every segment

    with Δt_k = 2 h_k / (√x_k + √x_{k+1}). Rows are in units in which their limits have the size 1. The last of F is a
    share s in programs of `of_shares` alone.

    Attributes:
        step: h, Shape (n - 1,).
        square: Shape (n, r).
        rate: Shape (n, r).
        root: Shape (n, r).
        offset: Shape (n, r).
        free: Shape (n, r, f); f may be 0.
        lower: -infinity where there is none, Shape (n, r).
        upper: infinity where there is none, Shape (n, r).
        change: Infinity where there is none, Shape (r,) [1/s].
        weight: Weight of v² in the effort ∫ τᵀWτ dt = Σ_k ω_k Σ_j weight v² / √x_k, with ω the trapezoidal rule,
            Shape (r,).
        sizes: What 100 % of the lower and of the upper side of each row is where its share counts in a reserve, 0
            where it does not, Shape (2, r).
        q1: q' of the joints whose jerk is limited, Shape (n, J).
        q2: q'' of them, Shape (n, J).
        q3: q''' of them at the start and at the end of every segment, Shape (n - 1, 2, J).
        jerk: Shape (J,).
        gram: Of c cones, Shape (n, c, 3, 3).
        bound: Of them, Shape (n, c, 3); the last of each is infinite at nodes without it.
        names: Names of the rows, and then of the cones.
        jerk_names: Names of the jerks that are limited.
        low: By how much s = 1 moves the lower side of a row, Shape (n, r); None where there is no s.
        high: As low, of the upper side.
        ends: x at the first and the last node where it is given, else None.
        end_free: F at the first and the last node, Shape (f,), where it is given, else None.
    """

    step: Array
    square: Array
    rate: Array
    root: Array
    offset: Array
    free: Array
    lower: Array
    upper: Array
    change: Array
    weight: Array
    sizes: Array
    q1: Array
    q2: Array
    q3: Array
    jerk: Array
    gram: Array
    bound: Array
    names: tuple[RowName, ...] = ()
    jerk_names: tuple[RowName, ...] = ()
    low: Array | None = None
    high: Array | None = None
    ends: tuple[float | None, float | None] = (None, None)
    end_free: tuple[Array | None, Array | None] = (None, None)

    @cached_property
    def in_turn(self) -> tuple[NDArray[np.int_], NDArray[np.int_]]:
        """The rows as C takes them, those whose change is limited first, and those that do nothing but bound x."""
        limited, moved = np.isfinite(self.change), np.any(self.free, axis=(0, 2))
        others = limited | moved | np.any(self.rate, axis=0) | np.any(self.root, axis=0) | (self.weight != 0)
        bounds = np.all(np.isneginf(self.lower) & (self.upper > self.offset) & (self.square >= 0), axis=0)
        order = np.argsort(~limited, kind="stable")
        caps = (bounds & ~others)[order]
        return order[~caps], order[caps]

    @cached_property
    def in_c(self) -> Any:
        """The `mrts_smooth_program` without what is asked of it; what is absent is null.

        What bounds x alone is one row, the tightest of them at each node; rows without limits fill the lanes.
        """
        kept, caps = self.in_turn
        last, r, (n, f) = len(kept), -(-(len(kept) + min(len(caps), 1)) // LANES) * LANES, self.free[:, 0].shape
        rows, entry, used = self.rows_in(kept, r), np.zeros((n, f, r)), np.zeros((r, f), dtype=bool)
        if caps.size:
            rows["square"][:, last] = np.max(self.square[:, caps] / (self.upper - self.offset)[:, caps], axis=1)
            rows["upper"][:, last] = 1.0
        entry[:, :, :last] = self.free[:, kept].swapaxes(1, 2)
        used[:last] = np.any(self.free[:, kept], axis=0)
        used = np.any(used.reshape(r // LANES, LANES, f), axis=1)  # from the first column of some rows to their last
        end = np.max(used * np.arange(1, f + 1), axis=1, initial=0)
        first = np.minimum(np.min(np.where(used, np.arange(f), f), axis=1, initial=f), end)
        limited, (cones, jerks) = np.count_nonzero(np.isfinite(self.change)), (self.gram.shape[1], len(self.jerk))
        sizes = {"nodes": n, "rows": r, "free": f, "cones": cones, "changes": limited, "jerks": jerks}
        columns = {"first": first, "count": end - first, "entry": entry, "change": self.change[kept[:limited]]}
        ends = {name: of is not None for name, of in zip(ENDS, (*self.ends, *self.end_free), strict=True)}
        as_they_are = {name: getattr(self, name) for name in AS_THEY_ARE}
        rows |= {name: None for name in SELDOM if not np.any(rows[name])}
        return filled(PROGRAM, **as_they_are, **rows, **sizes, **columns, **ends)

    def rows_in(self, kept: NDArray[np.int_], count: int) -> dict[str, Any]:
        """Attributes of some rows, and behind them of as many that do not count as make `count`."""
        rows = dict[str, Any]()
        for name, absent in ABSENT.items():
            given = getattr(self, name)
            if given is not None:
                rows[name] = np.full((*given.shape[:-1], count), absent)
                rows[name][..., : len(kept)] = given[..., kept]
        return rows

    def narrowed(self, share: float) -> Self:
        """The same program with limits further in by a share, at most a quarter of what is between."""
        inward = np.minimum(share, (self.upper - self.lower) / 4)
        return replace(
            self,
            lower=self.lower + inward,
            upper=self.upper - inward,
            change=self.change * (1 - share),
            jerk=self.jerk * (1 - share),
            bound=self.bound - share * np.eye(3)[2],
        )

    def of_free(self) -> Self:
        """The same program with the rows alone that F moves: x and u keep the others and limits of jerk, or not."""
        moved = np.any(self.free, axis=(0, 2))
        return with_part(
            self,
            OF_ROWS,
            (..., moved),
            free=self.free[:, moved],
            names=tuple(compress(self.names, moved)),
            gram=self.gram[:, :0],
            bound=self.bound[:, :0],
            **{name: getattr(self, name)[..., :0] for name in ("q1", "q2", "q3", "jerk")},
            jerk_names=(),
        )

    def values(self, x: Array, u: Array, free: Array) -> Array:
        """Values v of every row, Shape (n, r)."""
        moved = self.square * x[:, None] + self.rate * u[:, None] + self.root * np.sqrt(x)[:, None] + self.offset
        values: Array = moved + (self.free @ free[:, :, None])[:, :, 0]
        return values

    @property
    def spacing(self) -> Array:
        """ω of the trapezoidal rule over the nodes, Shape (n,)."""
        return np.convolve(self.step, [0.5, 0.5])

    def duration(self, x: Array) -> float:
        """Σ Δt [s]."""
        return float(np.sum(segment_times(self.step, x)))

    def jerks(self, x: Array, u: Array) -> Array:
        """q⃛ at the start and at the end of every segment, Shape (n - 1, 2, J)."""
        segment = np.arange(len(self.step))
        ends = np.stack([segment, segment + 1], axis=1)
        slope, u, x = (np.diff(u) / self.step)[:, None, None], u[ends][..., None], x[ends][..., None]
        jerks: Array = (self.q1[ends] * slope + 3 * self.q2[ends] * u + self.q3 * x) * np.sqrt(x)
        return jerks

    def effort(self, profile: "SmoothProfile") -> float:
        """Σ_k ω_k Σ_j weight v² / √x_k, ∫ τᵀWτ dt."""
        x = profile.x
        return float(np.sum(self.spacing / np.sqrt(x) * (self.values(x, profile.u, profile.free) ** 2 @ self.weight)))

    def beyond(self, profile: "SmoothProfile") -> tuple[Array, Array, Array]:
        """By what share of a limit each is passed, below 0 where it is kept.

        Returns:
            Of rows and of cones at the nodes, Shape (n, r + c), infinitely little at nodes without a cone; of changes
            on the segments, Shape (n - 1, r), and of jerks, Shape (n - 1, J).
        """
        x, u = profile.x, profile.u
        values, z = self.values(x, u, profile.free), np.column_stack([u, x, np.ones(len(x))])
        square = np.einsum("ni,ncij,nj->nc", z, self.gram, z)
        cones = np.sqrt(np.maximum(square, 0.0)) - np.sum(self.bound * z[:, None], axis=2)
        above, below = values - self.upper, self.lower - values
        if self.low is not None and self.high is not None:
            share = profile.free[:, -1:]
            above, below = above - self.high * share, below - self.low * share
        rows = np.concatenate([np.maximum(above, below), cones], axis=1)
        changes = np.abs(np.diff(values, axis=0)) / (self.change * segment_times(self.step, x)[:, None]) - 1
        return rows, changes, np.max(np.abs(self.jerks(x, u)), axis=1) / self.jerk - 1

    def binding(self, profile: "SmoothProfile", near: float) -> list[set[RowName]]:
        """What is within a share `near` of its limit at an end of every segment or on it."""
        at, changing, jerking = (passed >= -near for passed in self.beyond(profile))
        found: list[set[RowName]] = [set() for _ in self.step]
        rates = [name.rate for name in self.names]
        for binds, names in ((at[:-1] | at[1:], self.names), (changing, rates), (jerking, self.jerk_names)):
            for segment, place in np.argwhere(binds).tolist():
                found[segment].add(names[place])
        return found

    def excess(self, profile: "SmoothProfile") -> float:
        """The most by which a row, a change or a jerk passes its limit, as a share of it; <= 0 if all are kept."""
        return float(np.max(np.concatenate([*map(np.ravel, self.beyond(profile))])))

    def keeps(self, profile: "SmoothProfile", tolerance: float) -> bool:
        """Whether a profile moves and passes no limit by more than a share of it."""
        return bool(np.all(profile.x > 0)) and self.excess(profile) <= tolerance


@dataclass(frozen=True)
class Goal:
    """What a timing is to be: the least of time · duration + effort · effort + uneven · Σ (Δu)² / h, within a duration.

    With a room it is one that takes by that share longer at most, with the least ∫ s² dt of `of_shares`.

    Attributes:
        time: Weight of the duration [1/s].
        effort: Weight of the effort; 0 leaves it out.
        longest: Largest duration, None for any [s].
        uneven: Weight of the jumps of u between nodes: without any, u may jump to and fro where x stands at a limit.
        room: Share of the least duration.
    """

    time: float = 1.0
    effort: float = 0.0
    longest: float | None = None
    uneven: float = 0.0
    room: float = 0.0


LEAST_EFFORT = Goal(time=0.0, effort=1.0)
"""Of the torques at a given timing, and of a timing within a duration."""


@dataclass(frozen=True)
class SmoothProfile:
    """x, u and F at n nodes.

    Attributes:
        x: σ̇², Shape (n,).
        u: σ̈, Shape (n,).
        free: Shape (n, f).
    """

    x: Array
    u: Array
    free: Array


LEAST_SHARE = 0.01
"""Share of a limit that torques may always use: they are not asked to keep more than 99 % of it free."""

SHARE = RowName("share of the limits")
"""Name of the row of s."""

FROM_REST = 1.5
"""|σ̈| of the first two nodes of a path from rest, as a multiple of σ̇² over the length of the path in σ: a constant jerk
needs 1 there, and more only overstepped limits inside the first segment, whose ends do not show it."""

START = RowName("constant jerk from rest")

BETWEEN_NODES = RowName("speed between nodes")

SAME_ROW = 1e-12
"""Share by which the row of a limit may differ from that of a torque whose rate is limited: rounding."""


def path_program(
    cell: Cell,
    path: CoordinatedMotion,
    problems: Sequence[SampleProblem],
    rates: RateLimits,
    weights: Array | None = None,
    ends: tuple[float | None, float | None] = (None, None),
    end_free: tuple[Array | None, Array | None] = (None, None),
    third: Array | None = None,
    sizes: Array | None = None,
) -> SmoothProgram:
    """One program over all nodes of a path, for all loads at once: x and u in common, wrenches for each.

    Rates are those of torques without dry friction, which steps where a joint turns back or leaves rest: no timing
    changes that, and as a change from node to node it would allow the less speed the more nodes there are.

    Args:
        cell: The cell.
        path: q, q', q'' at n nodes, with σ for time.
        problems: Rows of [F, u, x] at the nodes, one a load.
        rates: Limits of torque rates, wrench rates and jerk.
        weights: W of the effort, Shape (m, m); None where no effort is asked for.
        ends: x at the first and the last node where it is given.
        end_free: [F] of all loads there, likewise. There the cell is at rest, so that rows have one value: whether it
            keeps its limits is the caller's question.
        third: q''' at both ends of every segment, Shape (n - 1, 2, m); None takes it from q' and q'' at the nodes.
        sizes: `counted_sizes` of the rows of a problem that are no sides of polygons, Shape (2, r); None where nothing
            is to be kept in reserve.
    """
    gram, bound, circles = _circles(problems[0])  # they are the same for all loads
    parts, names, free = list[dict[str, Array]](), list[RowName](), problems[0].unknowns - 2
    for place, problem in enumerate(map(without_polygons, problems)):
        rows, of_load = _load_rows(cell, path, problem, rates, weights, sizes)
        others = place * free, (len(problems) - 1 - place) * free
        rows["free"] = np.pad(rows["free"], ((0, 0), (0, 0), others))
        if place:  # what bounds x alone, whatever the load, stands once
            caps = np.flatnonzero(problem.is_cap)
            rows["lower"][:, caps], rows["upper"][:, caps] = -np.inf, np.inf
        parts.append(rows)
        names += of_load
    rests = ends[0] is None, ends[1] is None
    parts.append(_path_rows(path.object.time, np.abs(problems[0].cap_share), free * len(problems), rests))
    joined = {name: np.concatenate([*map(itemgetter(name), parts)], axis=1) for name in parts[0]}
    joined["change"], joined["weight"] = joined["change"][0], joined["weight"][0]
    for place, held in zip((0, -1), end_free, strict=True):
        if held is not None:
            joined["lower"][place], joined["upper"][place], bound[place, :, 2] = -np.inf, np.inf, np.inf
    limited, step = np.flatnonzero(np.isfinite(rates.jerk)), np.diff(path.object.time)
    return SmoothProgram(
        step=step,
        **joined,
        q1=path.dq[:, limited],
        q2=path.ddq[:, limited],
        q3=(third_derivatives(step, path.dq, path.ddq) if third is None else third)[..., limited],
        jerk=rates.jerk[limited],
        gram=gram,
        bound=bound,
        names=(*names, START, START, BETWEEN_NODES, *circles),
        jerk_names=tuple(compress(joint_rows(cell, "jerk", "position_units", "/s³"), np.isfinite(rates.jerk))),
        ends=ends,
        end_free=end_free,
    )


def without_polygons(problem: SampleProblem) -> SampleProblem:
    """A problem without the rows that are sides of polygons."""
    kept = np.flatnonzero([not name.sides for name in problem.names])
    return problem if len(kept) == len(problem.names) else problem.only(kept)


def _circles(problem: SampleProblem) -> tuple[Array, Array, list[RowName]]:
    """The cones of the polygons of a problem, as attributes of `SmoothProgram`, and their names."""
    of_polygons, n = polygons(problem.names), problem.samples
    gram, bound = np.zeros((n, len(of_polygons), 3, 3)), np.zeros((n, len(of_polygons), 3))
    for place, (name, own) in enumerate(of_polygons.items()):
        terms = np.stack([problem.rate[:, own], problem.square[:, own]], axis=2)
        sides = [
            np.concatenate([sign * terms, -sign * limit[:, own, None]], axis=2)
            for sign, limit in ((1, problem.upper), (-1, problem.lower))
            if np.all(np.isfinite(limit[:, own]))
        ]
        gram[:, place], bound[:, place] = circle(np.concatenate(sides, axis=1), name.sides)
    return gram, bound, list(of_polygons)


def third_derivatives(step: Array, dq: Array, ddq: Array) -> Array:
    """Third derivatives at both ends of every segment of `velocity_polynomials`, Shape (n - 1, 2, m)."""
    h = step[:, None]
    rise, start, end = 6 * np.diff(dq, axis=0) / h**2, ddq[:-1] / h, ddq[1:] / h
    return np.stack([rise - 4 * start - 2 * end, -rise + 2 * start + 4 * end], axis=1)


def _load_rows(
    cell: Cell,
    path: CoordinatedMotion,
    problem: SampleProblem,
    rates: RateLimits,
    weights: Array | None,
    sizes: Array | None,
) -> tuple[dict[str, Array], list[RowName]]:
    """Rows of one load as attributes of `SmoothProgram`, with limits of rates and weights of squares, and their names.

    A torque or wrench component whose rate or square counts is the row of its own limits, moved by its offset. Where it
    has none, and where another offset would change how fast a row with a limited rate changes, it is one row more.
    """
    names, r, m = list(problem.names), len(problem.unit), len(rates.torque)
    torque, wrench = joint_rows(cell, "torque", "torque_units"), wrench_rows(cell, "wrench")
    motors, nothing = motor_terms(cell, path), np.zeros_like(problem.wrench_offset)
    torque_root = np.zeros_like(problem.torque_offset) if problem.torque_speed is None else problem.torque_speed
    without_dry = problem.torque_offset - (0.0 if motors is None else motors.dry)
    column = np.concatenate([problem.torque_map, problem.wrench_map], axis=1)
    of_both = column, np.hstack([torque_root, nothing]), np.hstack([without_dry, problem.wrench_offset])
    most = np.append(rates.torque, rates.wrench)
    counted = [((*torque, *wrench), *of_both, most, np.zeros_like(most))]
    if weights is not None:  # τᵀWτ, of the torques themselves if W is diagonal, else of Lᵀτ with W = L Lᵀ
        squares, of_torque = np.diag(weights), (problem.torque_map, torque_root, problem.torque_offset)
        if np.count_nonzero(weights - np.diag(squares)):
            turn, squares, torque = np.linalg.cholesky(weights).T, np.ones(m), (RowName("torques in the effort"),) * m
            of_torque = turn @ problem.torque_map, torque_root @ turn.T, problem.torque_offset @ turn.T
        counted.append((torque, *of_torque, np.full(m, np.inf), squares))

    at_end = (0, sum(len(of[0]) for of in counted))  # room for what is no row yet
    A, unit = np.pad(problem.A, ((0, 0), at_end, (0, 0))), np.pad(problem.unit, at_end, constant_values=1.0)
    lower = np.pad(problem.lower, ((0, 0), at_end), constant_values=-np.inf)
    upper = np.pad(problem.upper, ((0, 0), at_end), constant_values=np.inf)
    root, offset = np.zeros((2, *lower.shape))
    root[:, :r] = 0.0 if problem.speed is None else problem.speed
    change, weight = np.full(len(unit), np.inf), np.zeros(len(unit))
    for named, column, own_root, own, most, square in counted:
        of, place = np.flatnonzero(np.isfinite(most) | (square != 0)), {name: row for row, name in enumerate(names)}
        row = np.array([place.get(named[j], -1) for j in of.tolist()], dtype=int)
        moved, missed = own[:, of] / unit[row] - offset[:, row], np.abs(A[:, row] * unit[row, None] - column[:, of])
        alike = np.max(missed, axis=(0, 2)) <= SAME_ROW * np.max(np.abs(column[:, of]), axis=(0, 2))
        steady = np.isinf(change[row]) | (np.ptp(moved, axis=0) <= SAME_ROW * np.max(np.abs(moved), axis=0))
        more = (row < 0) | ~alike | ~steady
        j = of[more]
        row[more] = added = np.arange(len(names), len(names) + len(j))
        names += [named[one] for one in j.tolist()]
        unit[added] = np.where(np.isfinite(most[j]), most[j], 1.0)
        A[:, added], root[:, added] = column[:, j] / unit[added, None], own_root[:, j] / unit[added]
        moved[:, more] = own[:, j] / unit[added]
        for limit in (lower, upper, offset):
            limit[:, row] += moved
        change[row] = np.minimum(change[row], most[of] / unit[row])
        weight[row] += square[of] * unit[row] ** 2
    rows = {"square": A[:, :, -1], "rate": A[:, :, -2], "free": A[:, :, :-2], "root": root, "offset": offset}
    rows |= {"lower": lower, "upper": upper, "change": change[None], "weight": weight[None]}
    rows["sizes"] = np.pad(np.zeros((2, r)) if sizes is None else sizes, ((0, 0), at_end))
    return {name: of_rows[:, : len(names)] for name, of_rows in rows.items()}, names


def _path_rows(sigma: Array, share: Array, free: int, rests: tuple[bool, bool]) -> dict[str, Array]:
    """Rows of the speed along the path alone, as `_load_rows`: twice `START`, then `BETWEEN_NODES`.

    At rest |σ̈| <= FROM_REST σ̇² / length at the first two and the last two nodes: at such an end no torque depends on
    σ̇: its rows leave σ̇ free, and a profile that falls within the first segment would gain time by a jerk that rows at
    nodes do not see. Elsewhere σ̇² + h σ̈ >= 0 with the step h that follows. That is the middle one of the three
    Bernstein coefficients of σ̇² on a segment, its ends are the others, and a polynomial is positive where they are.

    The control points of x, a quadratic spline, keep the limits of speed: then so does all of x. Without it x could
    stand at its limit at the nodes and u jump to and fro between them at no cost.
    """
    n, step = len(sigma), np.diff(sigma)
    rate, square, nothing, upper = np.zeros((n, 3)), np.zeros((n, 3)), np.zeros((n, 3)), np.full((n, 3), np.inf)
    rate[:-1, 1], square[:-1, 1], upper[:-1, 1] = -step, -1.0, 0.0
    nodes = np.array([0, 1, n - 2, n - 1])[np.repeat(rests, 2)]
    rate[nodes, :2] = np.array([1.0, -1.0]) * sigma[-1] / FROM_REST
    square[nodes, :2], upper[nodes, :2] = -1.0, 0.0
    if share.shape[1]:
        square[:-1, 2] = np.max((share[:-1] + share[1:]) / 2, axis=1)
        rate[:-1, 2], upper[:-1, 2] = square[:-1, 2] * step, 1.0
    rows = {"square": square, "rate": rate, "free": np.zeros((n, 3, free)), "root": nothing, "offset": nothing}
    rows |= {"lower": np.full((n, 3), -np.inf), "upper": upper, "change": np.full((1, 3), np.inf)}
    return rows | {"weight": np.zeros((1, 3)), "sizes": np.zeros((2, 3))}


def whole_sides(free: Array, sizes: Array) -> Array:
    """By how much limits move inward of which nothing may be used, Shape (2, N, r); 0 for rows no distribution moves.

    `free` are the columns of what a distribution chooses, Shape (N, r, f), `sizes` from `counted_sizes`.
    """
    return sizes[:, None] * moved_by(free)


def of_shares(program: SmoothProgram) -> SmoothProgram:
    """The program with the largest share s of any limit at each node as the last free unknown, and ∫ s² dt as effort.

    Each node has an s of its own, so that a place that needs all of a limit loosens no other; the square lets a tall
    one count more than a wide one. Sides that count may use s of themselves. The last row is s itself.
    """
    (low, high), r = whole_sides(program.free, program.sizes), len(program.weight)
    moved = replace(program, lower=program.lower + low, upper=program.upper - high, low=low, high=high)
    rows, free = moved.rows_in(np.arange(r), r + 1), np.pad(program.free, ((0, 0), (0, 1), (0, 1)))
    rows["lower"][:, -1], rows["upper"][:, -1], free[:, -1, -1] = LEAST_SHARE, 1.0, 1.0
    start, end = (None if held is None else np.append(held, 1.0) for held in program.end_free)
    return replace(
        program,
        **rows | {"weight": np.append(np.zeros(r), 1.0)},
        free=free,
        change=np.append(program.change, np.inf),
        sizes=np.zeros((2, r + 1)),
        names=(*program.names[:r], SHARE, *program.names[r:]),
        end_free=(start, end),
    )
