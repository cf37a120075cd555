"""Smooth timing as a sequence of convex programs by cvxpy and Clarabel, written from the mathematics, for tests.

Unknowns at the nodes of σ are x = σ̇², u = σ̈ and all wrenches, with the balance of the object as equations: nothing of
the projection, of the wrench form or of the rows of mrts is used. Terms of the arms are the generated ones of the
paper; those of motors are written out. What is not convex (Δt and 1/√x as upper ends, √x where it presses) is
replaced by its tangent at the last profile, which is stricter.
"""

import warnings
from dataclasses import dataclass

import cvxpy as cp
import numpy as np
import scipy.sparse as sp
from scipy.interpolate import CubicSpline
from transcription import robot_side

import mrts

GAIN = 1e-5
"""Share of the duration: a step that wins less is the last one, a hundredth of what is compared."""

KEPT = 1e-4
"""Share of torque rates by which the last profile may pass them, a tenth of what is compared."""

MOST_STEPS = 60
FIRST_SPEED = 0.3
"""σ̇ of the first profile; quartered until there is a timing around it."""

SLOWEST_SPEED = 1e-5
FROM_REST = 1.5
"""|σ̈| over σ̇² at the two nodes nearest to an end, as a multiple of 1 / σ of the whole path: a constant jerk needs 1.
Nothing else limits σ̇ at an end itself, where no torque depends on it."""
WRENCH_SIZE = 100.0
"""[N, N m]; unit of wrench components without limit."""


@dataclass(frozen=True, eq=False)
class SmoothPath:
    """A path that leaves rest and comes to rest as a quintic does: σ for time, and q''' there, Shape (n, m)."""

    motion: mrts.CoordinatedMotion
    third: np.ndarray

    @property
    def sigma(self):
        return self.motion.object.time


@dataclass(frozen=True, eq=False)
class Rates:
    """Largest rates of torques, accelerations and wrench components, each None or one a joint or component."""

    torque: np.ndarray | None = None
    jerk: np.ndarray | None = None
    wrench: np.ndarray | None = None


@dataclass(frozen=True, eq=False)
class SmoothTiming:
    """What `smooth_timing` finds: at the nodes x, u and per load the torques and wrenches, and each step's duration."""

    x: np.ndarray
    u: np.ndarray
    torque: list
    wrench: list
    durations: list

    @property
    def duration(self):
        return self.durations[-1]


def quintic_path(cell, keys, nodes):
    """The path of an object's motion from pose to pose, over the time of a quintic."""
    motion = mrts.load_motion(keys | {"profile": "quintic", "samples": nodes})
    return with_third(mrts.follow_object(cell, motion))


def with_third(motion):
    """A path with q''' of a spline through its q''."""
    return SmoothPath(motion, CubicSpline(motion.object.time, motion.ddq)(motion.object.time, 1))


def segment_times(sigma, x):
    speed = np.sqrt(x)
    return 2 * np.diff(sigma) / (speed[:-1] + speed[1:])


def smooth_timing(cell, path, rates, *, loads=None):
    """The fastest timing within limits and rates, None if there is none.

    It carries each of the loads, with torques of its own; the nominal one where none are given.
    """
    carried = [cell.load] if loads is None else loads
    models = [LoadRows(cell, path, load) for load in carried]
    speed, found = FIRST_SPEED, None
    while found is None and speed > SLOWEST_SPEED:
        around = np.full(len(path.sigma), speed**2)
        found = convex_step(cell, path, rates, models, around)
        speed /= 4
    if found is None:
        return None
    durations = []
    for _ in range(MOST_STEPS):
        durations.append(float(np.sum(segment_times(path.sigma, found[0]))))
        if len(durations) > 1 and durations[-2] - durations[-1] < GAIN * durations[-1]:
            break
        better = convex_step(cell, path, rates, models, found[0])
        if better is None:
            break
        found = better
    x, u, wrenches = found
    torques = [model.linear_torque(x, u, F) + model.friction(x) for model, F in zip(models, wrenches, strict=True)]
    if rates.torque is not None:
        allowed = segment_times(path.sigma, x)[:, None] * rates.torque
        assert all(np.all(np.abs(np.diff(torque, axis=0)) <= (1 + KEPT) * allowed) for torque in torques)
    return SmoothTiming(x, u, torques, wrenches, durations)


