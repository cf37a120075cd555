"""Smooth timing as one nonlinear program over time, solved by IPOPT, for tests.

The same continuous problem as that of `smooth_program`, by another discretisation: N steps of time of one unknown
length, in each of which the third derivative of the path position is constant; wrenches at nodes of time; rates of
torques and wrenches and jerk as differences over a step. The position p runs from 0 to 1 at the constant speed of the
object, with no quintic under it, and every term along the path is a polynomial in p fitted to the generated terms.
"""

from dataclasses import dataclass

import casadi as ca
import numpy as np
from numpy.polynomial import chebyshev
from scipy.spatial.transform import Rotation
from transcription import robot_side

import mrts

FITTED = 1e-6
"""Share of the largest entry of a term that its polynomial may miss it by: far below what is compared."""

DEGREES = range(8, 33, 4)
NAMES = ("E", "A", "G", "J", "B", "P", "S", "Q", "dq", "ddq")
SLOW = 4.0
"""Times the given duration: the first guess, from which IPOPT starts."""


@dataclass(frozen=True, eq=False)
class PathTerms:
    """Terms along a path as polynomials in p: coefficients of all entries, Shape (degree + 1, entries), and shapes."""

    coefficients: np.ndarray
    shapes: dict

    def at(self, p):
        """All terms at p, a number or a symbol."""
        basis = [1, 2 * p - 1]
        while len(basis) < len(self.coefficients):
            basis.append(2 * (2 * p - 1) * basis[-1] - basis[-2])
        values, found, first = ca.mtimes(ca.DM(self.coefficients.T), ca.vertcat(*basis)), {}, 0
        for name, shape in self.shapes.items():
            last = first + int(np.prod(shape))
            found[name] = ca.reshape(values[first:last], shape[::-1] if len(shape) > 1 else (shape[0], 1)).T
            first = last
        return {name: value if len(self.shapes[name]) > 1 else value.T for name, value in found.items()}


def path_terms(cell, description, load=None):
    """Polynomials of the terms of the path from pose to pose, of the least degree that fits them."""
    for degree in DEGREES:
        nodes = (1 - np.cos(np.pi * np.arange(2 * degree + 1) / (2 * degree))) / 2
        motion = mrts.follow_object(cell, constant_speed(description, nodes))
        terms = cell.functions("terms", len(nodes), motion.inputs(cell.load if load is None else load))
        terms |= {"dq": motion.dq, "ddq": motion.ddq}
        values = np.column_stack([terms[name].reshape(len(nodes), -1) for name in NAMES])
        fitted = chebyshev.chebfit(2 * nodes - 1, values, degree)
        missed = np.abs(chebyshev.chebval(2 * nodes - 1, fitted).T - values)
        if np.max(missed) <= FITTED * np.max(np.abs(values)):
            return PathTerms(fitted, {name: terms[name].shape[1:] for name in NAMES})
    raise AssertionError("no polynomial fits the terms of the path")


def constant_speed(description, p):
    """The object's way from pose to pose at p in [0, 1], each of its rates constant."""
    start, end = (np.array(pose.xyz, dtype=float) for pose in (description.start, description.end))
    first, last = (Rotation.from_matrix(pose.rotation()) for pose in (description.start, description.end))
    turn = (last * first.inv()).as_rotvec()
    rotation = (Rotation.from_rotvec(p[:, None] * turn) * first).as_matrix()
    twist = np.tile(np.concatenate([end - start, turn]), (len(p), 1))
    return mrts.ObjectMotion(p, start + p[:, None] * (end - start), rotation, twist, np.zeros_like(twist))


def timed_by_ipopt(cell, description, rates, steps):
    """The least duration [s] with limits of torques, wrenches, velocities and rates, over steps of one length.

    Args:
        cell: The cell, without motors.
        description: Motion from pose to pose.
        rates: As of `smooth_program`.
        steps: N.
    """
    program = TimeProgram(cell, path_terms(cell, description), steps)
    return program.solve(SLOW * description.duration, rates)


