"""The fastest timing with motors as one large program in speeds, rates and all wrenches, for tests."""

import casadi as ca
import numpy as np
from transcription import robot_side

from mrts.timing.path_pieces import path_pieces


def motor_transcription(cell, motion, guess):
    """Speeds squared at the samples of a path of one piece, from rest to rest, by IPOPT.

    The variables are ṡ, so nothing is replaced by tangents or chords. Terms of the arms are the generated ones,
    those of motors are written out here: τ = E ṡ² + A s̈ + G + JᵀF + I (q'' ṡ² + q' s̈) + b q' ṡ + c sign(q');
    curves limit |τ + m q' ṡ| and |q' ṡ|.

    Args:
        cell: Cell with motors.
        motion: Its motion.
        guess: Speeds squared to start from.
    """
    (piece,) = path_pieces(motion)
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
    low, high, start = [np.zeros(n)], [np.full(n, np.inf)], [np.sqrt(guess)]
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
        "motor_transcription",
        "ipopt",
        {
            "x": ca.vertcat(*variables),
            "f": ca.sum1(2 * ca.DM(step) / (y[:-1] + y[1:])),
            "g": ca.vertcat(*g),
        },
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
    found = solver(x0=np.concatenate(start), **{name: np.concatenate(parts) for name, parts in bounds.items()})
    return solver.stats()["success"], np.asarray(found["x"])[:n, 0] ** 2
