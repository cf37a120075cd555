# SPDX-License-Identifier: MIT
"""The convex programs of smooth timing as second-order cone programs, solved by Clarabel."""

from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from cones import Cones, entries
from scipy import sparse

from mrts.base.arrays import Array
from mrts.program.smooth_program import Goal, SmoothProfile, SmoothProgram

LEAST_WEIGHT = 1e-300
"""Where no row has a weight, the largest is taken for this."""


THIN = 1e-12
"""What Clarabel adds to its pivots for torques: rates leave sets so thin that its default would be felt."""


def in_units_of(program: SmoothProgram, unit: float) -> SmoothProgram:
    """The same program with x and u in multiples of a unit [1/s²], and times in multiples of 1/√unit."""
    root = float(np.sqrt(unit))
    first, last = (None if x is None else x / unit for x in program.ends)
    return replace(
        program,
        square=program.square * unit,
        rate=program.rate * unit,
        root=program.root * root,
        change=program.change / root,
        jerk=program.jerk / (unit * root),
        ends=(first, last),
    )


def goal_in_units_of(goal: Goal, unit: float) -> Goal:
    """The same goal for a program in other units."""
    root = float(np.sqrt(unit))
    longest = None if goal.longest is None else goal.longest * root
    return Goal(goal.time / root, goal.effort / root, longest, goal.uneven * unit**2)


class ConicSolver:
    """Second-order cones, by Clarabel."""

    @staticmethod
    def step(program: SmoothProgram, around: Array, goal: Goal) -> SmoothProfile | None:
        """See `KernelSolver.step`."""
        unit = float(np.exp(np.mean(np.log(around))))
        found = _Timing(in_units_of(program, unit), around / unit).best(goal_in_units_of(goal, unit))
        return None if found is None else SmoothProfile(unit * found.x, unit * found.u, found.free)

    @staticmethod
    def nearest(program: SmoothProgram, around: Array) -> tuple[SmoothProfile, float] | None:
        """The profile whose rates pass their limits least, where all else is as in `step`.

        Args:
            program: The program.
            around: x > 0 where tangents are laid, Shape (n,).

        Returns:
            It and by what share; None where the other limits cannot be kept.
        """
        unit = float(np.exp(np.mean(np.log(around))))
        timing = _Timing(in_units_of(program, unit), around / unit)
        found = timing.best(None)
        return None if found is None else (SmoothProfile(unit * found.x, unit * found.u, found.free), timing.share)

    @staticmethod
    def torques(program: SmoothProgram, x: Array, u: Array) -> Array | None:
        """See `KernelSolver.torques`."""
        (n, r, f), times = program.free.shape, program.times(x)
        if f == 0:
            return np.zeros((n, 0))
        node, row = np.arange(n)[:, None], np.arange(r)
        columns = (node * f)[..., None] + np.arange(f)
        places = (node * r + row)[..., None]
        values = program.values(x, u, np.zeros((n, f)))
        A = entries((n * r, n * f), (places, columns, program.free))
        cones, sharing = Cones(), np.flatnonzero(np.any(program.free, axis=2))
        cones.most(A[sharing], (program.upper - values).ravel()[sharing])
        cones.most(-A[sharing], (values - program.lower).ravel()[sharing])
        allowed = np.outer(times, program.change).ravel()
        kept = np.flatnonzero(np.isfinite(allowed))
        change = sparse.diags_array(1 / allowed[kept]) @ (A[r:] - A[:-r])[kept]
        moved = np.diff(values, axis=0).ravel()[kept] / allowed[kept]
        cones.most(change, 1 - moved)
        cones.most(-change, 1 + moved)
        for place, given in ((0, program.end_free[0]), (n - 1, program.end_free[1])):
            if given is not None:
                picked = np.arange(f)
                cones.equal(entries((f, n * f), (picked, columns[place, 0], np.ones(f))), given)
        weight = program.spacing[:, None] / np.sqrt(x)[:, None] * program.weight
        weighted = sparse.diags_array(weight.ravel() / np.max(weight, initial=LEAST_WEIGHT)) @ A
        found = cones.solved(2 * (A.T @ weighted), 2 * (weighted.T @ values.ravel()), THIN)
        return None if found is None else found.reshape(n, f)