class TimeProgram:
    """The program of one path; its unknowns are the length of a step and p, ṗ, p̈, p⃛, F and τ at the nodes."""

    def __init__(self, cell, terms, steps):
        self.cell, self.terms, self.steps = cell, terms, steps
        self.wrenches, self.joints = terms.shapes["B"][1], terms.shapes["E"][0]
        self.node = self._node()

    def _node(self):
        """p, ṗ, p̈, F to torques, unbalance, accelerations and velocities of the joints, as one Function."""
        p, v, a, F = ca.SX.sym("p"), ca.SX.sym("v"), ca.SX.sym("a"), ca.SX.sym("F", self.wrenches)
        at = self.terms.at(p)
        torque = at["E"] * v**2 + at["A"] * a + at["G"]
        for name, joints in self.cell.joint_slices.items():
            torque[joints] += at["J"][:, joints].T @ F[self.cell.wrench_slices[name]]
        unbalance = at["B"] @ F - at["P"] * v**2 - at["S"] * a - at["Q"]
        acceleration = at["dq"] * a + at["ddq"] * v**2
        return ca.Function("node", [p, v, a, F], [torque, unbalance, acceleration, at["dq"] * v])

    def solve(self, duration, rates):
        """The least duration, from a quintic of p over a given one."""
        n, guess = self.steps + 1, self._guess(duration)
        d, p, v, a, j = ca.MX.sym("d"), *(ca.MX.sym(name, 1, n) for name in "pvaj")
        F, torque = ca.MX.sym("F", self.wrenches, n), ca.MX.sym("tau", self.joints, n)
        units = [np.concatenate([self._side("upper", kind)]) for kind in ("torque", "wrench")]
        found, unbalance, acceleration, velocity = self.node.map(n)(p, v, a, F)
        size = np.where(np.isfinite(units[0]), units[0], 1.0)
        equal = [
            ca.vec((torque - found) / size),
            ca.vec(unbalance),
            (p[1:] - p[:-1] - d * v[:-1] - d**2 / 2 * a[:-1] - d**3 / 6 * j[:-1]).T,
            (v[1:] - v[:-1] - d * a[:-1] - d**2 / 2 * j[:-1]).T,
            (a[1:] - a[:-1] - d * j[:-1]).T,
        ]
        speed = np.concatenate([robot.velocity_limit for robot in self.cell.robots])
        fast = np.flatnonzero(np.isfinite(speed)).tolist()
        most = [ca.vec(sign * velocity[fast, :] / speed[fast] - 1) for sign in (1, -1)] if fast else []
        for values, limit in ((torque, rates.torque), (acceleration, rates.jerk), (F, rates.wrench)):
            limited = [] if limit is None else np.flatnonzero(np.isfinite(limit)).tolist()
            if limited:
                pace = (values[limited, 1:] - values[limited, :-1]) / limit[limited]
                most += [ca.vec(pace - d), ca.vec(-pace - d)]
        variables = [d, ca.vec(p), ca.vec(v), ca.vec(a), ca.vec(j), ca.vec(F), ca.vec(torque)]
        low, high = self._bounds(n)
        rows, below = ca.vertcat(*equal), ca.vertcat(*most)
        solver = ca.nlpsol(
            "timing",
            "ipopt",
            {"x": ca.vertcat(*variables), "f": self.steps * d, "g": ca.vertcat(rows, below)},
            {"ipopt.print_level": 0, "print_time": False, "ipopt.sb": "yes", "ipopt.tol": 1e-7, "ipopt.max_iter": 1000},
        )
        least = np.concatenate([np.zeros(rows.shape[0]), np.full(below.shape[0], -np.inf)])
        answer = solver(x0=guess, lbx=low, ubx=high, lbg=least, ubg=np.zeros(len(least)))
        assert solver.stats()["success"], solver.stats()["return_status"]
        return float(answer["f"])

    def _side(self, side, kind):
        return robot_side(self.cell, side, kind)

    def _bounds(self, n):
        """Least and largest unknowns: at rest at both ends, torques and wrenches within their limits."""
        low, high = [np.zeros(1)], [np.full(1, np.inf)]
        for ends in ((0.0, 1.0), (0.0, 0.0), (0.0, 0.0)):
            part = np.full((2, n), np.inf) * [[-1.0], [1.0]]
            part[:, 0], part[:, -1] = ends
            low.append(part[0])
            high.append(part[1])
        low[1:3] = [np.maximum(part, 0.0) for part in low[1:3]]
        low += [np.full(n, -np.inf), *(np.tile(self._side("lower", kind), n) for kind in ("wrench", "torque"))]
        high += [np.full(n, np.inf), *(np.tile(self._side("upper", kind), n) for kind in ("wrench", "torque"))]
        return np.concatenate(low), np.concatenate(high)

    def _guess(self, duration):
        """A quintic of p over a duration, with the least wrenches that keep the balance."""
        z, n = np.linspace(0, 1, self.steps + 1), self.steps + 1
        p = z**3 * (10 - 15 * z + 6 * z**2)
        v = 30 * z**2 * (1 - z) ** 2 / duration
        a = 60 * z * (1 - z) * (1 - 2 * z) / duration**2
        j = 60 * (1 - 6 * z + 6 * z**2) / duration**3
        F, torque = np.zeros((n, self.wrenches)), np.zeros((n, self.joints))
        for k in range(n):
            at = {name: np.asarray(value) for name, value in self.terms.at(ca.DM(p[k])).items()}
            moved = at["P"] * v[k] ** 2 + at["S"] * a[k] + at["Q"]
            F[k] = np.linalg.lstsq(at["B"], moved[:, 0], rcond=None)[0]
            torque[k] = np.asarray(self.node(p[k], v[k], a[k], F[k])[0])[:, 0]
        return np.concatenate([[duration / self.steps], p, v, a, j, F.ravel(), torque.ravel()])
