# SPDX-License-Identifier: MIT
"""The generated functions: what each is called, what goes in and what comes out.

A new function is one builder and one line in `BUILDERS`. Among them are torques and wrenches as affine functions of few
unknowns, in three formulations; each gives, for its unknowns x (k of them, c² last),

    τ = torque_map x + torque_offset        F = wrench_map x + wrench_offset        equality_map x = equality_rhs

with Shapes (m, k), (m,) [N m], (n w, k), (n w,) [N, N m], (e, k), (e,), so that each limit on a torque or a wrench is
one two-sided linear row, whatever the formulation.
"""

from collections.abc import Callable, Iterable
from typing import Any

import casadi as ca
from mrts_codegen.cell_model import CellModel
from mrts_codegen.equations.dynamics import (
    angular_balance,
    bias_acceleration,
    chain_motion,
    coriolis_torque,
    forward_kinematics,
    grasp_map,
    grasp_map_inverse,
    linear_balance,
    load_inertia,
    mass_matrix,
    spin,
    transmitted_torques,
)
from mrts_codegen.equations.sample import MOVING, Sample, sample_of

from mrts.base.manifest import FOR_REDUNDANT_ARMS, GEOMETRY

Named = dict[str, Any]


def _kinematics(sample: Sample) -> Named:
    rotations, positions = [], []
    for model, base, steps in zip(sample.models, sample.bases, sample.steps, strict=True):
        R_base_tip, p_base_tip = forward_kinematics(model, steps)[-1]
        positions.append(base.p + base.R @ p_base_tip)
        rotations.append(base.R @ R_base_tip)
    outputs = {"position": positions, "rotation": rotations, "jacobian": sample.J}
    return {name: ca.horzcat(*parts) for name, parts in outputs.items()}


def _bias_acceleration(sample: Sample) -> Named:
    rows, arms = sample.cell.record.wrench_rows, zip(sample.models, sample.steps, sample.arms("dq"), strict=True)
    return {"bias_acceleration": ca.horzcat(*(bias_acceleration(*arm)[rows] for arm in arms))}


def _torques_of_wrenches(sample: Sample) -> list[Any]:
    """JᵀF of every arm."""
    parts = ca.vertsplit(sample.inputs["wrench"], len(sample.cell.record.wrench_rows))
    return [J.T @ part for J, part in zip(sample.J, parts, strict=True)]


def _geometric_stiffness(sample: Sample) -> Named:
    """∂(JᵀF)/∂q of every arm."""
    arms = zip(_torques_of_wrenches(sample), sample.arms("q"), strict=True)
    return {"geometric_stiffness": ca.diagcat(*(ca.jacobian(torque, q) for torque, q in arms))}


def _geometric_stiffness_rate(sample: Sample) -> Named:
    """The second derivative of JᵀF along q' at constant F and q'."""
    along = sample.inputs["q"], sample.inputs["dq"]
    rate = ca.jtimes(ca.jtimes(ca.vertcat(*_torques_of_wrenches(sample)), *along), *along)
    return {"geometric_stiffness_rate": rate}


def _dynamics(sample: Sample) -> Named:
    arms = list(zip(sample.models, sample.steps, sample.arms("dq"), strict=True))
    return {
        "mass_matrix": ca.diagcat(*(mass_matrix(model, steps) for model, steps, _ in arms)),
        "coriolis_torque": ca.vertcat(*(coriolis_torque(*arm) for arm in arms)),
        "gravity_torque": sample.terms_of_arms[2],
    }


def _terms(sample: Sample) -> Named:
    E, A, G = sample.terms_of_arms
    P, S, Q = sample.terms_of_object
    J, B = ca.horzcat(*sample.J), ca.horzcat(*grasp_maps(sample))
    return {"E": E, "A": A, "G": G, "J": J, "B": B, "P": P, "S": S, "Q": Q}


def grasp_maps(sample: Sample) -> list[Any]:
    """B_i of each arm, each Shape (w, w)."""
    arms = zip(sample.offsets, sample.bases, strict=True)
    return [grasp_map(offset, base.R, sample.cell.record.wrench_rows) for offset, base in arms]


