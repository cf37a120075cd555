# SPDX-License-Identifier: MIT
"""Torques of one moment of a motion whose joints move as they do, for wrenches that carry the object nearly."""

from typing import Any

import casadi as ca
from mrts_codegen.cell_model import CellModel
from mrts_codegen.equations.arm_dynamics import ChainMotion, chain_motion, spin, transmitted_torques
from mrts_codegen.equations.formulations import six_components
from mrts_codegen.equations.geometry import Geometry
from mrts_codegen.equations.object_dynamics import angular_balance, linear_balance, load_inertia


def played_torques(
    cell: CellModel, geometry: Geometry, q: list[Any], dq: list[Any], ddq: list[Any], load: Any, shares: Any
) -> tuple[Any, Any]:
    """Torques D q̈ + C + G + JᵀF, what `shares` lack of the wrench that the object takes put on all arms alike.

    The object moves as the first arm's tip does. What is lacking is put on as (35) does, for any grasp: equal forces,
    and equal moments of what these forces leave.

    Args:
        cell: The cell, n arms of m joints together.
        geometry: Numbers or symbols.
        q: Joint positions, an entry an arm [rad or m].
        dq: q̇, likewise [rad/s or m/s].
        ddq: q̈, likewise [rad/s² or m/s²].
        load: Load vector, Shape (10,).
        shares: Contact wrenches in the axes of the object, Shape (n w,) [N, N m].

    Returns:
        τ, Shape (m,) [N m or N], and F in the axes of the bases, Shape (n w,) [N, N m].
    """
    moves = zip(geometry.models, q, dq, ddq, geometry.down, strict=True)
    motions = [chain_motion(model, q_i, dq_i, ddq_i, -ca.SX(down)) for model, q_i, dq_i, ddq_i, down in moves]
    parts = [six_components(cell, part) for part in ca.vertsplit(shares, len(cell.components))]
    forces, moments = [part[:3] for part in parts], [part[3:] for part in parts]
    lacking_force, lacking_moment = _needed(geometry, motions[0], load)
    count = len(forces)
    for grasp, force, moment in zip(geometry.grasps, forces, moments, strict=True):
        lacking_force -= force
        lacking_moment -= moment + ca.cross(ca.SX(grasp.p), force)
    lacking_moment -= (
        sum((ca.cross(ca.SX(grasp.p), lacking_force) for grasp in geometry.grasps), ca.SX.zeros(3)) / count
    )
    rows, torques, wrenches = list(cell.components), [], []
    arms = zip(geometry.models, geometry.grasps, motions, forces, moments, strict=True)
    for model, grasp, motion, force, moment in arms:
        turn = ca.SX(grasp.R).T  # from the object to the tip
        f, n = turn @ (force + lacking_force / count), turn @ (moment + lacking_moment / count)
        torques += transmitted_torques(model, motion, f, n)
        both = ca.horzcat(f, n)
        for R in (*(joint[0] for joint in motion), ca.SX(model.tip.R))[::-1]:
            both = R @ both
        wrenches.append(ca.vec(both)[rows])
    return ca.vertcat(*torques), ca.vertcat(*wrenches)


def _needed(geometry: Geometry, motion: ChainMotion, load: Any) -> tuple[Any, Any]:
    """What the object takes about its origin, in its axes, as the tip of the first arm moves it."""
    tip, grasp = geometry.models[0].tip, geometry.grasps[0]
    R, p = ca.SX(tip.R) @ ca.SX(grasp.R).T, ca.SX(tip.p)
    origin = p - R @ ca.SX(grasp.p)  # of the object, in the frame of the last joint
    *_, w, dw, a = motion[-1]
    w, dw, a = R.T @ w, R.T @ dw, R.T @ (a + spin(w, dw) @ origin)
    h = load[1:4]
    return linear_balance(load[0], h, a, w, dw), angular_balance(load_inertia(load), h, a, w, dw)
