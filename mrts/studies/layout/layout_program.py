# SPDX-License-Identifier: MIT
"""One sparse nonlinear program: the layout, the joints and wrenches of all samples, and c².

Largest c² over layout θ, q_k, q'_k, q''_k and F_k of N samples, by IPOPT (Wächter and Biegler, 2006). Grasp closure and
its two derivatives hold at each sample, and so do the rows of all limits, for every load. Balance of the object is kept
by eliminating the last arm's wrench. Redundant arms have the joint positions that `mrts.following.null_space` chooses.
Derivatives are CasADi's, of the expressions that the generated C is made of.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from mrts.base.arrays import Array, apply
from mrts.base.errors import InputError
from mrts.base.manifest import GRAVITY_SIZE, ROBOT_SIZE
from mrts.cell.cell import Cell
from mrts.cell.hands import triple_axes
from mrts.cell.points import ArmPointLimit
from mrts.cell.robot import Robot
from mrts.following.coordinated_motion import CoordinatedMotion
from mrts.following.null_space import LIMIT_PUSH, is_redundant, limit_zone, stretched
from mrts.limits import limit_rows
from mrts.limits.rows import LimitRows
from mrts.program.motor_terms import MotorTerms, motor_terms
from mrts.scaling.result import ScalingResult
from mrts.studies.layout.layout_numbers import LayoutNumbers

IPOPT_TOLERANCE = 1e-8
"""Of the scaled program: c² is then right to more digits than are printed."""

ITERATIONS = 300
"""Most iterations of IPOPT; some ten to thirty are usual."""

SAME_ROW = 1e-9
"""Share of the largest entry by which a row may differ from what is linear in the joint velocities: rounding."""

IPOPT_OPTIONS: dict[str, Any] = {
    "print_time": False,
    "error_on_fail": False,
    "calc_lam_p": False,
    "ipopt.print_level": 0,
    "ipopt.sb": "yes",
    "ipopt.tol": IPOPT_TOLERANCE,
    "ipopt.max_iter": ITERATIONS,
    "ipopt.mu_strategy": "adaptive",
    # by default IPOPT oversteps bounds by 1e-8 of their size
    "ipopt.bound_relax_factor": 0.0,
}


@dataclass(frozen=True)
class LayoutAnswer:
    """What IPOPT found.

    Attributes:
        layout: Values of the numbers, Shape (P,).
        c2: c²⁺ there, of the samples of the program.
        slope: ∂ ln c²⁺/∂θ there, from the multipliers, Shape (P,): zero at a maximum inside the bounds.
        start: Joint positions at the program's first sample, Shape (m,) [rad or m].
        solved: Whether it is a local optimum.
    """

    layout: Array
    c2: float
    slope: Array
    start: Array
    solved: bool


def solve_layout(
    functions: dict[str, Any],
    numbers: LayoutNumbers,
    layout: Array,
    played: ScalingResult,
    samples: NDArray[np.intp],
    *,
    stop: Callable[[], bool] = lambda: False,
) -> LayoutAnswer:
    """The local optimum that a search from a layout ends at.

    Args:
        functions: CasADi's functions of the cell.
        numbers: The numbers of the layout.
        layout: Their values at the start, Shape (P,).
        played: What `mrts.scale` finds there, with torques; says which chains, limits and loads.
        samples: Indices of its motion's samples, N of them.
        stop: Asked at every iteration whether the search is to end.
    """
    assert played.trajectory is not None and played.range.upper is not None  # noqa: S101, PT018 (it is playable)
    cell, motion = played.cell, played.motion
    loads = [cell.load] if played.load is None else [point.load for point in played.load.points]
    P, N, m = len(layout), len(samples), motion.q.shape[1]
    redundant = _redundant_joints(cell)
    force = _multipliers(cell, motion.q[samples], motion.q[0])
    theta, log_c2 = ca.SX.sym("layout", P), ca.SX.sym("log_c2")
    reference, first_force = ca.SX.sym("reference", len(redundant)), ca.SX.sym("multiplier", force.shape[1])
    shared = ca.vertcat(theta, log_c2, reference, first_force)
    geometry = numbers.geometry(cell, theta)
    limits = _Limits.of(_without_arm_points(cell), motion.at(samples))
    sample = _sample_function(cell, functions, geometry, (shared, log_c2, reference), force.shape[1], limits, loads)
    posture = numbers.postures(cell, theta)
    begin = _start_equations(cell, functions, motion, geometry, (shared, reference, first_force), posture)

    unknowns, ours = ca.MX.sym("unknowns", sample.size1_in(0), N), ca.MX.sym("shared", shared.numel())
    given = np.concatenate([_object_columns(motion.at(samples)), limits.columns])
    rows = sample.map("samples", "serial", N, [1], [])(unknowns, ours, ca.DM(given))
    program = {
        "x": ca.vertcat(ours, ca.vec(unknowns)),
        "f": -ours[P],
        "g": ca.vertcat(begin(ours), ca.vec(rows)),
    }
    row_bounds = []
    points = len(_point_rows(cell, *(ca.SX(m, 1),) * 3, 1.0))
    for bound, end in zip(limits.bounds, (-np.inf, 1.0), strict=True):
        of_loads = [bound, *[bound[:, limits.rows.of_forces]] * (len(loads) - 1), np.full((N, points), end)]
        held = np.zeros((N, sample.size1_out(0) - sum(each.shape[1] for each in of_loads)))
        row_bounds.append(np.append(np.zeros(begin.numel_out()), np.concatenate([held, *of_loads], axis=1)))
    unknown_bounds = []
    for side, sign, values in (("lower", -1, numbers.lower), ("upper", 1, numbers.upper)):
        each = np.full(sample.size1_in(0), sign * np.inf)
        each[:m] = np.concatenate([getattr(robot, f"position_{side}") for robot in cell.robots])
        others = np.append(getattr(limits, f"log_c2_{side}"), np.full(shared.numel() - P - 1, sign * np.inf))
        unknown_bounds.append(np.concatenate([values, others, np.tile(each, N)]))

    starts = [getattr(motion, name)[samples] for name in ("q", "dq", "ddq")]
    starts += [played.trajectory.wrench[samples, : -len(cell.wrench_components)]] * len(loads)
    starts += [force, np.zeros((N, 2 * force.shape[1]))]
    postures = cell.posture
    begin_at = [motion.q[0, redundant], _multipliers(cell, motion.q[:1], postures)[0]]
    x0 = [layout, [np.log(played.range.upper.c2)], *begin_at, np.concatenate(starts, axis=1).ravel()]
    watch = _Watch(program["x"].numel(), program["g"].numel(), stop)
    solver = ca.nlpsol("layout", "ipopt", program, IPOPT_OPTIONS | {"iteration_callback": watch})
    found = solver(
        x0=np.concatenate(x0), lbx=unknown_bounds[0], ubx=unknown_bounds[1], lbg=row_bounds[0], ubg=row_bounds[1]
    )
    x = found["x"].full()[:, 0]
    jacobian = solver.get_function("nlp_jac_g")(x=x)["jac_g_x"][:, :P]
    return LayoutAnswer(
        layout=np.clip(x[:P], numbers.lower, numbers.upper),
        c2=float(np.exp(x[P])),
        slope=-(jacobian.T @ found["lam_g"]).full()[:, 0],
        start=x[shared.numel() : shared.numel() + m],
        solved=bool(solver.stats()["success"]),
    )


def _sample_function(
    cell: Cell,
    functions: dict[str, Any],
    geometry: Any,
    shared: tuple[Any, Any, Any],
    forces: int,
    limits: "_Limits",
    loads: Sequence[Array],
) -> Any:
    """All equations of one sample, then the rows of all limits in their units.

    Args:
        cell: The cell that the search starts from.
        functions: CasADi's functions of the cell.
        geometry: Of the cell, in terms of the layout, Shape (g,).
        shared: What all samples share; of it, ln c² and the joint positions that redundant arms stay near.
        forces: Size of the multipliers of redundant arms.
        limits: The rows.
        loads: Load vectors, all of which must be carried, Shape (10,) each.

    Returns:
        Function of the sample's unknowns [q, q', q'', free wrenches for each load, multipliers of redundant arms and
        their two derivatives], of the shared ones and of what is given of it [object, s, e, dry friction].
    """
    whole, log_c2, reference = shared
    r, m = limits.by_velocity.shape
    free = len(cell.wrench_components) * (len(cell.robots) - 1)
    q, dq, ddq = position = tuple(ca.SX.sym(name, m) for name in ("q", "dq", "ddq"))
    wrenches = [ca.SX.sym(f"F{index}", free) for index in range(len(loads))]
    force = tuple(ca.SX.sym(name, forces) for name in ("f", "df", "ddf"))
    carried = ca.SX.sym("p", 3), ca.SX.sym("R", 3, 3), ca.SX.sym("twist", 6), ca.SX.sym("acceleration", 6)
    s, e, dry = ca.SX.sym("s", r), ca.SX.sym("e", r), ca.SX.sym("dry", m)

    equations = [*_grasp_equations(cell, functions, position, carried, geometry)]
    if reference.numel():
        nearest = _preference(cell, functions, q, force[0], reference, geometry)
        equations.append(_along_path(nearest, position, force))

    c2, c = ca.exp(log_c2), ca.exp(log_c2 / 2)
    of_speed = (ca.DM(limits.by_velocity) @ dq + s) * c + (ca.DM(limits.by_acceleration) @ ddq + e) * c2
    armature, viscous = (
        np.concatenate([getattr(robot.motors, name) for robot in cell.robots]) for name in ("armature", "viscous")
    )
    of_motors = ca.DM(armature) * ddq * c**2 + ca.DM(viscous) * dq * c + dry
    values: list[Any] = []
    for load, wrench in zip(loads, wrenches, strict=True):
        form = functions["wrench_form"](
            q=q,
            dq=dq,
            ddq=ddq,
            object_rotation=carried[1],
            object_twist=carried[2],
            object_acceleration=carried[3],
            load=load,
            geometry=geometry,
        )
        x = ca.vertcat(wrench, c2)
        F = form["wrench_map"] @ x + form["wrench_offset"]
        torque = form["torque_map"] @ x + form["torque_offset"] + of_motors
        value = limits.values(torque, F, _turned_wrenches(cell, F, carried[1], geometry), of_speed)
        values.append(value[np.flatnonzero(limits.rows.of_forces).tolist()] if values else value)
    values += _point_rows(cell, q, dq, ddq, c2)
    position_, R, *rates = carried
    return ca.Function(
        "sample",
        [ca.vertcat(*position, *wrenches, *force), whole, ca.vertcat(position_, ca.vec(R), *rates, s, e, dry)],
        ca.cse([ca.densify(ca.vertcat(*equations, *values))]),
    )


def _without_arm_points(cell: Cell) -> Cell:
    return replace(cell, robots=tuple(replace(robot, point_limits=()) for robot in cell.robots))


def _point_rows(cell: Cell, q: Any, dq: Any, ddq: Any, c2: Any) -> list[Any]:
    """Squares of what points of arms use of their limits at a c², at most 1 each."""
    rows, kept = [], 1 - cell.reserve
    for robot, joints in zip(cell.robots, cell.joint_slices.values(), strict=True):
        for point in robot.point_limits:
            velocity, acceleration = _point_rates(robot, point, q[joints], dq[joints], ddq[joints])
            if point.speed is not None and cell.enforces_velocity_limits:
                rows.append(ca.sumsqr(velocity) * c2 / (kept * point.speed) ** 2)
            if point.acceleration is not None:
                rows.append(ca.sumsqr(acceleration) * c2**2 / (kept * point.acceleration) ** 2)
    return rows


def _point_rates(robot: Robot, point: ArmPointLimit, q: Any, dq: Any, ddq: Any) -> tuple[Any, Any]:
    """`mrts.limits.motion_limits.arm_point` in CasADi, at one sample."""
    place, velocity, acceleration = ca.DM(point.at_zero), ca.DM.zeros(3), ca.DM.zeros(3)
    for j in reversed(range(point.joints)):
        axis, K = ca.DM(robot.axes[j]), ca.skew(ca.DM(robot.axes[j]))
        if robot.joint_types[j] == "prismatic":
            place = place + axis * q[j]
            velocity, acceleration = velocity + axis * dq[j], acceleration + axis * ddq[j]
            continue
        R = ca.DM.eye(3) + ca.sin(q[j]) * K + (1 - ca.cos(q[j])) * (K @ K)
        arm, velocity, acceleration = R @ (place - robot.points[j]), R @ velocity, R @ acceleration
        around = K @ arm
        acceleration = acceleration + around * ddq[j] + K @ around * dq[j] ** 2 + 2 * (K @ velocity) * dq[j]
        velocity, place = velocity + around * dq[j], robot.points[j] + arm
    return velocity, acceleration


def _object_columns(motion: CoordinatedMotion) -> Array:
    """Position, rotation by columns, twist and acceleration of the object at N samples, Shape (24, N)."""
    carried = motion.object
    by_columns = carried.rotation.transpose(0, 2, 1).reshape(-1, 9)
    return np.concatenate([carried.position, by_columns, carried.twist, carried.acceleration], axis=1).T


def _arm_poses(geometry: Any, robots: int) -> list[tuple[Any, Any, Any, Any]]:
    """R and p of each base in the world and of each tip in the object, from `mrts.cell.cell.Cell.geometry`."""
    poses = []
    for index in range(robots):
        entries = geometry[GRAVITY_SIZE + index * ROBOT_SIZE :][:ROBOT_SIZE]
        R_base, R_tip = (ca.reshape(entries[start : start + 9], 3, 3).T for start in (0, 12))
        poses.append((R_base, entries[9:12], R_tip, entries[21:24]))
    return poses


def _grasp_equations(
    cell: Cell, functions: dict[str, Any], joints: tuple[Any, ...], carried: tuple[Any, ...], geometry: Any
) -> tuple[Any, Any, Any]:
    """What is zero where every tip is at its grasp, moves with it and accelerates with it, Shape (n w,) each.

    The error of a rotation is the sine of its angle times its axis, in world axes: smooth where the angle is small,
    and its derivative at zero is the identity.

    Args:
        cell: The cell.
        functions: CasADi's functions of the cell.
        joints: q, q' and q'' of all arms, Shape (m,) each.
        carried: Position, rotation, twist and acceleration of the object, world axes.
        geometry: Shape (g,).
    """
    q, dq, ddq = joints
    p, R, twist, change = carried
    rows = cell.wrench_rows
    at = functions["kinematics"](q=q, geometry=geometry)
    bias = functions["bias_acceleration"](q=q, dq=dq, geometry=geometry)["bias_acceleration"]
    v, w, a, dw = twist[:3], twist[3:], change[:3], change[3:]
    closure, velocity, acceleration = [], [], []
    arms = _arm_poses(geometry, len(cell.robots))
    for index, ((R_base, _, R_tip, p_tip), part) in enumerate(zip(arms, cell.joint_slices.values(), strict=True)):
        r = R @ p_tip
        turn = at["rotation"][:, 3 * index : 3 * index + 3] @ (R @ R_tip).T
        off = ca.vertcat(turn[2, 1] - turn[1, 2], turn[0, 2] - turn[2, 0], turn[1, 0] - turn[0, 1]) / 2
        closure.append(ca.vertcat(at["position"][:, index] - p - r, off)[rows])
        J = at["jacobian"][:, part.start : part.stop]
        linear = v + ca.cross(w, r), a + ca.cross(dw, r) + ca.cross(w, ca.cross(w, r))
        in_base = [
            ca.vertcat(R_base.T @ of_point, R_base.T @ turning)[rows]
            for of_point, turning in zip(linear, (w, dw), strict=True)
        ]
        velocity.append(J @ dq[part] - in_base[0])
        acceleration.append(J @ ddq[part] + bias[:, index] - in_base[1])
    return ca.vertcat(*closure), ca.vertcat(*velocity), ca.vertcat(*acceleration)


@dataclass(frozen=True)
class _Limits:
    """Rows lower <= M_τ τ + M_F F + M_H H + (S q' + s) c + (T q'' + e) c² + g <= upper at N samples, over their units.

    Attributes:
        rows: The rows as the cell keeps them, along the motion that the program starts from, but for those that the
            object's motion alone moves: they bound c² itself.
        log_c2_lower, log_c2_upper: What these leave of ln c².
        by_velocity: S, Shape (r, m).
        by_acceleration: T, Shape (r, m).
        speed: s, Shape (N, r).
        square: e, Shape (N, r).
        motors: What motors add to the torques along that motion; None where they are ideal.
        of_tip: Rows of contacts that turn with the tip, Shape (r,).
    """

    rows: LimitRows
    log_c2_lower: float
    log_c2_upper: float
    by_velocity: Array
    by_acceleration: Array
    speed: Array
    square: Array
    motors: MotorTerms | None
    of_tip: NDArray[np.bool_]

    @classmethod
    def of(cls, cell: Cell, motion: CoordinatedMotion) -> "_Limits":
        """The rows of a cell; how they depend on the joints' rates is read off at unit velocities and accelerations.

        Raises:
            InputError: If a limit is not linear in these, or depends on something else that a layout changes.
        """
        rows = limit_rows(cell, motion)
        still, units = np.zeros_like(motion.dq), np.eye(motion.dq.shape[1])

        def columns(dq: Array, ddq: Array) -> tuple[Array, Array]:
            at = limit_rows(cell, replace(motion, dq=dq, ddq=ddq))
            nothing = np.zeros((len(dq), len(at.names)))
            return nothing if at.speed is None else at.speed, nothing if at.square is None else at.square

        speed, square = columns(still, still)
        by_velocity = np.stack([(columns(still + unit, still)[0] - speed)[0] for unit in units], axis=1)
        by_acceleration = np.stack([(columns(still, still + unit)[1] - square)[0] for unit in units], axis=1)
        given = columns(motion.dq, motion.ddq)
        terms = motion.dq @ by_velocity.T + speed, motion.ddq @ by_acceleration.T + square
        for name, is_, linear in zip(("ṙ", "ṙ²"), given, terms, strict=True):
            wrong = np.max(np.abs(is_ - linear), axis=0) > SAME_ROW * np.max(np.abs(is_), initial=1.0)
            if np.any(wrong):
                raise InputError(
                    "limits",
                    f"its column of {name} is not linear in the joints' rates, so the best layout cannot be "
                    "searched with it: mrts sweep can, which solves each layout by itself.",
                    key=str(rows.names[int(np.argmax(wrong))]),
                )
        tips = {f"{robot.name}/{of.name}" for robot in cell.robots for of in robot.contacts if of.frame == "tip"}
        of_joints = rows.of_forces | np.any(by_velocity, axis=1) | np.any(by_acceleration, axis=1)
        own = ~of_joints & ~(np.any(speed, axis=0) & np.any(square, axis=0))
        least, most = _admitted(rows.only(own), speed[:, own], square[:, own])
        rows, kept = rows.only(~own), ~own
        return cls(
            rows=rows,
            log_c2_lower=float(np.log(least)) if least > 0 else -np.inf,
            log_c2_upper=float(np.log(most)),
            by_velocity=by_velocity[kept],
            by_acceleration=by_acceleration[kept],
            speed=speed[:, kept],
            square=square[:, kept],
            motors=motor_terms(cell, motion),
            of_tip=np.array([name.contact in tips for name in rows.names], dtype=bool),
        )

    @property
    def bounds(self) -> tuple[Array, Array]:
        """Lower and upper limits in units, less what dry friction may take at turning points, Shape (N, r) each."""
        rows = self.rows
        taken = None if self.motors is None else self.motors.margin(rows)
        margin = np.zeros((1, len(rows.names))) if taken is None else taken
        offset = 0.0 if rows.offset is None else rows.offset
        sides = ((1, rows.lower), (-1, rows.upper))
        lower, upper = ((limit + side * margin - offset) / rows.units for side, limit in sides)
        return np.broadcast_to(lower, self.speed.shape), np.broadcast_to(upper, self.speed.shape)

    @property
    def columns(self) -> Array:
        """What the equations are given of each sample: s, e and dry friction, Shape (2 r + m, N)."""
        dry = np.zeros((len(self.speed), self.by_velocity.shape[1])) if self.motors is None else self.motors.dry
        return np.concatenate([self.speed, self.square, dry], axis=1).T

    def values(self, torque: Any, wrench: Any, turned: tuple[Any, Any], speed: Any) -> Any:
        """What the rows are, in units, Shape (r,).

        Args:
            torque: τ, Shape (m,).
            wrench: F in base axes, Shape (n w,).
            turned: F in object axes and in axes of the tips.
            speed: (S q' + s) c + e c², Shape (r,).
        """
        rows = self.rows
        value = ca.DM(rows.torque_matrix) @ torque + ca.DM(rows.wrench_matrix) @ wrench + speed
        if rows.object_matrix is not None:
            for wrenches, there in zip(turned, (~self.of_tip, self.of_tip), strict=True):
                value += ca.sparsify(ca.DM(rows.object_matrix * there[:, None])) @ wrenches
        return value / rows.units


def _admitted(rows: LimitRows, speed: Array, square: Array) -> tuple[float, float]:
    """Least and largest c² that rows with one term of the speed, or none, admit at all samples."""
    offset, of_square = 0.0 if rows.offset is None else rows.offset, np.any(square, axis=0)
    term = np.where(of_square, square, speed)
    with np.errstate(divide="ignore", invalid="ignore"):
        ends = np.stack([(rows.lower - offset) / term, (rows.upper - offset) / term])
    ends[:, term == 0] = [[-np.inf], [np.inf]]
    low, high = np.maximum(np.min(ends, axis=0), 0.0), np.max(ends, axis=0)
    low, high = np.where(of_square, low, low**2), np.where(of_square, high, high * np.abs(high))
    return float(np.max(low, initial=0.0)), float(np.min(high, initial=np.inf))


def _turned_wrenches(cell: Cell, wrench: Any, R_object: Any, geometry: Any) -> tuple[Any, Any]:
    """All wrenches in object axes, and in axes that turn with the tips and are the object's at the cell's grasps."""
    axes, arms = triple_axes(cell.wrench_components), _arm_poses(geometry, len(cell.robots))
    in_object, in_tip = [], []
    for robot, (R_base, _, R_tip, _), part in zip(cell.robots, arms, cell.wrench_slices.values(), strict=True):
        turn = (R_object.T @ R_base)[axes, axes]
        back = (ca.DM(robot.T_object_tip.R) @ R_tip.T)[axes, axes]
        triples = [turn @ triple for triple in ca.vertsplit(wrench[part], 3)]
        in_object += triples
        in_tip += [back @ triple for triple in triples]
    return ca.vertcat(*in_object), ca.vertcat(*in_tip)


def _redundant_arms(cell: Cell) -> list[tuple[int, Robot, slice]]:
    arms = zip(cell.robots, cell.joint_slices.values(), strict=True)
    return [(index, robot, part) for index, (robot, part) in enumerate(arms) if is_redundant(cell, robot)]


def _redundant_joints(cell: Cell) -> list[int]:
    return [joint for _, _, part in _redundant_arms(cell) for joint in range(part.start, part.stop)]


def _start_equations(
    cell: Cell,
    functions: dict[str, Any],
    motion: CoordinatedMotion,
    geometry: Any,
    shared: tuple[Any, Any, Any],
    posture: Any,
) -> Any:
    """What holds redundant arms at the start of the motion, nearest to their postures; nothing for others."""
    (whole, reference, force), redundant = shared, _redundant_joints(cell)
    if not redundant:
        return ca.Function("start", [whole], [ca.SX(0, 1)])
    q = ca.SX(motion.q[0])
    q[redundant] = reference
    carried = tuple(getattr(motion.object, name)[0] for name in ("position", "rotation", "twist", "acceleration"))
    closure = _grasp_equations(cell, functions, (q, q, q), carried, geometry)[0]
    w = len(cell.wrench_components)
    closure = ca.vertcat(*(closure[w * index : w * index + w] for index, _, _ in _redundant_arms(cell)))
    lower, upper = (
        np.concatenate([getattr(robot, f"position_{side}") for robot in cell.robots]) for side in ("lower", "upper")
    )
    inside = ca.fmin(ca.fmax(posture, lower), upper)
    nearest = _preference(cell, functions, q, force, inside[redundant], geometry)
    return ca.Function("start", [whole], [ca.vertcat(closure, nearest)])


def _preference(cell: Cell, functions: dict[str, Any], q: Any, force: Any, reference: Any, geometry: Any) -> Any:
    """h(q) - h(reference) - JᵀF of all redundant arms: zero at the positions nearest to the reference, Shape (R,).

    Args:
        cell: The cell.
        functions: CasADi's functions of the cell.
        q: Joint positions of all arms, Shape (m,).
        force: Multipliers of the grasps of redundant arms, Shape (w,) each, stacked.
        reference: Joint positions of redundant arms to stay near, Shape (R,).
        geometry: Shape (g,).
    """
    J = functions["kinematics"](q=q, geometry=geometry)["jacobian"]
    rows: list[Any] = []
    w, start = len(cell.wrench_components), 0
    for _, robot, part in _redundant_arms(cell):
        there = reference[start : start + len(robot.joints)]
        multiplier = force[w * len(rows) : w * (len(rows) + 1)]
        rows.append(_stretched(robot, q[part]) - _stretched(robot, there) - J[:, part].T @ multiplier)
        start += len(robot.joints)
    return ca.vertcat(*rows)


def _along_path(value: Any, position: tuple[Any, ...], force: tuple[Any, ...]) -> Any:
    """The preference and its two derivatives along the path, Shape (3 R,)."""
    at, rate, change = (ca.vertcat(*pair) for pair in zip(position, force, strict=True))
    first = ca.jtimes(value, at, rate)
    second = ca.jtimes(first, ca.vertcat(at, rate), ca.vertcat(rate, change))
    return ca.vertcat(value, first, second)


def _multipliers(cell: Cell, q: Array, reference: Array) -> Array:
    """F of least squares at given positions of all arms, Shape (N, w a) for a redundant arms."""
    J = cell.functions("kinematics", len(q), {"q": q})["jacobian"]
    found = [np.zeros((len(q), 0))]
    for _, robot, part in _redundant_arms(cell):
        gradient = stretched(robot, q[:, part]) - stretched(robot, reference[None, part])
        found.append(apply(np.linalg.pinv(J[:, :, part]).transpose(0, 2, 1), gradient))
    return np.concatenate(found, axis=1)


def _stretched(robot: Robot, q: Any) -> Any:
    """h(q) of `mrts.following.null_space.stretched` in symbols, Shape (n_i,)."""
    zone = limit_zone(robot)
    values = []
    for joint, (low, high) in enumerate(zip(robot.position_lower, robot.position_upper, strict=True)):
        over = ca.fmax((q[joint] - high) / zone[joint] + 1, 0) if np.isfinite(high) else 0
        under = ca.fmax((low - q[joint]) / zone[joint] + 1, 0) if np.isfinite(low) else 0
        values.append(q[joint] + LIMIT_PUSH * (over**5 - under**5))
    return ca.vertcat(*values)


class _Watch(ca.Callback):
    def __init__(self, unknowns: int, rows: int, stop: Callable[[], bool]) -> None:
        ca.Callback.__init__(self)
        sizes = {"x": unknowns, "f": 1, "g": rows, "lam_x": unknowns, "lam_g": rows, "lam_p": 0}
        self.sizes = [sizes[ca.nlpsol_out(index)] for index in range(ca.nlpsol_n_out())]
        self.stop = stop
        self.construct("watch", {})

    def get_n_in(self) -> int:
        return len(self.sizes)

    def get_n_out(self) -> int:
        return 1

    def get_sparsity_in(self, index: int) -> Any:
        return ca.Sparsity.dense(self.sizes[index], 1 if self.sizes[index] else 0)

    def eval(self, _arguments: Any) -> list[int]:
        return [int(self.stop())]
