"""An independent implementation of the range of c²: Pinocchio for the arms, HiGHS for the programs.

Nothing of mrts is used: the cell and motion files are read as plain YAML, inverse kinematics is a Newton iteration,
and the linear programs keep all wrenches and the balance as equalities.
"""

from dataclasses import dataclass
from pathlib import Path

import highspy
import numpy as np
import pinocchio as pin
import yaml
from random_cells import chain_model, configuration

ROWS = {None: [0, 1, 2, 3, 4, 5], "xy": [0, 1, 5], "xz": [0, 2, 4], "yz": [1, 2, 3]}
NEWTON_TOLERANCE = 1e-12
HIGHS_TOLERANCE = 1e-10


def rpy_matrix(rpy):
    return pin.rpy.rpyToMatrix(*map(float, rpy))


def profile(name, u):
    """Path fraction and its two derivatives over normalised time, written with polynomials and integrals."""
    if name == "sinusoid":
        s = np.sin(np.pi * u / 2) ** 2
        return s, np.pi * np.sqrt(s * (1 - s)), np.pi**2 * (1 - 2 * s) / 2
    if name == "trapezoid":
        ramp = 1 / 3
        acceleration = 1 / (ramp * (1 - ramp))
        rounding = 1e-12  # a sample at a corner takes the ramp's acceleration, however its u is rounded
        if u <= ramp + rounding:
            return acceleration * u * u / 2, acceleration * u, acceleration
        if u >= 1 - ramp - rounding:
            return 1 - acceleration * (1 - u) ** 2 / 2, acceleration * (1 - u), -acceleration
        return acceleration * ramp * (u - ramp / 2), acceleration * ramp, 0.0
    coefficients = {"cubic": [-2, 3, 0, 0], "quintic": [6, -15, 10, 0, 0, 0]}[name]
    return tuple(np.polyval(np.polyder(coefficients, order), u) for order in range(3))


@dataclass
class Arm:
    model: object
    data: object
    frame: int
    base: object
    grasp: object
    posture: np.ndarray
    torque: np.ndarray
    wrench: np.ndarray


@dataclass
class Terms:
    """Of one sample: lists over arms, then the object."""

    E: list
    G: list
    J: list
    B: list
    P: np.ndarray
    Q: np.ndarray


NO_VELOCITY_LIMIT = 1e3
"""[rad/s, m/s]; the URDF parser writes a large number where there is none."""


