"""Constant factors within limits of rates, independently: all wrenches and the balance, by cvxpy and Clarabel, where it
fails HiGHS.

Torques are those of eq. (13) from the terms of the cell, with the motors' numbers as the cell file has them.
"""

import warnings
from itertools import pairwise

import cvxpy as cp
import numpy as np


class RatedFactor:
    """One cell and motion; rates are bounded by differences of neighbouring samples."""

    def __init__(self, cell, motion, rates):
        self.cell, self.motion, self.rates = cell, motion, rates
        self.terms = cell.functions("terms", motion.samples, motion.inputs(cell.load))
        self.limits = [
            np.concatenate([getattr(robot, name) for robot in cell.robots])
            for name in ("torque_lower", "torque_upper", "wrench_lower", "wrench_upper", "velocity_limit")
        ]
        self.motors = {
            name: np.concatenate([getattr(robot.motors, name) for robot in cell.robots])
            for name in ("armature", "coulomb", "viscous")
        }

    def excess(self, c):
        """The least share by which all limits and rates must give way at a factor; negative if none has to."""
        worst, constraints = cp.Variable(), []
        torques, F, time = self.carried(c, constraints)
        for torque, one in zip(torques, F, strict=True):
            constraints += self.limits_of(torque, one, worst)
        constraints += self.changes(torques, F, time, 1 + worst)
        constraints.append(worst >= np.max(np.abs(self.motion.dq) * c / self.limits[-1]) - 1)
        solved(cp.Problem(cp.Minimize(worst), constraints))
        return float(worst.value)

    def shares(self, c):
        """The largest share of any limit at each sample, of all torques within rates those of the least Σ ω share²."""
        share, constraints = cp.Variable(self.motion.samples), []
        torques, F, time = self.carried(c, constraints)
        constraints += [*self.changes(torques, F, time, 1), share >= 0.01]
        for k, (torque, one) in enumerate(zip(torques, F, strict=True)):
            constraints += self.limits_of(torque, one, share[k] - 1)
        solved(cp.Problem(cp.Minimize(cp.sum(cp.multiply(spacing(time), cp.square(share)))), constraints))
        return share.value

    def effort(self, c, shares, weights):
        """The least Σ ω τᵀWτ of torques within rates and a share of all limits at each sample."""
        constraints = []
        torques, F, time = self.carried(c, constraints)
        constraints += self.changes(torques, F, time, 1)
        for torque, one, share in zip(torques, F, shares.tolist(), strict=True):
            constraints += self.limits_of(torque, one, share - 1)
        root, total = np.linalg.cholesky(weights).T, 0
        for (torque, dry), wide in zip(torques, spacing(time).tolist(), strict=True):
            total = total + wide * cp.sum_squares(root @ (torque + dry))
        solved(program := cp.Problem(cp.Minimize(total), constraints))
        return float(program.value)

    def limits_of(self, torque, F, worst):
        """Limits of one sample that give way by a share; a torque is one without dry friction, and what that adds."""
        low, high, push, pull, _ = self.limits
        return within(torque[0] + torque[1], low, high, worst) + within(F, push, pull, worst)

    def changes(self, torques, F, time, most_share):
        """Changes of torques and wrenches from sample to sample, within a share of what their rates allow."""
        constraints = []
        for values, most in (([torque for torque, _ in torques], self.rates.torque), (F, self.rates.wrench)):
            kept = np.isfinite(most)
            for (before, after), step in zip(pairwise(values), np.diff(time), strict=True):
                if np.any(kept):
                    change = cp.multiply(1 / (step * most[kept]), (after - before)[kept])
                    constraints += [change <= most_share, change >= -most_share]
        return constraints

    def carried(self, c, constraints):
        """Torques, wrenches and times; the balance of the object is added to the constraints."""
        push = self.limits[2]
        dq, time = self.motion.dq, self.motion.object.time / c
        ddq = self.motion.ddq
        rest, still = (1e-9 * np.max(np.abs(one)) for one in (dq, ddq))
        way = np.where(np.abs(ddq) > still, np.sign(ddq), 0)  # at rest at an end: it leaves so, or arrives against it
        way[-1] *= -1
        travel = np.where(np.abs(dq) > rest, np.sign(dq), way)
        unit = np.abs(self.terms["Q"]).max() + np.abs(self.terms["P"]).max() * c**2  # of wrenches, for Clarabel
        F = [unit * cp.Variable(len(push)) for _ in time]
        torques = []  # rates are without dry friction, which steps where a joint turns back or leaves rest
        for k, one in enumerate(F):
            of_arms = [
                self.terms["J"][k][:, joints].T @ one[self.cell.wrench_slices[name]]
                for name, joints in self.cell.joint_slices.items()
            ]
            own = self.terms["E"][k] * c**2 + self.terms["G"][k] + self.motors["armature"] * self.motion.ddq[k] * c**2
            own = own + self.motors["viscous"] * dq[k] * c
            torque = own + cp.hstack(of_arms)
            balance = sum(self.terms["B"][k][:, part] @ one[part] for part in self.cell.wrench_slices.values())
            constraints.append(balance / unit == (self.terms["P"][k] * c**2 + self.terms["Q"][k]) / unit)
            torques.append((torque, self.motors["coulomb"] * travel[k]))
        return torques, F, time


def solved(program):
    """Solve by Clarabel, where it fails by HiGHS."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of what Clarabel calls inaccurate
        try:
            program.solve(solver=cp.CLARABEL)
        except cp.error.SolverError:
            program.solve(solver=cp.HIGHS)
    if program.status != cp.OPTIMAL:
        program.solve(solver=cp.HIGHS)


def spacing(time):
    """Weights ω of the trapezoidal rule."""
    step = np.diff(time)
    return (np.append(step, 0) + np.append(0, step)) / 2


def within(value, lower, upper, worst):
    """Limits that all may give way by one share of their size."""
    constraints = []
    size = np.maximum(*(np.where(np.isfinite(one), np.abs(one), 0) for one in (lower, upper)))
    for sign, limit in ((1, upper), (-1, -lower)):
        kept = np.flatnonzero(np.isfinite(limit))
        if kept.size:
            constraints.append(cp.multiply(sign / size[kept], value[kept]) <= limit[kept] / size[kept] + worst)
    return constraints
