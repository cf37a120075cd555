"""Constant factors within limits of rates, independently: all wrenches and the balance, by cvxpy and Clarabel, where it
fails HiGHS.

Torques are those of eq. (13) from the terms of the cell, with the motors' numbers as the cell file has them.
"""

import warnings
from itertools import pairwise

import cvxpy as cp
import numpy as np


class RatedFactor:
    """One cell and motion, for all of some loads at once; rates are bounded by differences of neighbouring samples."""

    def __init__(self, cell, motion, rates, loads=None):
        self.cell, self.motion, self.rates = cell, motion, rates
        loads = [cell.load] if loads is None else loads
        self.terms = [cell.functions("terms", motion.samples, motion.inputs(load)) for load in loads]
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
        low, high, push, pull, fastest = self.limits
        dq, time = self.motion.dq, self.motion.object.time / c
        ddq = self.motion.ddq
        rest, still = (1e-9 * np.max(np.abs(one)) for one in (dq, ddq))
        way = np.where(np.abs(ddq) > still, np.sign(ddq), 0)  # at rest at an end: it leaves so, or arrives against it
        way[-1] *= -1
        travel = np.where(np.abs(dq) > rest, np.sign(dq), way)
        for terms in self.terms:
            unit = np.abs(terms["Q"]).max() + np.abs(terms["P"]).max() * c**2  # of wrenches, for Clarabel
            F = [unit * cp.Variable(len(push)) for _ in time]
            torques = []  # without dry friction, which steps where a joint turns back or leaves rest
            for k, one in enumerate(F):
                of_arms = [
                    terms["J"][k][:, joints].T @ one[self.cell.wrench_slices[name]]
                    for name, joints in self.cell.joint_slices.items()
                ]
                own = terms["E"][k] * c**2 + terms["G"][k] + self.motors["armature"] * self.motion.ddq[k] * c**2
                own = own + self.motors["viscous"] * dq[k] * c
                torque = own + cp.hstack(of_arms)
                balance = sum(terms["B"][k][:, part] @ one[part] for part in self.cell.wrench_slices.values())
                constraints.append(balance / unit == (terms["P"][k] * c**2 + terms["Q"][k]) / unit)
                dry = self.motors["coulomb"] * travel[k]
                constraints += within(torque + dry, low, high, worst) + within(one, push, pull, worst)
                torques.append(torque)
            for values, most in ((torques, self.rates.torque), (F, self.rates.wrench)):
                kept = np.isfinite(most)
                for (before, after), step in zip(pairwise(values), np.diff(time), strict=True):
                    if np.any(kept):
                        change = cp.multiply(1 / (step * most[kept]), (after - before)[kept])
                        constraints += [change <= 1 + worst, change >= -1 - worst]
        constraints.append(worst >= np.max(np.abs(dq) * c / fastest) - 1)
        program = cp.Problem(cp.Minimize(worst), constraints)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # of what Clarabel calls inaccurate
            try:
                program.solve(solver=cp.CLARABEL)
            except cp.error.SolverError:
                program.solve(solver=cp.HIGHS)
        if program.status != cp.OPTIMAL:
            program.solve(solver=cp.HIGHS)
        return float(worst.value)

    def fastest(self, low, high, share=1e-6):
        """The largest admissible factor between one that is and one that is not, by bisection."""
        while high - low > share * low:
            middle = (low + high) / 2
            low, high = (middle, high) if self.excess(middle) <= 0 else (low, middle)
        return low


def within(value, lower, upper, worst):
    """Limits that all may give way by one share of their size."""
    constraints = []
    size = np.maximum(*(np.where(np.isfinite(one), np.abs(one), 0) for one in (lower, upper)))
    for sign, limit in ((1, upper), (-1, -lower)):
        kept = np.flatnonzero(np.isfinite(limit))
        if kept.size:
            constraints.append(cp.multiply(sign / size[kept], value[kept]) <= limit[kept] / size[kept] + worst)
    return constraints