class LoadRows:
    """Torques and balance of all nodes as sparse matrices over x, u and all wrenches, of one load."""

    def __init__(self, cell, path, load):
        self.nodes, self.joints = path.motion.q.shape
        terms = cell.functions("terms", self.nodes, path.motion.inputs(load))
        dq, ddq = path.motion.dq, path.motion.ddq
        armature, coulomb, self.viscous = (
            np.concatenate([getattr(robot.motors, name) for robot in cell.robots])
            for name in ("armature", "coulomb", "viscous")
        )
        self.wrenches = terms["B"].shape[2]
        lower, upper = (np.abs(robot_side(cell, side, "wrench")) for side in ("lower", "upper"))
        largest = np.maximum(lower, upper)
        self.size = np.tile(np.where(np.isfinite(largest), largest, WRENCH_SIZE), self.nodes)
        transposed = np.zeros((self.nodes, self.joints, self.wrenches))
        for name, joints in cell.joint_slices.items():
            transposed[:, joints, cell.wrench_slices[name]] = terms["J"][:, :, joints].transpose(0, 2, 1)
        self.square = columns(terms["E"] + armature * ddq)
        self.rate = columns(terms["A"] + armature * dq)
        self.pull = sp.block_diag(list(transposed), format="csr")
        self.offset = (terms["G"] + coulomb * direction(path)).ravel()
        self.root = self.viscous * dq
        self.balance = (
            sp.block_diag(list(terms["B"]), format="csr"),
            columns(terms["P"]),
            columns(terms["S"]),
            terms["Q"].ravel(),
        )

    def linear_torque(self, x, u, F):
        """Torques without viscous friction, Shape (n, m); numbers or expressions."""
        flat = self.square @ x + self.rate @ u + self.pull @ F + self.offset
        return flat.reshape(self.nodes, self.joints) if isinstance(flat, np.ndarray) else flat

    def friction(self, x):
        return self.root * np.sqrt(x)[:, None]


def columns(parts):
    """Rows of every node that multiply the one unknown of that node."""
    return sp.block_diag([part[:, None] for part in parts], format="csr")


def direction(path):
    """Signs of the joints' velocities; at the ends those just inside."""
    dq = path.motion.dq.copy()
    dq[0], dq[-1] = dq[1], dq[-2]
    return np.sign(dq)


def convex_step(cell, path, rates, models, around):
    """x, u and the wrenches of each load that are fastest where tangents at x = `around` stand; None if none are."""
    n, h = len(path.sigma), np.diff(path.sigma)
    scale = float(np.mean(around))
    x, u, y = cp.Variable(n), cp.Variable(n), cp.Variable(n)
    root, rows = np.sqrt(around / scale), [x[1:] - x[:-1] == cp.multiply(h, u[1:] + u[:-1]), cp.square(y) <= x]
    above = root + cp.multiply(0.5 / root, x - around / scale)
    speed = root[:-1] + root[1:]
    shrink = cp.multiply(-2 * h / speed**2, above[:-1] + above[1:] - speed)
    longest, times = (2 * h / speed + shrink) / np.sqrt(scale), 2 * h / speed / np.sqrt(scale)
    rows += [cp.abs(u[node]) <= FROM_REST / path.sigma[-1] * x[node] for node in (0, 1, -2, -1)]
    rows += speed_rows(cell, path, x, scale)
    if rates.jerk is not None:
        rows += jerk_rows(path, rates.jerk, x, u, around / scale, scale)
    wrenches = []
    for model in models:
        F = cp.multiply(model.size, cp.Variable(n * model.wrenches))
        wrenches.append(F)
        rows += torque_rows(cell, model, rates, (x, u, F), (above, y, longest, times), scale)
        rows += wrench_rows(cell, model, rates, (x, u, F), longest, scale)
    duration = cp.sum(cp.multiply(2 * h, cp.inv_pos(y[:-1] + y[1:])))
    problem = cp.Problem(cp.Minimize(duration), rows)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", UserWarning)  # less accurate answers: see KEPT
            problem.solve(solver=cp.CLARABEL)
    except cp.SolverError:
        return None
    if problem.status not in {cp.OPTIMAL, cp.OPTIMAL_INACCURATE}:
        return None
    return scale * x.value, scale * u.value, [F.value for F in wrenches]


