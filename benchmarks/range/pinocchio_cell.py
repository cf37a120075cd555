# SPDX-License-Identifier: MIT
"""What a user would write without mrts: the rows of a cell's sample by Pinocchio, its programs by HiGHS or SciPy.

Written to be fast: models are made once, arrays are filled in place, HiGHS keeps one model and starts each program from
the basis of the one before.
"""

from pathlib import Path

import highspy
import numpy as np
import pinocchio as pin
from scipy.optimize import linprog

import mrts
from mrts.base.arrays import Array


class PinocchioCell:
    """Rows over [F_1 … F_n, c²] of a cell whose arms share one URDF.

    Args:
        cell: Tells bases, grasps, limits and the object.
        urdf: Of every arm.
        tip: Its tip link.
    """

    def __init__(self, cell: mrts.Cell, urdf: Path, tip: str) -> None:
        self.cell, self.components = cell, cell.wrench_rows
        self.model = pin.buildModelFromUrdf(str(urdf))
        self.frame = self.model.getFrameId(tip)
        self.models = []
        for robot in cell.robots:
            model = self.model.copy()
            model.gravity.linear = robot.T_world_base.R.T @ cell.gravity
            self.models.append((model, model.createData()))
        w, n = len(self.components), len(cell.robots)
        self.joints = [len(robot.joints) for robot in cell.robots]
        self.A = np.zeros((sum(self.joints) + w, n * w + 1))
        self.low, self.high = np.zeros(len(self.A)), np.zeros(len(self.A))
        self.x_low = np.concatenate([*(robot.wrench_lower for robot in cell.robots), [0.0]])
        self.x_high = np.concatenate([*(robot.wrench_upper for robot in cell.robots), [np.inf]])

    def configurations(self, motion: mrts.CoordinatedMotion) -> Array:
        """Joint positions as Pinocchio takes them: cosine and sine of a continuous joint, Shape (N, arms, nq)."""
        columns = []
        for name, index in self.cell.joint_slices.items():
            q = motion.q[:, index]
            for place, joint in enumerate(self.model.joints[1:]):
                of_joint = q[:, place]
                columns += [of_joint] if joint.nq == 1 else [np.cos(of_joint), np.sin(of_joint)]
            if len(self.model.joints) - 1 != q.shape[1]:
                raise ValueError(name)
        return np.column_stack(columns).reshape(motion.samples, len(self.models), self.model.nq)

    def fill(self, motion: mrts.CoordinatedMotion, configurations: Array, k: int) -> None:
        """Put the rows of sample k into A, low and high."""
        w, row, q_at = len(self.components), 0, 0
        given, cell = motion.object, self.cell
        R_object = given.rotation[k]
        for index, robot in enumerate(cell.robots):
            model, data = self.models[index]
            joints = slice(q_at, q_at + self.joints[index])
            q, dq, ddq = configurations[k, index], motion.dq[k, joints], motion.ddq[k, joints]
            rows, columns = slice(row, row + self.joints[index]), slice(index * w, index * w + w)
            G = pin.computeGeneralizedGravity(model, data, q).copy()
            self.A[rows, -1] = pin.rnea(model, data, q, dq, ddq) - G
            J = pin.computeFrameJacobian(model, data, q, self.frame, pin.ReferenceFrame.LOCAL_WORLD_ALIGNED)
            self.A[rows, columns] = J[self.components].T
            self.low[rows], self.high[rows] = robot.torque_lower - G, robot.torque_upper - G
            R, r = robot.T_world_base.R, R_object @ robot.T_object_tip.p
            grasp = np.zeros((6, 6))
            grasp[:3, :3] = grasp[3:, 3:] = R
            grasp[3:, :3] = np.array([[0, -r[2], r[1]], [r[2], 0, -r[0]], [-r[1], r[0], 0]]) @ R
            self.A[-w:, columns] = grasp[np.ix_(self.components, self.components)]
            row, q_at = rows.stop, joints.stop
        inertia = R_object @ cell.inertia @ R_object.T
        spin = given.twist[k, 3:]
        P = np.empty(6)
        P[:3] = cell.mass * given.acceleration[k, :3]
        P[3:] = inertia @ given.acceleration[k, 3:] + np.cross(spin, inertia @ spin)
        Q = np.concatenate([-cell.mass * cell.gravity, np.zeros(3)])
        self.A[-w:, -1] = -P[self.components]
        self.low[-w:] = self.high[-w:] = Q[self.components]