class ReferenceCell:
    def __init__(self, path: Path) -> None:
        self.description = yaml.safe_load(Path(path).read_text())
        self.rows = ROWS[self.description.get("plane")]
        self.gravity = np.array(self.description["gravity"], dtype=float)
        self.mass = self.description["object"]["mass"]
        inertia = np.array(self.description["object"]["inertia"], dtype=float)
        self.inertia = np.diag(inertia) if inertia.ndim == 1 else inertia
        self.arms = [self._arm(robot, Path(path).parent) for robot in self.description["robots"]]

    def _arm(self, robot, folder):
        model = chain_model(folder / robot["urdf"], robot["tip_link"])
        pose = {key: robot.get(key, {}) for key in ("base", "grasp")}
        base, grasp = (
            pin.SE3(rpy_matrix(value.get("rpy", [0, 0, 0])), np.array(value.get("xyz", [0, 0, 0]), dtype=float))
            for value in pose.values()
        )
        model.gravity.linear = base.rotation.T @ self.gravity
        size = len(self.rows)
        bounds = robot.get("wrench", {})
        wrench = np.array(
            [
                [default if value is None else value for value in bounds.get(side) or [None] * size]
                for side, default in (("lower", -np.inf), ("upper", np.inf))
            ]
        )
        torque = np.array(robot.get("torque", model.effortLimit), dtype=float)
        frame, posture = model.getFrameId(robot["tip_link"]), np.array(robot["posture"])
        return Arm(model, model.createData(), frame, base, grasp, posture, np.array([-torque, torque]), wrench)

    def object_motion(self, path: Path):
        motion = yaml.safe_load(Path(path).read_text())
        time = np.linspace(0, motion["duration"], motion["samples"])
        p0, p1 = (np.array(motion[end]["xyz"], dtype=float) for end in ("start", "end"))
        R0, R1 = (rpy_matrix(motion[end].get("rpy", [0, 0, 0])) for end in ("start", "end"))
        axis = pin.log3(R1 @ R0.T)
        samples = []
        for t in time:
            s, ds, dds = profile(motion["profile"], t / motion["duration"])
            ds, dds = ds / motion["duration"], dds / motion["duration"] ** 2
            pose = pin.SE3(pin.exp3(s * axis) @ R0, p0 + s * (p1 - p0))
            samples.append((pose, ds * (p1 - p0), ds * axis, dds * (p1 - p0), dds * axis))
        return time, samples

    def joint_motion(self, samples):
        """q, q', q'' of every arm at every sample."""
        motions = []
        for arm in self.arms:
            q = arm.posture.copy()
            history = []
            for pose, v, w, a, dw in samples:
                target = arm.base.inverse() * pose * arm.grasp
                q = self._newton(arm, q, target)
                J = self._jacobian(arm, q)
                R = arm.base.rotation.T
                r = pose.rotation @ arm.grasp.translation
                twist = np.concatenate([R @ (v + np.cross(w, r)), R @ w])
                rate = np.concatenate([R @ (a + np.cross(dw, r) + np.cross(w, np.cross(w, r))), R @ dw])
                dq = np.linalg.solve(J[self.rows], twist[self.rows])
                pin.forwardKinematics(arm.model, arm.data, configuration(arm.model, q), dq, np.zeros_like(dq))
                bias = pin.getFrameClassicalAcceleration(
                    arm.model, arm.data, arm.frame, pin.ReferenceFrame.LOCAL_WORLD_ALIGNED
                ).vector
                ddq = np.linalg.solve(J[self.rows], (rate - bias)[self.rows])
                history.append((q.copy(), dq, ddq))
            motions.append(history)
        return motions

    def _jacobian(self, arm, q):
        pin.computeJointJacobians(arm.model, arm.data, configuration(arm.model, q))
        pin.updateFramePlacements(arm.model, arm.data)
        return pin.getFrameJacobian(arm.model, arm.data, arm.frame, pin.ReferenceFrame.LOCAL_WORLD_ALIGNED)

    def _newton(self, arm, q, target):
        for _ in range(100):
            J = self._jacobian(arm, q)
            tip = arm.data.oMf[arm.frame]
            error = np.concatenate(
                [target.translation - tip.translation, tip.rotation @ pin.log3(tip.rotation.T @ target.rotation)]
            )
            if np.max(np.abs(error)) < NEWTON_TOLERANCE:
                return q
            step = np.linalg.solve(J[self.rows], error[self.rows])
            q = q + step * min(1.0, 0.3 / max(np.max(np.abs(step)), 1e-300))
        raise AssertionError("the reference's Newton iteration did not converge")

    def terms(self, sample, joints) -> Terms:
        pose, _v, w, a, dw = sample
        E, G, J, B = [], [], [], []
        for arm, (q, dq, ddq) in zip(self.arms, joints, strict=True):
            full_q = configuration(arm.model, q)
            gravity = pin.computeGeneralizedGravity(arm.model, arm.data, full_q)
            E.append(pin.rnea(arm.model, arm.data, full_q, dq, ddq) - gravity)
            G.append(gravity.copy())
            J.append(self._jacobian(arm, q)[self.rows])
            R, r = arm.base.rotation, pose.rotation @ arm.grasp.translation
            full = np.block([[R, np.zeros((3, 3))], [pin.skew(r) @ R, R]])
            B.append(full[np.ix_(self.rows, self.rows)])
        I_w = pose.rotation @ self.inertia @ pose.rotation.T
        P = np.concatenate([self.mass * a, I_w @ dw + np.cross(w, I_w @ w)])[self.rows]
        Q = np.concatenate([-self.mass * self.gravity, np.zeros(3)])[self.rows]
        return Terms(E, G, J, B, P, Q)

    def range_at(self, terms: Terms, joints, *, even: bool):
        """(status, lower, upper) of one sample; velocities bound c² as their URDFs say."""
        A, lower, upper, x_lower, x_upper = self.program(terms, even=even)
        for arm, (_, dq, _) in zip(self.arms, joints, strict=True):
            for limit, rate in zip(arm.model.velocityLimit, np.abs(dq), strict=True):
                if 0 < limit < NO_VELOCITY_LIMIT and rate > 0:
                    x_upper[-1] = min(x_upper[-1], (limit / rate) ** 2)
        return highs_range(A, lower, upper, x_lower, x_upper)

    def program(self, terms: Terms, *, even: bool):
        """Rows over [F_1 … F_n, c²]: matrix, lower, upper, and bounds of the unknowns."""
        w, n = len(self.rows), len(self.arms)
        A, lower, upper = [], [], []
        for index, arm in enumerate(self.arms):
            block = np.zeros((terms.J[index].shape[1], n * w + 1))
            block[:, index * w : (index + 1) * w] = terms.J[index].T
            block[:, -1] = terms.E[index]
            A.append(block)
            lower.append(arm.torque[0] - terms.G[index])
            upper.append(arm.torque[1] - terms.G[index])
        balance = np.hstack([*terms.B, -terms.P[:, None]])
        A.append(balance)
        lower.append(terms.Q)
        upper.append(terms.Q)
        if even:
            rows, rhs = self._even_rows()
            A.append(rows)
            lower.append(rhs)
            upper.append(rhs)
        x_lower = np.concatenate([*(arm.wrench[0] for arm in self.arms), [0.0]])
        x_upper = np.concatenate([*(arm.wrench[1] for arm in self.arms), [np.inf]])
        return np.vstack(A), np.concatenate(lower), np.concatenate(upper), x_lower, x_upper

    def _even_rows(self):
        """All forces equal and all contact moments equal, in world axes."""
        w, n = len(self.rows), len(self.arms)
        rows = []
        for index in range(1, n):
            for component in range(w):
                row = np.zeros(n * w + 1)
                for sign, robot in ((1, 0), (-1, index)):
                    R = np.kron(np.eye(2), self.arms[robot].base.rotation)[np.ix_(self.rows, self.rows)]
                    row[robot * w : (robot + 1) * w] = sign * R[component]
                rows.append(row)
        return np.reshape(rows, (-1, n * w + 1)), np.zeros(len(rows))


