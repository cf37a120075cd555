"""The fastest timing as one large program in speeds, rates and all wrenches, for tests and benchmarks."""

import casadi as ca
import numpy as np

from mrts.timing.path_pieces import path_pieces

SLOW = 1e-3
"""ṡ² from which IPOPT starts where nothing is said."""


def transcribed(cell, motion, guess=None):
    """What finds whether there is a timing and its speeds squared at the samples of a path of one piece, by IPOPT.

    From rest to rest, with the balance of the object as equations: nothing of the projection, of the wrench form or of
    the recursion is used. The variables are ṡ, so nothing is replaced by tangents or chords. Terms of the arms are the
    generated ones, those of motors are written out: τ = E ṡ² + A s̈ + G + JᵀF + I (q'' ṡ² + q' s̈) + b q' ṡ + c sign(q');
    curves limit |τ + m q' ṡ| and |q' ṡ|. It starts from speeds squared that are guessed.
    """
    (piece,) = path_pieces(cell, motion)
    path, step, n = piece.path, piece.step, motion.samples
    terms = cell.functions("terms", n, path.inputs(cell.load))
    wrenches, joints = terms["B"].shape[2], path.q.shape[1]
    armature, coulomb, viscous = (
        np.concatenate([getattr(robot.motors, name) for robot in cell.robots])
        for name in ("armature", "coulomb", "viscous")
    )
    curves = [curve for robot in cell.robots for curve in robot.motors.torque_speed]
    y = ca.SX.sym("y", n)
    variables, g, lower, upper = [y], [], [], []
    low, high, start = [np.zeros(n)], [np.full(n, np.inf)], [np.sqrt(np.full(n, SLOW) if guess is None else guess)]
    high[0][[0, -1]] = 0.0
    limits = [robot_side(cell, side, "torque") for side in ("lower", "upper")]
    for i in range(n - 1):
        u = (y[i + 1] ** 2 - y[i] ** 2) / (2 * step[i])
        for end in (i, i + 1):
            F = ca.SX.sym(f"F{i}_{end}", wrenches)
            variables.append(F)
            low.append(robot_side(cell, "lower", "wrench"))
            high.append(robot_side(cell, "upper", "wrench"))
            start.append(np.zeros(wrenches))
            dq, ddq, x = path.dq[end], path.ddq[end], y[end] ** 2
            torque = ca.DM(terms["E"][end] + armature * ddq) * x + ca.DM(terms["A"][end] + armature * dq) * u
            torque += ca.DM(terms["G"][end] + coulomb * np.sign(dq)) + ca.DM(viscous * dq) * y[end]
            for name, part in cell.joint_slices.items():
                torque[part] += ca.DM(terms["J"][end][:, part].T) @ F[cell.wrench_slices[name]]
            g.append(torque)
            lower.append(limits[0])
            upper.append(limits[1])
            for j in range(joints):
                if curves[j] is None:
                    continue
                (v, t), steps = curves[j][:-1].T, np.diff(curves[j], axis=0)
                for m, a in zip(-steps[:, 1] / steps[:, 0], t - v * steps[:, 1] / steps[:, 0], strict=True):
                    g.append(torque[j] + m * dq[j] * y[end])
                    lower.append([-a])
                    upper.append([a])
                high[0][end] = min(high[0][end], curves[j][-1, 0] / abs(dq[j])) if dq[j] else high[0][end]
            moved = ca.DM(terms["S"][end]) * u + ca.DM(terms["P"][end]) * x + ca.DM(terms["Q"][end])
            g.append(ca.DM(terms["B"][end]) @ F - moved)
            lower.append(np.zeros(len(cell.wrench_components)))
            upper.append(np.zeros(len(cell.wrench_components)))
    solver = ca.nlpsol(
        "transcription",
        "ipopt",
        {"x": ca.vertcat(*variables), "f": ca.sum1(2 * ca.DM(step) / (y[:-1] + y[1:])), "g": ca.vertcat(*g)},
        {
            "ipopt.print_level": 0,
            "print_time": False,
            "ipopt.sb": "yes",
            "ipopt.tol": 1e-10,
            "ipopt.max_iter": 2000,
            "ipopt.bound_relax_factor": 0.0,
        },
    )
    bounds = {"lbx": low, "ubx": high, "lbg": lower, "ubg": upper}
    arguments = {"x0": start} | bounds

    def solve():
        found = solver(**{name: np.concatenate(parts) for name, parts in arguments.items()})
        return solver.stats()["success"], np.asarray(found["x"])[:n, 0] ** 2

    return solve


def robot_side(cell, side, kind):
    return np.concatenate([getattr(robot, f"{kind}_{side}") for robot in cell.robots])
