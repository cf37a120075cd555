"""The fastest timing as one large program, for tests and benchmarks."""

import casadi as ca
import numpy as np

from mrts.timing.path_pieces import path_pieces


def transcription(cell, motion):
    """Duration by `transcribed` [s]."""
    return transcribed(cell, motion)()


def transcribed(cell, motion):
    """The same problem as one large program in speeds, rates and all wrenches; solves it by IPOPT when called.

    From the generated terms of the paper, with the balance of the object as equations: nothing of the projection, of
    the wrench form, or of the recursion is used.
    """
    (piece,) = path_pieces(motion)
    path, step, n = piece.path, piece.step, motion.samples
    terms = cell.functions("terms", n, path.inputs(cell.load))
    wrenches = terms["B"].shape[2]
    x, u = ca.SX.sym("x", n), ca.SX.sym("u", n - 1)
    variables, g, lower, upper = [x, u], [], [], []
    bounds = [np.concatenate([robot_side(cell, side, "torque")]) for side in ("lower", "upper")]
    wrench_bounds = [robot_side(cell, side, "wrench") for side in ("lower", "upper")]
    low, high = [np.zeros(n), np.full(n - 1, -np.inf)], [np.full(n, np.inf), np.full(n - 1, np.inf)]
    high[0][[0, -1]] = 0.0
    for i in range(n - 1):
        g.append(x[i + 1] - x[i] - 2 * step[i] * u[i])
        lower.append(np.zeros(1))
        upper.append(np.zeros(1))
        for end in (i, i + 1):
            F = ca.SX.sym(f"F{i}_{end}", wrenches)
            variables.append(F)
            low.append(wrench_bounds[0])
            high.append(wrench_bounds[1])
            torque = ca.DM(terms["E"][end]) * x[end] + ca.DM(terms["A"][end]) * u[i] + ca.DM(terms["G"][end])
            for name, joints in cell.joint_slices.items():
                torque[joints] += ca.DM(terms["J"][end][:, joints].T) @ F[cell.wrench_slices[name]]
            g.append(torque)
            lower.append(bounds[0])
            upper.append(bounds[1])
            moved = ca.DM(terms["S"][end]) * u[i] + ca.DM(terms["P"][end]) * x[end] + ca.DM(terms["Q"][end])
            g.append(ca.DM(terms["B"][end]) @ F - moved)
            lower.append(np.zeros(len(cell.wrench_components)))
            upper.append(np.zeros(len(cell.wrench_components)))
    speed = ca.sqrt(x + 1e-12)
    cost = ca.sum1(2 * ca.DM(step) / (speed[:-1] + speed[1:]))
    solver = ca.nlpsol(
        "transcription",
        "ipopt",
        {"x": ca.vertcat(*variables), "f": cost, "g": ca.vertcat(*g)},
        {"ipopt.print_level": 0, "print_time": False, "ipopt.sb": "yes", "ipopt.tol": 1e-8},
    )
    guess = np.zeros(sum(map(len, low)))
    guess[1 : n - 1] = 1e-3
    bounds = {"lbx": low, "ubx": high, "lbg": lower, "ubg": upper}
    arguments = {"x0": guess} | {name: np.concatenate(parts) for name, parts in bounds.items()}

    def solve():
        found = solver(**arguments)
        assert solver.stats()["success"]
        return float(found["f"])

    return solve


def robot_side(cell, side, kind):
    return np.concatenate([getattr(robot, f"{kind}_{side}") for robot in cell.robots])