def highs_range(A, lower, upper, x_lower, x_upper):
    """Minimum and maximum of the last unknown by HiGHS: (status, lower, upper)."""
    ends = []
    for direction in (1.0, -1.0):
        status, value = highs_minimum(A, lower, upper, x_lower, x_upper, direction)
        if status == highspy.HighsModelStatus.kInfeasible:
            return "infeasible", np.inf, -np.inf
        if status in {highspy.HighsModelStatus.kUnbounded, highspy.HighsModelStatus.kUnboundedOrInfeasible}:
            ends.append(-np.inf)
            continue
        assert status == highspy.HighsModelStatus.kOptimal, status
        ends.append(value)
    low, high = ends[0], -ends[1]
    return ("unbounded" if np.isinf(high) else "feasible"), low, high


def highs_minimum(A, lower, upper, x_lower, x_upper, direction):
    highs = exact_highs()
    highs.passModel(filled(highspy.HighsLp(), A, lower, upper, x_lower, x_upper, last_cost(A, direction)))
    highs.run()
    return highs.getModelStatus(), highs.getInfo().objective_function_value


def exact_highs():
    """HiGHS with the least tolerances that it has."""
    highs = highspy.Highs()
    highs.silent()
    for option in ("primal_feasibility_tolerance", "dual_feasibility_tolerance"):
        highs.setOptionValue(option, HIGHS_TOLERANCE)
    highs.setOptionValue("presolve", "off")
    return highs


def last_cost(A, direction):
    """The cost that is the last unknown, or its negative."""
    return np.append(np.zeros(A.shape[1] - 1), direction)


def filled(lp, A, lower, upper, x_lower, x_upper, cost):
    """A linear program of HiGHS with these numbers."""
    rows, columns = A.shape
    lp.num_col_, lp.num_row_ = columns, rows
    lp.col_cost_, lp.col_lower_, lp.col_upper_ = cost, x_lower, x_upper
    lp.row_lower_, lp.row_upper_ = lower, upper
    lp.a_matrix_.format_ = highspy.MatrixFormat.kColwise
    lp.a_matrix_.start_ = np.arange(columns + 1) * rows
    lp.a_matrix_.index_ = np.tile(np.arange(rows), columns)
    lp.a_matrix_.value_ = A.T.ravel()
    return lp


def highs_cost(A, lower, upper, x_lower, x_upper, H, g):
    """Minimum of ½ xᵀHx + gᵀx by HiGHS."""
    columns, model = A.shape[1], highspy.HighsModel()
    filled(model.lp_, A, lower, upper, x_lower, x_upper, g)
    starts, indices, values = [0], [], []
    for column in range(columns):
        indices += range(column, columns)
        values += H[column:, column].tolist()
        starts.append(len(indices))
    model.hessian_.dim_ = columns
    model.hessian_.format_ = highspy.HessianFormat.kTriangular
    model.hessian_.start_, model.hessian_.index_, model.hessian_.value_ = starts, indices, values
    highs = highspy.Highs()
    highs.silent()
    highs.passModel(model)
    highs.run()
    assert highs.getModelStatus() == highspy.HighsModelStatus.kOptimal
    return highs.getInfo().objective_function_value
