"""Which speeds a sample admits with motors, independently: Pinocchio's armature, friction written here, HiGHS, a scan.

Nothing of mrts is used. At a fixed speed c all is linear in the wrenches; HiGHS says by how much of their size limits
must move. A scan over c finds where that is nothing, bisection where it begins.
"""

from dataclasses import dataclass

import highspy
import numpy as np
from reference import exact_highs, filled, last_cost

ADMITTED = 1e-9
"""Limits that must move by less than this share of their size hold: HiGHS is asked for 1e-10."""

HALVINGS = 44


@dataclass
class Motors:
    """Of one arm, one number a joint; curves are corners |q'|, |τ| or None."""

    armature: np.ndarray
    coulomb: np.ndarray
    viscous: np.ndarray
    curves: list


class SpeedScan:
    """One sample of a `reference.ReferenceCell` whose arms have motors."""

    def __init__(self, reference, motors, sample, joints):
        for arm, motor in zip(reference.arms, motors, strict=True):
            arm.model.armature = motor.armature
        terms = reference.terms(sample, joints)
        for arm, motor, (_, _, ddq), E in zip(reference.arms, motors, joints, terms.E, strict=True):
            arm.model.armature = np.zeros_like(motor.armature)
            added = E - reference.terms(sample, joints).E[reference.arms.index(arm)]
            assert np.allclose(added, motor.armature * ddq), "Pinocchio leaves the armature out"
        self.largest = np.inf
        A, low, high, by_speed, by_square, size = [], [], [], [], [], []
        w, n = len(reference.rows), len(reference.arms)
        for index, (arm, motor, (_, dq, _)) in enumerate(zip(reference.arms, motors, joints, strict=True)):
            for limit, rate in zip(arm.model.velocityLimit, np.abs(dq), strict=True):
                if 0 < limit < 1e3 and rate > 0:
                    self.largest = min(self.largest, limit / rate)
            for j, rate in enumerate(dq):
                row = np.zeros(n * w)
                row[index * w : (index + 1) * w] = terms.J[index][:, j]
                rest = terms.G[index][j] + motor.coulomb[j] * np.sign(rate)
                lines = [(arm.torque[1][j], 0.0)]
                curve = motor.curves[j]
                if curve is not None:
                    steps = np.diff(curve, axis=0)
                    falls = -steps[:, 1] / steps[:, 0]
                    lines += [(t + fall * v, fall) for (v, t), fall in zip(curve[:-1], falls, strict=True) if fall > 0]
                    self.largest = min(self.largest, curve[-1, 0] / abs(rate))
                for most, fall in lines:
                    A.append(row)
                    low.append(-most - rest)
                    high.append(most - rest)
                    by_square.append(terms.E[index][j])
                    by_speed.append((motor.viscous[j] + fall) * rate)
                    size.append(most)
            for component in np.flatnonzero(np.isfinite(arm.wrench).any(axis=0)):
                row = np.zeros(n * w)
                row[index * w + component] = 1.0
                limits = arm.wrench[:, component]
                A.append(row)
                low.append(limits[0])
                high.append(limits[1])
                by_square.append(0.0)
                by_speed.append(0.0)
                size.append(np.max(np.abs(limits[np.isfinite(limits)])))
        size = np.array(size)
        limits = np.column_stack([np.array(A) / size[:, None], np.ones(len(A))])
        lower_side = np.column_stack([np.array(A) / size[:, None], -np.ones(len(A))])
        balance = np.column_stack([np.hstack(terms.B), np.zeros(w)])
        self.A = np.vstack([limits, lower_side, balance])
        self.low, self.high = np.array(low) / size, np.array(high) / size
        self.by_square, self.by_speed = np.array(by_square) / size, np.array(by_speed) / size
        self.P, self.Q = terms.P, terms.Q
        self.highs = self._model()

    def _model(self):
        highs, (rows, columns) = exact_highs(), self.A.shape
        any_row, any_unknown = np.full(rows, np.inf), np.full(columns, np.inf)
        least = np.append(-any_unknown[1:], 0.0)
        lp = filled(highspy.HighsLp(), self.A, -any_row, any_row, least, any_unknown, last_cost(self.A, 1.0))
        highs.passModel(lp)
        return highs

    def missing(self, c):
        """The share of their size by which limits must move outward at c."""
        moved = self.by_square * c * c + self.by_speed * c
        none, wrench = np.full(len(moved), np.inf), self.P * c * c + self.Q
        lower = np.concatenate([self.low - moved, -none, wrench])
        upper = np.concatenate([none, self.high - moved, wrench])
        self.highs.changeRowsBounds(len(lower), np.arange(len(lower), dtype=np.int32), lower, upper)
        self.highs.run()
        assert self.highs.getModelStatus() == highspy.HighsModelStatus.kOptimal
        return self.highs.getInfo().objective_function_value

    def admits(self, c):
        return self.missing(c) <= ADMITTED

    def intervals(self, grid):
        """Intervals of c that begin or end between points of a grid, each end bisected."""
        points = np.unique(grid[grid <= self.largest])
        if np.isfinite(self.largest):
            points = np.unique(np.append(points, self.largest))
        inside = [self.admits(c) for c in points]
        found = []
        for place, (c, admitted) in enumerate(zip(points, inside, strict=True)):
            before = place > 0 and inside[place - 1]
            if admitted and not before:
                found.append([c if place == 0 else self._boundary(points[place - 1], c), None])
            if admitted and place == len(points) - 1:
                found[-1][1] = c if c == self.largest else np.inf
            elif admitted and not inside[place + 1]:
                found[-1][1] = self._boundary(points[place + 1], c)
        return found

    def _boundary(self, outside, inside):
        for _ in range(HALVINGS):
            middle = (outside + inside) / 2
            if self.admits(middle):
                inside = middle
            else:
                outside = middle
        return inside
