# SPDX-License-Identifier: MIT
"""All terms of the closed chain at one sample of a given motion."""

from dataclasses import dataclass
from typing import Any

import casadi as ca
from mrts_codegen.cell_model import CellModel
from mrts_codegen.equations.geometry import Geometry
from mrts_codegen.equations.grasp_map import contact_offset, grasp_map, grasp_map_inverse
from mrts_codegen.equations.inverse_dynamics import scaled_arm_terms
from mrts_codegen.equations.kinematics import frame_jacobian
from mrts_codegen.equations.object_dynamics import object_terms
from mrts_codegen.equations.spatial_algebra import block_diagonal

from mrts.base.manifest import LOAD_ENTRIES


@dataclass(frozen=True)
class SampleSymbols:
    """Inputs of every function of a sample.

    Attributes:
        q: Joint positions of all arms in order, Shape (m,) [rad or m].
        dq: Their q', Shape (m,).
        ddq: Their q'', Shape (m,).
        R_world_object: Rotation of the object, Shape (3, 3).
        twist: Its [p'; φ'] in world axes, Shape (6,) [m/s, rad/s].
        acceleration: Its [p''; φ''] in world axes, Shape (6,) [m/s², rad/s²].
        load: Load vector, `LOAD_ENTRIES`.
    """

    q: Any
    dq: Any
    ddq: Any
    R_world_object: Any
    twist: Any
    acceleration: Any
    load: Any


@dataclass(frozen=True)
class CooperativeTerms:
    """Terms of the cell; m joints in all, n arms, w wrench components.

    Attributes:
        E: Inertial torques, Shape (m,) [N m].
        A: Torques per time-warp acceleration, Shape (m,) [N m s²].
        G: Gravity torques, Shape (m,) [N m].
        J: Jacobian of each arm in its base axes, each Shape (w, n_i).
        B: Grasp map of each arm, each Shape (w, w).
        B_last_inverse: Inverse of the last arm's grasp map, Shape (w, w).
        offsets: Contact point minus com of each arm in world axes, each Shape (3,) [m].
        P: Inertial wrench of the object, Shape (w,) [N, N m].
        S: Its wrench per time-warp acceleration, Shape (w,) [N s², N m s²].
        Q: Wrench that carries its weight, Shape (w,) [N, N m].
    """

    E: Any
    A: Any
    G: Any
    J: list[Any]
    B: list[Any]
    B_last_inverse: Any
    offsets: list[Any]
    P: Any
    S: Any
    Q: Any


def sample_symbols(cell: CellModel) -> SampleSymbols:
    """Fresh symbols for one sample of a cell."""
    count = sum(len(model.joints) for model in cell.models)
    return SampleSymbols(
        q=ca.SX.sym("q", count),
        dq=ca.SX.sym("dq", count),
        ddq=ca.SX.sym("ddq", count),
        R_world_object=ca.SX.sym("R", 3, 3),
        twist=ca.SX.sym("twist", 6),
        acceleration=ca.SX.sym("acceleration", 6),
        load=ca.SX.sym("load", len(LOAD_ENTRIES)),
    )


def split_joints(cell: CellModel, stacked: Any) -> list[Any]:
    """Cut a vector over all joints, Shape (m,), into one piece an arm."""
    pieces, start = [], 0
    for model in cell.models:
        stop = start + len(model.joints)
        pieces.append(stacked[start:stop])
        start = stop
    return pieces


def cooperative_terms(cell: CellModel, symbols: SampleSymbols, geometry: Geometry) -> CooperativeTerms:
    """Stack the terms of all arms and the object (definitions above (22)); no inverse of a Jacobian.

    Args:
        cell: The cell.
        symbols: The sample.
        geometry: Its geometry.
    """
    rows = list(cell.components)
    arms, J, B, offsets = [], [], [], []
    for model, down, base, grasp, q, dq, ddq in zip(
        geometry.models,
        geometry.down,
        geometry.bases,
        geometry.grasps,
        split_joints(cell, symbols.q),
        split_joints(cell, symbols.dq),
        split_joints(cell, symbols.ddq),
        strict=True,
    ):
        arms.append(scaled_arm_terms(model, q, dq, ddq, down))
        J.append(ca.densify(frame_jacobian(model, q)[rows, :]))
        offsets.append(contact_offset(symbols.R_world_object, grasp.p))
        B.append(grasp_map(offsets[-1], base.R, cell.components))
    carried = object_terms(
        symbols.load,
        symbols.R_world_object,
        symbols.twist,
        symbols.acceleration,
        geometry.gravity,
        cell.components,
    )
    return CooperativeTerms(
        E=ca.densify(ca.vertcat(*(arm.E for arm in arms))),
        A=ca.densify(ca.vertcat(*(arm.A for arm in arms))),
        G=ca.densify(ca.vertcat(*(arm.G for arm in arms))),
        J=J,
        B=B,
        B_last_inverse=grasp_map_inverse(offsets[-1], geometry.bases[-1].R, cell.components),
        offsets=offsets,
        P=carried.P,
        S=carried.S,
        Q=carried.Q,
    )


def inverse_jacobian_transpose(terms: CooperativeTerms) -> Any:
    """J_D (under (29)): block-diagonal J_i^-T, Shape (n w, m); every J_i must be square."""
    return block_diagonal([ca.solve(J.T, ca.SX.eye(J.size1())) for J in terms.J])


def load_map(terms: CooperativeTerms, J_D: Any) -> Any:
    """L (above (22)): [B_1 J_1^-T … B_n J_n^-T], Shape (w, m)."""
    return ca.densify(ca.horzcat(*terms.B) @ J_D)
