# SPDX-License-Identifier: MIT
"""The registry of generated functions: what each is called, what goes in and what comes out.

A new function is one builder and one line in `BUILDERS`.
"""

from collections.abc import Callable, Iterable
from typing import Any

import casadi as ca
from mrts_codegen.cell_model import CellModel
from mrts_codegen.equations.arm_dynamics import (
    bias_acceleration,
    block_diagonal,
    coriolis_torque,
    forward_kinematics,
    mass_matrix,
)
from mrts_codegen.equations.formulations import (
    fixed_distribution,
    grasp_maps,
    played_torques,
    torque_form,
    wrench_form,
)
from mrts_codegen.equations.sample import MOVING, Sample, sample_of

from mrts.base.manifest import FOR_REDUNDANT_ARMS, GEOMETRY

Named = dict[str, Any]


def _kinematics(sample: Sample) -> Named:
    rotations, positions = [], []
    for model, base, q in zip(sample.models, sample.bases, sample.arms("q"), strict=True):
        R_base_tip, p_base_tip = forward_kinematics(model, q)[-1]
        positions.append(base.p + base.R @ p_base_tip)
        rotations.append(base.R @ R_base_tip)
    outputs = {"position": positions, "rotation": rotations, "jacobian": sample.J}
    return {name: ca.horzcat(*parts) for name, parts in outputs.items()}


def _bias_acceleration(sample: Sample) -> Named:
    rows, arms = sample.cell.record.wrench_rows, zip(sample.models, sample.arms("q"), sample.arms("dq"), strict=True)
    return {"bias_acceleration": ca.horzcat(*(bias_acceleration(*arm)[rows] for arm in arms))}


def _torques_of_wrenches(sample: Sample) -> list[Any]:
    """JᵀF of every arm."""
    parts = ca.vertsplit(sample.inputs["wrench"], len(sample.cell.record.wrench_rows))
    return [J.T @ part for J, part in zip(sample.J, parts, strict=True)]


def _geometric_stiffness(sample: Sample) -> Named:
    """∂(JᵀF)/∂q of every arm."""
    arms = zip(_torques_of_wrenches(sample), sample.arms("q"), strict=True)
    return {"geometric_stiffness": block_diagonal([ca.jacobian(torque, q) for torque, q in arms])}


def _geometric_stiffness_rate(sample: Sample) -> Named:
    """The second derivative of JᵀF along q' at constant F and q'."""
    along = sample.inputs["q"], sample.inputs["dq"]
    rate = ca.jtimes(ca.jtimes(ca.vertcat(*_torques_of_wrenches(sample)), *along), *along)
    return {"geometric_stiffness_rate": rate}


def _dynamics(sample: Sample) -> Named:
    arms = list(zip(sample.models, sample.arms("q"), sample.arms("dq"), strict=True))
    return {
        "mass_matrix": block_diagonal([mass_matrix(model, q) for model, q, _ in arms]),
        "coriolis_torque": ca.vertcat(*(coriolis_torque(*arm) for arm in arms)),
        "gravity_torque": sample.terms_of_arms[2],
    }


def _terms(sample: Sample) -> Named:
    E, A, G = sample.terms_of_arms
    P, S, Q = sample.terms_of_object
    J, B = ca.horzcat(*sample.J), ca.horzcat(*grasp_maps(sample))
    return {"E": E, "A": A, "G": G, "J": J, "B": B, "P": P, "S": S, "Q": Q}


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
