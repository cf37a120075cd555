"""Timing of one arm with limited velocity, torque and jerk by copp's third-order solver.

As its authors advise: the second-order optimum is the first linearisation and an upper end of ṡ², and the answer is
linearised about once more, with both of its profiles.
"""

from dataclasses import dataclass
from typing import Any

import copp_py as copp
import numpy as np
from jerk_paths import JerkPath

import mrts

ROUNDS = 2
REST = (0.0, 0.0)


@dataclass(frozen=True, eq=False)
class PathProfile:
    """ṡ², s̈ and s⃛ densely along a path, and its duration [s]."""

    s: np.ndarray
    square: np.ndarray
    rate: np.ndarray
    jerk: np.ndarray
    duration: float

    def excess(self, path: JerkPath) -> list[float]:
        """The largest overstepping of velocity, torque and jerk limits, each as a share of its limit."""
        first, second, third = (path.at(self.s, order) for order in (1, 2, 3))
        speed, (most_speed, most_torque, most_jerk) = np.sqrt(self.square)[:, None], path.limits
        x, u, j = self.square[:, None], self.rate[:, None], self.jerk[:, None]
        velocity, acceleration = first * speed, first * u + second * x
        jerk = first * j + 3 * second * u * speed + third * x * speed
        q = path.at(self.s)
        torque = np.array([path.torque(*row) for row in zip(q, velocity, acceleration, strict=True)])
        shares = (np.abs(velocity) / most_speed, np.abs(torque) / most_torque, np.abs(jerk) / most_jerk)
        return [float(np.max(share)) - 1 for share in shares]


def constraints_of(path: JerkPath, nodes: int) -> tuple[Any, np.ndarray]:
    """Copp's robot at evenly spaced points of a path, with its limits, and the points."""
    s = np.linspace(0, 1, nodes)
    derivatives = [np.ascontiguousarray(path.at(s, order)) for order in range(4)]
    speed, torque, jerk = path.limits
    robot = copp.Robot(len(jerk), capacity=nodes, inverse_dynamics=path.torque)
    robot.append_s(s)
    robot.set_q(*derivatives[:3], 0, dddq=derivatives[3])
    robot.add_velocity_limits(speed, -speed, start_idx_s=0, length=nodes)
    robot.add_torque_limits(torque, -torque, start_idx_s=0, length=nodes)
    robot.add_jerk_limits(jerk, -jerk, start_idx_s=0, length=nodes)
    return robot, s


def by_copp(path: JerkPath, nodes: int, rounds: int = ROUNDS) -> tuple[Any, np.ndarray, float]:
    """Copp's profile and duration [s]."""
    robot, s = constraints_of(path, nodes)
    profile = third_order(robot, nodes, rounds)
    duration, _ = copp.interpolation.s_to_t_topp3(s, profile)
    return profile, s, duration


def third_order(robot: Any, nodes: int, rounds: int = ROUNDS) -> Any:
    """Linearisations one after the other, the first about the second-order optimum."""
    second = copp.solver.topp2_ra.Problem(robot.constraints, idx_s_interval=(0, nodes - 1), a_boundary=REST)
    a, b = copp.solver.topp2_ra.solve(second, copp.solver.topp2_ra.Options()), None
    robot.constraints.amax_substitute(a, 0)
    for _ in range(rounds):
        problem = copp.solver.topp3_socp.Problem(
            robot.constraints, a, a_boundary=REST, b_boundary=REST, num_stationary_max=1, b_linearization=b
        )
        profile = copp.solver.topp3_socp.solve(problem)
        a, b = profile.a, profile.b
    return profile


def dense(profile: Any, s: np.ndarray, duration: float, points: int) -> PathProfile:
    """Copp's profile between its points: s̈ linear along s, but a constant s⃛ in the segments at rest."""
    a, b, (start, end), h = profile.a, profile.b, profile.num_stationary, np.diff(s)
    share, n = np.linspace(0, 1, points), len(s)
    parts = []
    for k in range(start, n - 1 - end):
        away, slope = share * h[k], (b[k + 1] - b[k]) / h[k]
        x = np.maximum(a[k] + 2 * b[k] * away + slope * away**2, 0.0)
        parts.append((s[k] + away, x, b[k] + slope * away, slope * np.sqrt(x)))
    for edge, sign, count in ((start, 1, start), (n - 1 - end, -1, end)):
        if count:
            way = s[edge] - (s[0] if sign > 0 else s[-1])
            x, u = a[edge] * share ** (4 / 3), b[edge] * share ** (1 / 3)
            jerk = np.full(points, b[edge] * np.sqrt(a[edge]) / (3 * way))
            parts.append((s[0 if sign > 0 else -1] + share * way, x, u, jerk))
    return PathProfile(*(np.concatenate(column) for column in zip(*parts, strict=True)), duration)


def dense_of_ours(found: mrts.RetimingResult, path: JerkPath, points: int) -> PathProfile:
    """Our profile between its nodes, the second derivative of its parameter linear along it; the path is exact."""
    (piece,) = found.pieces
    sigma, away = piece.piece.path.object.time, np.linspace(0, 1, points)
    h, u = np.diff(sigma), piece.steps.profile.u
    x0, u0, slope = (np.repeat(part, points) for part in (piece.x[:-1], u[:-1], np.diff(u) / h))
    gone = (h[:, None] * away).ravel()
    x, u = x0 + 2 * u0 * gone + slope * gone**2, u0 + slope * gone
    share = (np.repeat(sigma[:-1], points) + gone) / sigma[-1]
    s, *derivatives = path.course(np.minimum(share, 1.0))
    s1, s2, s3 = (part / sigma[-1] ** order for order, part in enumerate(derivatives, 1))
    jerk = (s1 * slope + 3 * s2 * u + s3 * x) * np.sqrt(x)
    return PathProfile(s, s1**2 * x, s1 * u + s2 * x, jerk, found.duration)