def speed_rows(cell, path, x, scale):
    """x at least 0, and |q' σ̇| within the velocity limits and the ends of the torque-speed curves."""
    limit = np.concatenate([robot.velocity_limit for robot in cell.robots])
    with np.errstate(divide="ignore"):
        largest = np.min((limit / np.abs(path.motion.dq)) ** 2, axis=1) / scale
    bounded = np.isfinite(largest)
    return [x >= 0, *([x[bounded] <= largest[bounded]] if np.any(bounded) else [])]


def jerk_rows(path, jerk, x, u, around, scale):
    """|q' u' + 3 q'' u + q''' x| √x within the limit at both ends of every segment, 1/√x by its tangent."""
    limited, h, rows = np.isfinite(jerk), np.diff(path.sigma)[:, None], []
    dq, ddq, third = (of[:, limited] / jerk[limited] for of in (path.motion.dq, path.motion.ddq, path.third))
    slope = cp.reshape(u[1:] - u[:-1], (len(h), 1), order="C")
    for end in (slice(None, -1), slice(1, None)):
        at = [cp.reshape(of[end], (len(h), 1), order="C") for of in (u, x)]
        pace = cp.multiply(dq[end] / h, slope) + cp.multiply(3 * ddq[end], at[0]) + cp.multiply(third[end], at[1])
        hat = around[end][:, None]
        most = (hat**-0.5 - 0.5 * cp.multiply(hat**-1.5, at[1] - hat)) / scale**1.5
        rows += [pace <= most, -pace <= most]
    return rows


def torque_rows(cell, model, rates, unknowns, roots, scale):
    """Torques and their rates within their limits; √x by its tangent where it presses, itself where it helps."""
    (x, u, F), (above, y, longest, around_times) = unknowns, roots
    n, joints = model.nodes, model.joints
    lower, upper = (robot_side(cell, side, "torque") for side in ("lower", "upper"))
    size = np.maximum(np.abs(lower), np.abs(upper))[None]
    torque, every = cp.Variable((n, joints)), np.tile(size[0], n)
    given = (model.square @ x + model.rate @ u) * scale + model.pull @ F + model.offset
    rows = [cp.reshape(torque, n * joints, order="C") == cp.multiply(given, 1 / every)]
    up, down = (np.maximum(sign * model.root, 0) * np.sqrt(scale) / size for sign in (1, -1))
    tangent, root = (cp.reshape(of, (n, 1), order="C") for of in (above, y))
    highest = torque + cp.multiply(up, tangent) - cp.multiply(down, root)
    lowest = torque + cp.multiply(up, root) - cp.multiply(down, tangent)
    rows += [highest <= upper / size, lowest >= lower / size]
    if rates.torque is not None:
        limited = np.flatnonzero(np.isfinite(rates.torque))
        share = (size / rates.torque)[:, limited] / around_times[:, None]
        most = cp.reshape(cp.multiply(longest, 1 / around_times), (n - 1, 1), order="C")
        for rise in (highest[1:] - lowest[:-1], highest[:-1] - lowest[1:]):
            rows.append(cp.multiply(share, rise[:, limited]) <= most)
    return rows


def wrench_rows(cell, model, rates, unknowns, longest, scale):
    """The balance of the object, wrenches within their limits, and their rates."""
    (x, u, F), (B, P, S, Q) = unknowns, model.balance
    rows = [(P @ x + S @ u) * scale + Q == B @ F]
    for side, sign in (("lower", -1.0), ("upper", 1.0)):
        limit = np.tile(sign * robot_side(cell, side, "wrench"), model.nodes)
        finite = np.flatnonzero(np.isfinite(limit))
        if finite.size:
            rows.append(cp.multiply(sign / model.size[finite], F[finite]) <= limit[finite] / model.size[finite])
    if rates.wrench is not None:
        limited = np.flatnonzero(np.isfinite(rates.wrench))
        table = cp.reshape(F, (model.nodes, model.wrenches), order="C")[:, limited]
        pace = cp.multiply(table[1:] - table[:-1], 1 / rates.wrench[None, limited])
        most = cp.reshape(longest, (model.nodes - 1, 1), order="C")
        rows += [pace <= most, -pace <= most]
    return rows