@dataclass(frozen=True)
class _Tangents:
    """Lines that touch what is not convex at a profile: value + slope (x - around)."""

    around: Array

    @property
    def root(self) -> tuple[Array, Array]:
        """Of √x, above it: start and slope, each Shape (n,)."""
        speed = np.sqrt(self.around)
        return speed / 2, 0.5 / speed

    @property
    def slowness(self) -> tuple[Array, Array]:
        """Of 1/√x, below it: start and slope, each Shape (n,)."""
        speed = np.sqrt(self.around)
        return 1.5 / speed, -0.5 / (self.around * speed)

    def times(self, step: Array) -> tuple[Array, Array, Array]:
        """Of Δt, below it: start and slopes along x at both ends of a segment, each Shape (n - 1,)."""
        speed = np.sqrt(self.around)
        total = speed[:-1] + speed[1:]
        before, after = -step / (speed[:-1] * total**2), -step / (speed[1:] * total**2)
        start = 2 * step / total - before * self.around[:-1] - after * self.around[1:]
        return start, before, after


class _Timing:
    """The program of `KernelSolver.step` over z = [x, u, y, times, efforts, F, share] with y <= √x.

    Limits of rates are relaxed by `share`, which is 0 where a goal is given.

    Args:
        program: The program.
        around: Shape (n,).
    """

    def __init__(self, program: SmoothProgram, around: Array) -> None:
        n, r, f = program.free.shape
        self.program, self.tangents = program, _Tangents(around)
        ends = np.cumsum([0, n, n, n, n - 1, n, n * f, 1])
        parts = [np.arange(start, end) for start, end in pairwise(ends)]
        self.x, self.u, self.y, self.times, self.efforts, free, self.relaxed = parts
        self.free = free.reshape(n, f)
        self.size, self.share = int(ends[-1]), 0.0
        node, places = np.arange(n)[:, None], np.arange(n * r).reshape(n, r)
        self.linear = entries(
            (n * r, self.size),
            (places, self.x[node], program.square),
            (places, self.u[node], program.rate),
            (places[..., None], self.free[:, None, :], program.free),
        )

    def best(self, goal: Goal | None) -> SmoothProfile | None:
        """The best profile for a goal; the one that relaxes limits of rates least where there is none."""
        cones, q = Cones(), np.zeros(self.size)
        self._path(cones)
        self._rows(cones)
        self._changes(cones)
        self._jerks(cones)
        share = entries((1, self.size), (0, self.relaxed, np.ones(1)))
        if goal is None:
            q[self.relaxed] = 1.0
            cones.most(-share, np.zeros(1))
        else:
            cones.equal(share, np.zeros(1))
            q[self.times] = goal.time
            if goal.effort > 0:
                q += goal.effort * self._efforts(cones)
            if goal.longest is not None:
                total = entries((1, self.size), (0, self.times, np.ones(len(self.times))))
                cones.most(total, np.array([goal.longest]))
        z = cones.solved(self._uneven(0.0 if goal is None else goal.uneven), q)
        if z is None:
            return None
        self.share = float(z[self.relaxed[0]])
        return SmoothProfile(z[self.x], z[self.u], z[self.free])

    def _uneven(self, weight: float) -> sparse.csc_array:
        """Second derivatives of the jumps of u."""
        by, here, there = 2 * weight / self.program.step, self.u[:-1], self.u[1:]
        shape = (self.size, self.size)
        if weight == 0:
            return sparse.csc_array(shape)
        return entries(shape, (here, here, by), (there, there, by), (here, there, -by), (there, here, -by)).tocsc()

    def _path(self, cones: Cones) -> None:
        """How x and u belong together, y² <= x, time (y + y') >= 2 h, and what is given at the ends."""
        program, h = self.program, self.program.step
        n = program.nodes
        segment, one = np.arange(n - 1), np.ones(n - 1)
        x, u, y = self.x, self.u, self.y
        cones.equal(
            entries(
                (n - 1, self.size),
                (segment, x[1:], one), (segment, x[:-1], -one), (segment, u[1:], -h), (segment, u[:-1], -h),
            ),
            np.zeros(n - 1),
        )  # fmt: skip
        for place, given, free in zip((0, n - 1), program.ends, program.end_free, strict=True):
            if given is not None:
                cones.equal(entries((1, self.size), (0, x[place : place + 1], np.ones(1))), np.array([given]))
            if free is not None:
                picked = np.arange(len(free))
                cones.equal(entries((len(free), self.size), (picked, self.free[place], np.ones(len(free)))), free)
        both = entries((n - 1, self.size), (segment, y[1:], one), (segment, y[:-1], one))
        each = entries((n - 1, self.size), (segment, self.times, one))
        nothing = entries((n - 1, self.size), (segment, x[1:], 0 * one))
        cones.products(each, both, [(nothing, np.sqrt(2 * h))])
        node, ones = np.arange(n), np.ones(n)
        cones.roots(entries((n, self.size), (node, x, ones)), entries((n, self.size), (node, y, ones)))

    def _rows(self, cones: Cones) -> None:
        program = self.program
        start, slope = (of[:, None] for of in self.tangents.root)
        for sign, limit in ((1.0, program.upper - program.offset), (-1.0, program.offset - program.lower)):
            A, constant = self._rooted(sign * program.root, start, slope)
            cones.most(sign * self.linear + A, limit.ravel() - constant.ravel())

    def _rooted(self, root: Array, start: Array, slope: Array) -> tuple[sparse.csr_array, Array]:
        """Terms root √x of rows that are to be small: its tangent where root > 0, else y; matrix and constants."""
        n, r = root.shape
        node, places = np.arange(n)[:, None], np.arange(n * r).reshape(n, r)
        presses, helps = np.maximum(root, 0.0), np.minimum(root, 0.0)
        A = entries((n * r, self.size), (places, self.x[node], presses * slope), (places, self.y[node], helps))
        return A, presses * start

    def _changes(self, cones: Cones) -> None:
        program = self.program
        limited = np.flatnonzero(np.isfinite(program.change))
        if not limited.size:
            return
        n, r = program.square.shape
        start, slope = (of[:, None] for of in self.tangents.root)
        times, before, after = (of[:, None] * program.change[limited] for of in self.tangents.times(program.step))
        now = program.times(self.tangents.around)[:, None] * program.change[limited]
        segments, count = np.arange(n - 1)[:, None], (n - 1) * len(limited)
        places = np.arange(count).reshape(n - 1, -1)
        allowed = entries(
            (count, self.size),
            (places, self.x[segments], before), (places, self.x[segments + 1], after), (places, self.relaxed[0], now),
        )  # fmt: skip
        here, there = (((segments + shift) * r + limited).ravel() for shift in (0, 1))
        constant = np.diff(program.offset[:, limited], axis=0)
        for sign in (1.0, -1.0):
            A = sign * (self.linear[there] - self.linear[here]) - allowed
            moved = sign * constant
            for rows, side in ((there, sign), (here, -sign)):
                rooted, more = self._rooted(side * program.root, start, slope)
                A = A + rooted[rows]
                moved = moved + more.ravel()[rows].reshape(moved.shape)
            cones.most(A, (times - moved).ravel())

    def _jerks(self, cones: Cones) -> None:
        program = self.program
        joints = len(program.jerk)
        if not joints:
            return
        n = program.nodes
        segments, count = np.arange(n - 1)[:, None], (n - 1) * joints
        places = np.arange(count).reshape(n - 1, joints)
        start, slope = self.tangents.slowness
        for end in (0, 1):
            at = segments + end
            q1, q2 = (of[end : n - 1 + end] for of in (program.q1, program.q2))
            q3, by_step = program.q3[:, end], q1 / program.step[:, None]
            A = entries(
                (count, self.size),
                (places, self.u[segments + 1], by_step), (places, self.u[segments], -by_step),
                (places, self.u[at], 3 * q2), (places, self.x[at], q3),
            )  # fmt: skip
            now = program.jerk / np.sqrt(self.tangents.around[at])
            allowed = entries(
                (count, self.size), (places, self.x[at], slope[at] * program.jerk), (places, self.relaxed[0], now)
            )
            limit = (start[at] * program.jerk).ravel()
            cones.most(A - allowed, limit)
            cones.most(-A - allowed, limit)

    def _efforts(self, cones: Cones) -> Array:
        """Rows e √x >= Σ weight (v - root √x)², and the objective of the effort."""
        program = self.program
        n, r = program.square.shape
        node, ones, spacing = np.arange(n), np.ones(n), program.spacing
        counted = np.flatnonzero(program.weight)
        roots = []
        for row in counted.tolist():
            by = np.sqrt(program.weight[row])
            roots.append((by * self.linear[node * r + row], by * program.offset[:, row]))
        first = entries((n, self.size), (node, self.efforts, ones))
        cones.products(first, entries((n, self.size), (node, self.y, ones)), roots)
        q = np.zeros(self.size)
        q[self.efforts] = spacing
        factor = 2 * spacing[:, None] * program.weight * program.root
        q += self.linear.T @ factor.ravel()
        q[self.x] += spacing * (program.root**2 @ program.weight) * self.tangents.root[1]
        return q