def wrench_form(sample: Sample) -> Named:
    """Eq. (20): unknowns [F_1 … F_{n-1}, c²]; F_n = B_n⁻¹ (Q + c² P - Σ B_i F_i) leaves no equality.

    No inverse of a Jacobian, so it holds for redundant arms and at singularities.
    """
    (P, _, Q), B = sample.terms_of_object, grasp_maps(sample)
    B_last_inverse = grasp_map_inverse(sample.offsets[-1], sample.bases[-1].R, sample.cell.record.wrench_rows)
    others = B[0].size1() * (len(B) - 1)
    last = B_last_inverse @ ca.horzcat(*(-B_i for B_i in B[:-1]), P)
    wrench_map = ca.vertcat(ca.horzcat(ca.SX.eye(others), ca.SX.zeros(others, 1)), last)
    return _of_wrenches(sample, wrench_map, ca.vertcat(ca.SX.zeros(others), B_last_inverse @ Q))


def _of_wrenches(sample: Sample, wrench_map: Any, wrench_offset: Any) -> Named:
    """The torques E c² + G + JᵀF of wrenches that are a map of unknowns, c² last."""
    (E, _, G), J_T = sample.terms_of_arms, ca.diagcat(*(J.T for J in sample.J))
    torque_map = J_T @ wrench_map
    torque_map[:, -1] += E
    torques = {"torque_map": torque_map, "torque_offset": J_T @ wrench_offset + G}
    return torques | {"wrench_map": wrench_map, "wrench_offset": wrench_offset}


def torque_form(sample: Sample) -> Named:
    """Eqs. (14), (21), (22), (23), (25), (27), (28): unknowns [τ, c²] on A_1 x = b_1.

    A_1 = [L, -P - L E], b_1 = L G + Q. The wrenches are J_D (τ - E c² - G), so A_2 = [J_D, -J_D E] and the offset
    -J_D G. Every Jacobian must be square and well-conditioned.
    """
    (E, _, G), (P, _, Q) = sample.terms_of_arms, sample.terms_of_object
    J_D = ca.diagcat(*(ca.solve(J.T, ca.SX.eye(J.size1())) for J in sample.J))  # under (29): J_i^-T
    L = ca.densify(ca.horzcat(*grasp_maps(sample)) @ J_D)
    joints = E.numel()
    return {
        "torque_map": ca.horzcat(ca.SX.eye(joints), ca.SX.zeros(joints, 1)),
        "torque_offset": ca.SX.zeros(joints),
        "wrench_map": ca.horzcat(J_D, -J_D @ E),
        "wrench_offset": -J_D @ G,
        "equality_map": ca.horzcat(L, -P - L @ E),
        "equality_rhs": L @ G + Q,
    }


def fixed_distribution(sample: Sample) -> Named:
    """Eqs. (36), (37): the only unknown is c²; every torque is a_i c² + b_i, every wrench likewise.

    The caller keeps Σ α_i = 1 of the shares, and Σ B_i F_i = 0 of the internal wrenches, base axes.
    """
    P, _, Q = sample.terms_of_object
    return _of_wrenches(sample, _shared_wrench(sample, P), _shared_wrench(sample, Q) + sample.inputs["internal_wrench"])


def _six_components(sample: Sample, wrench: Any) -> tuple[Any, Any]:
    """Force and moment of a wrench, with zeros where the cell has no components, each Shape (3,)."""
    full = ca.SX.zeros(6)
    full[sample.cell.record.wrench_rows] = wrench
    return full[:3], full[3:]


def _shared_wrench(sample: Sample, total: Any) -> Any:
    """Eq. (35): arm i gives force α_i f and moment α_i (M - Σ_j r_j × α_j f), extended to any grasp.

    With α_i = 1/n and Σ r_j = 0 this is (35) as printed. `total` is [f; M] in world axes, Shape (w,).
    """
    shares, (f, M) = sample.inputs["shares"], _six_components(sample, total)
    for index, offset in enumerate(sample.offsets):
        M = M - ca.cross(offset, shares[index] * f)
    wrenches = [ca.vertcat(base.R.T @ f, base.R.T @ M) * shares[index] for index, base in enumerate(sample.bases)]
    return ca.vertcat(*(wrench[sample.cell.record.wrench_rows] for wrench in wrenches))