class HighsRange:
    """Largest c² of a motion by one HiGHS model, both ends of every sample solved, each from the basis before."""

    def __init__(self, rows: PinocchioCell) -> None:
        self.rows = rows
        self.highs = highspy.Highs()
        self.highs.silent()
        self.highs.setOptionValue("presolve", "off")
        count, columns = rows.A.shape
        self.lp = highspy.HighsLp()
        self.lp.num_col_, self.lp.num_row_ = columns, count
        self.lp.col_cost_ = np.eye(columns)[-1]
        self.lp.col_lower_, self.lp.col_upper_ = rows.x_low, rows.x_high
        self.lp.a_matrix_.format_ = highspy.MatrixFormat.kRowwise
        self.lp.a_matrix_.start_ = np.arange(count + 1) * columns
        self.lp.a_matrix_.index_ = np.tile(np.arange(columns), count)

    def __call__(self, motion: mrts.CoordinatedMotion) -> float:
        """Largest c² of the whole motion."""
        highs, lp, found = self.highs, self.lp, np.inf
        bases: list[highspy.HighsBasis | None] = [None, None]
        configurations = self.rows.configurations(motion)
        for k in range(motion.samples):
            self.rows.fill(motion, configurations, k)
            lp.row_lower_, lp.row_upper_ = self.rows.low, self.rows.high
            lp.a_matrix_.value_ = self.rows.A.ravel()
            highs.passModel(lp)
            for end, sense in enumerate((highspy.ObjSense.kMinimize, highspy.ObjSense.kMaximize)):
                highs.changeObjectiveSense(sense)
                if bases[end] is not None:
                    highs.setBasis(bases[end])
                highs.run()
                bases[end] = highs.getBasis()
            if highs.getModelStatus() == highspy.HighsModelStatus.kOptimal:
                found = min(found, highs.getObjectiveValue())
        return found


class PinocchioArm:
    """Largest c² of one arm that holds its load welded: a row's limits are those of c², no program is needed.

    Args:
        model: Of the arm with the load.
        limits: Of its torques, Shape (m, 2) [N m].
    """

    def __init__(self, model: pin.Model, limits: Array) -> None:
        self.model, self.data, self.limits = model, model.createData(), limits

    def __call__(self, motion: mrts.CoordinatedMotion) -> float:
        """Largest c² of the whole motion."""
        gravity, driven = np.empty_like(motion.q), np.empty_like(motion.q)
        for k, (q, dq, ddq) in enumerate(zip(motion.q, motion.dq, motion.ddq, strict=True)):
            gravity[k] = pin.computeGeneralizedGravity(self.model, self.data, q)
            driven[k] = pin.rnea(self.model, self.data, q, dq, ddq)
        driven -= gravity
        with np.errstate(divide="ignore", invalid="ignore"):
            ends = (self.limits.T[:, None, :] - gravity) / driven
        return float(np.nanmin(np.where(driven == 0, np.inf, np.max(ends, axis=0))))


def linprog_range(rows: PinocchioCell, motion: mrts.CoordinatedMotion) -> float:
    """Largest c² of a motion by two calls of `scipy.optimize.linprog` a sample."""
    found = np.inf
    balance = len(rows.components)
    cost: Array = np.eye(rows.A.shape[1])[-1]
    bounds = np.column_stack([rows.x_low, rows.x_high])
    configurations = rows.configurations(motion)
    for k in range(motion.samples):
        rows.fill(motion, configurations, k)
        A, low, high = rows.A[:-balance], rows.low[:-balance], rows.high[:-balance]
        inequalities, sides = np.concatenate([A, -A]), np.concatenate([high, -low])
        for sense in (1, -1):
            end = linprog(sense * cost, inequalities, sides, rows.A[-balance:], rows.low[-balance:], bounds, "highs")
        if end.x is not None:
            found = min(found, float(end.x[-1]))
    return found
