# SPDX-License-Identifier: MIT
"""The three ways to write torques and wrenches as affine functions of few unknowns.

Every formulation gives, for its unknowns x (c² last),

    τ = torque_map x + torque_offset        F = wrench_map x + wrench_offset        equality_map x = equality_rhs

so that each limit on a torque or a wrench is one two-sided linear row, whatever the formulation.
"""

from typing import Any

import casadi as ca
from mrts_codegen.cell_model import CellModel
from mrts_codegen.equations.arm_dynamics import block_diagonal
from mrts_codegen.equations.cooperative_terms import CooperativeTerms
from mrts_codegen.equations.geometry import Geometry

FORMULATION = ("torque_map", "torque_offset", "wrench_map", "wrench_offset", "equality_map", "equality_rhs")
"""Of the unknowns x (k of them, c² last): Shapes (m, k), (m,) [N m], (n w, k), (n w,) [N, N m], (e, k), (e,)."""


def formulation(*values: Any) -> dict[str, Any]:
    """Torques, wrenches and balance as affine maps of the unknowns, by name; `values` as in `FORMULATION`."""
    return {name: ca.densify(value) for name, value in zip(FORMULATION, values, strict=False)}


def wrench_form(terms: CooperativeTerms) -> dict[str, Any]:
    """Eq. (20): unknowns [F_1 … F_{n-1}, c²]; F_n = B_n⁻¹ (Q + c² P - Σ B_i F_i) leaves no equality.

    No inverse of a Jacobian, so it holds for redundant arms and at singularities.
    """
    w = terms.B[0].size1()
    free = len(terms.B) - 1
    last = terms.B_last_inverse @ ca.horzcat(*(-B for B in terms.B[:-1]), terms.P)
    wrench_map = ca.vertcat(ca.horzcat(ca.SX.eye(w * free), ca.SX.zeros(w * free, 1)), last)
    wrench_offset = ca.vertcat(ca.SX.zeros(w * free), terms.B_last_inverse @ terms.Q)
    return _of_wrenches(terms, wrench_map, wrench_offset)


def _of_wrenches(terms: CooperativeTerms, wrench_map: Any, wrench_offset: Any) -> dict[str, Any]:
    """The torques E c² + G + JᵀF of wrenches that are a map of unknowns, c² last."""
    J_T = block_diagonal([J.T for J in terms.J])
    torque_map = J_T @ wrench_map
    torque_map[:, -1] += terms.E
    return formulation(torque_map, J_T @ wrench_offset + terms.G, wrench_map, wrench_offset)


def torque_form(terms: CooperativeTerms) -> dict[str, Any]:
    """Eqs. (14), (21), (22), (23), (25), (27), (28): unknowns [τ, c²] on A_1 x = b_1.

    A_1 = [L, -P - L E], b_1 = L G + Q. The wrenches are J_D (τ - E c² - G), so A_2 = [J_D, -J_D E] and the offset
    -J_D G. Every Jacobian must be square and well-conditioned.
    """
    J_D = block_diagonal([ca.solve(J.T, ca.SX.eye(J.size1())) for J in terms.J])  # under (29): J_i^-T
    L = ca.densify(ca.horzcat(*terms.B) @ J_D)
    joints = terms.E.numel()
    return formulation(
        ca.horzcat(ca.SX.eye(joints), ca.SX.zeros(joints, 1)),
        ca.SX.zeros(joints),
        ca.horzcat(J_D, -J_D @ terms.E),
        -J_D @ terms.G,
        ca.horzcat(L, -terms.P - L @ terms.E),
        L @ terms.G + terms.Q,
    )


def fixed_distribution(
    cell: CellModel, geometry: Geometry, terms: CooperativeTerms, shares: Any, internal_wrench: Any
) -> dict[str, Any]:
    """Eqs. (36), (37): the only unknown is c²; every torque is a_i c² + b_i, every wrench likewise.

    Args:
        cell: The cell.
        geometry: Its geometry.
        terms: Terms of the sample.
        shares: α_i, Shape (n,); the caller keeps Σ α_i = 1.
        internal_wrench: Prescribed internal wrenches in base axes, Shape (n w,), with Σ B_i F_i = 0.
    """
    wrench_map = _shared_wrench(cell, geometry, terms, shares, terms.P)
    wrench_offset = _shared_wrench(cell, geometry, terms, shares, terms.Q) + internal_wrench
    return _of_wrenches(terms, wrench_map, wrench_offset)


def six_components(cell: CellModel, wrench: Any) -> Any:
    """A wrench with zeros where the cell has no components, Shape (6,)."""
    full = ca.SX.zeros(6)
    full[list(cell.components)] = wrench
    return full


def _shared_wrench(cell: CellModel, geometry: Geometry, terms: CooperativeTerms, shares: Any, total: Any) -> Any:
    """Eq. (35): arm i gives force α_i f and moment α_i (M - Σ_j r_j × α_j f), extended to any grasp.

    With α_i = 1/n and Σ r_j = 0 this is (35) as printed. `total` is [f; M] in world axes, Shape (w,).
    """
    rows, full = list(cell.components), six_components(cell, total)
    f, M = full[:3], full[3:]
    for index, offset in enumerate(terms.offsets):
        M = M - ca.cross(offset, shares[index] * f)
    wrenches = []
    for index, base in enumerate(geometry.bases):
        R_base_world = ca.SX(base.R.T)
        wrench = ca.vertcat(R_base_world @ f, R_base_world @ M) * shares[index]
        wrenches.append(wrench[rows])
    return ca.vertcat(*wrenches)