def played_torques(sample: Sample) -> Named:
    """Torques D q̈ + C + G + JᵀF of joints that move as they do, for wrenches that carry the object nearly.

    The object moves as the first arm's tip does. What the wrenches, given in its axes, lack of what it takes is put on
    as (35) does, for any grasp: equal forces, and equal moments of what these forces leave.

    Returns:
        "torque", Shape (m,) [N m or N], and "wrench" in the axes of the bases, Shape (n w,) [N, N m].
    """
    grasps, count, rows = sample.grasps, len(sample.models), sample.cell.record.wrench_rows
    rates = sample.arms("dq"), sample.arms("ddq"), [-down for down in sample.down]
    moves = zip(sample.models, sample.steps, *rates, strict=True)
    motions = [chain_motion(*of_arm) for of_arm in moves]
    given = [_six_components(sample, part) for part in ca.vertsplit(sample.inputs["object_wrench"], len(rows))]
    lacking_force, lacking_moment = _needed(sample, motions[0])
    for grasp, (force, moment) in zip(grasps, given, strict=True):
        lacking_force -= force
        lacking_moment -= moment + ca.cross(grasp.p, force)
    lacking_moment -= sum((ca.cross(grasp.p, lacking_force) for grasp in grasps), ca.SX.zeros(3)) / count
    torques, wrenches = [], []
    for model, grasp, motion, (force, moment) in zip(sample.models, grasps, motions, given, strict=True):
        turn = grasp.R.T  # from the object to the tip
        f, n = turn @ (force + lacking_force / count), turn @ (moment + lacking_moment / count)
        torques += transmitted_torques(model, motion, f, n)
        both = ca.horzcat(f, n)
        for R in (*(joint[0] for joint in motion), ca.SX(model.tip.R))[::-1]:
            both = R @ both
        wrenches.append(ca.vec(both)[rows])
    return {"torque": ca.vertcat(*torques), "wrench": ca.vertcat(*wrenches)}


def _needed(sample: Sample, motion: list[Any]) -> tuple[Any, Any]:
    """What the object takes about its origin, in its axes, as the tip of the first arm moves it."""
    tip, grasp, load = sample.models[0].tip, sample.grasps[0], sample.inputs["load"]
    R, p = ca.SX(tip.R) @ grasp.R.T, ca.SX(tip.p)
    origin = p - R @ grasp.p  # of the object, in the frame of the last joint
    *_, w, dw, a = motion[-1]
    w, dw, a = R.T @ w, R.T @ dw, R.T @ (a + spin(w, dw) @ origin)
    h = load[1:4]
    return linear_balance(load[0], h, a, w, dw), angular_balance(load_inertia(load), h, a, w, dw)


BUILDERS: dict[str, tuple[Callable[[Sample], Named], tuple[str, ...]]] = {
    "kinematics": (_kinematics, ("q",)),
    "bias_acceleration": (_bias_acceleration, ("q", "dq")),
    "geometric_stiffness": (_geometric_stiffness, ("q", "wrench")),
    "geometric_stiffness_rate": (_geometric_stiffness_rate, ("q", "dq", "wrench")),
    "dynamics": (_dynamics, ("q", "dq")),
    "terms": (_terms, MOVING),
    "wrench_form": (wrench_form, MOVING),
    "torque_form": (torque_form, MOVING),
    "fixed_distribution": (fixed_distribution, (*MOVING, "shares", "internal_wrench")),
    "played_torques": (played_torques, ("q", "dq", "ddq", "load", "object_wrench")),
}
"""Of each function by its short name what gives its outputs, and its inputs."""


def _is_allowed(cell: CellModel, name: str) -> bool:
    """Whether a cell has a function: some are for arms with more joints than a wrench has components, or as many."""
    joints, size = [len(model.joints) for model in cell.models], len(cell.record.wrench_rows)
    if name in FOR_REDUNDANT_ARMS:
        return max(joints) > size
    return name != "torque_form" or {*joints} == {size}


def build_functions(
    cell: CellModel, stem: str, *, bake: bool = False, names: Iterable[str] = BUILDERS
) -> dict[str, ca.Function]:
    """Functions of a cell as named CasADi Functions with named dense inputs and outputs.

    Common subexpressions are merged, which saves 15 to 40 % of the instructions. `bake` folds the cell's geometry in;
    else it is the last input of each.

    Returns:
        Short name to Function; the Function itself is called `<stem>_<short name>`.
    """
    sample, functions = sample_of(cell, bake=bake), {}
    for name in names:
        if not _is_allowed(cell, name):
            continue
        builder, given = BUILDERS[name]
        outputs, inputs = builder(sample), [*given, *(() if bake else (GEOMETRY,))]
        functions[name] = ca.Function(
            f"{stem}_{name}",
            [sample.inputs[one] for one in inputs],
            ca.cse([ca.densify(output) for output in outputs.values()]),
            inputs,
            list(outputs),
        )
    return functions
