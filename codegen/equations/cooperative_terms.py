# SPDX-License-Identifier: MIT
"""All terms of the closed chain at one sample of a given motion."""

from dataclasses import dataclass
from itertools import accumulate
from typing import Any

import casadi as ca
from mrts_codegen.cell_model import CellModel
from mrts_codegen.equations.arm_dynamics import frame_jacobian, scaled_arm_terms
from mrts_codegen.equations.geometry import Geometry
from mrts_codegen.equations.object_dynamics import contact_offset, grasp_map, grasp_map_inverse, object_terms

from mrts.base.manifest import LOAD_ENTRIES


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


def sample_symbols(cell: CellModel) -> dict[str, Any]:
    """Inputs of every function of a moving sample, by name.

    Joint positions, q' and q'' of all arms in order, each Shape (m,); of the object its rotation, Shape (3, 3),
    [p'; φ'] and [p''; φ''] in world axes, each Shape (6,); the load vector, `LOAD_ENTRIES`.
    """
    m = sum(len(model.joints) for model in cell.models)
    shapes = {"q": (m,), "dq": (m,), "ddq": (m,), "object_rotation": (3, 3), "object_twist": (6,)}
    shapes |= {"object_acceleration": (6,), "load": (len(LOAD_ENTRIES),)}
    return {name: ca.SX.sym(name, *shape) for name, shape in shapes.items()}


def split_joints(cell: CellModel, stacked: Any) -> list[Any]:
    """Cut a vector over all joints, Shape (m,), into one piece an arm."""
    ends = accumulate((len(model.joints) for model in cell.models), initial=0)
    return list(ca.vertsplit(stacked, list(ends)))


def cooperative_terms(cell: CellModel, symbols: dict[str, Any], geometry: Geometry) -> CooperativeTerms:
    """Stack the terms of all arms and the object (definitions above (22)); no inverse of a Jacobian."""
    rows, R, G = list(cell.components), symbols["object_rotation"], geometry
    joints = [split_joints(cell, symbols[name]) for name in ("q", "dq", "ddq")]
    arms = [scaled_arm_terms(*of_arm) for of_arm in zip(G.models, *joints, G.down, strict=True)]
    offsets = [contact_offset(R, grasp.p) for grasp in G.grasps]
    P, S, Q = object_terms(
        symbols["load"], R, symbols["object_twist"], symbols["object_acceleration"], G.gravity, cell.components
    )
    E, A, gravity_torque = (ca.densify(ca.vertcat(*of_arms)) for of_arms in zip(*arms, strict=True))
    return CooperativeTerms(
        E=E,
        A=A,
        G=gravity_torque,
        J=[ca.densify(frame_jacobian(model, q)[rows, :]) for model, q in zip(G.models, joints[0], strict=True)],
        B=[grasp_map(offset, base.R, cell.components) for offset, base in zip(offsets, G.bases, strict=True)],
        B_last_inverse=grasp_map_inverse(offsets[-1], G.bases[-1].R, cell.components),
        offsets=offsets,
        P=P,
        S=S,
        Q=Q,
    )
