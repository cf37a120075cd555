# SPDX-License-Identifier: MIT
"""The contact wrenches with which a motion begins, ends and stops on its way: those of torques that hold still."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from mrts.base.arrays import Array
from mrts.cell.cell import Cell
from mrts.program.path_program import joint_names
from mrts.program.sample_problem import SampleProblem
from mrts.program.solvers import DEFAULT_SOLVER
from mrts.program.torque_distribution import distribute_torques

HOLDS = 1e-4
"""Share of the largest torque by which given torques may miss those that hold still: digits of a file."""

ON_LIMIT = 1e-6
"""Share of a limit by which they may pass it: the same."""

GivenTorques = tuple[Array | None, Array | None]
"""Torques that hold still at the start and at the end of a motion, each Shape (m,), or None [N m]."""


def given_wrenches(problems: Sequence[SampleProblem], given: GivenTorques, end: int) -> Array | None:
    """The free wrenches of given torques, of all loads; None where none are given.

    Args:
        problems: Rows of [F, u, x] at the nodes of a path, one a load.
        given: The torques.
        end: 0 for the start of the path, 1 for its end.
    """
    torque = given[end]
    if torque is None:
        return None
    return np.concatenate([_nearest(problem, torque, -end)[0] for problem in problems])


def unheld(cell: Cell, problem: SampleProblem, given: GivenTorques, end: int) -> str | None:
    """Why given torques do not hold the object still within the limits; None if they do, or if there are none.

    Args:
        cell: The cell.
        problem: Rows of [F, u, x] at the nodes of a path.
        given: The torques.
        end: 0 for the start of the path, 1 for its end.
    """
    torque = given[end]
    if torque is None:
        return None
    where, place = ("start", "end")[end], -end
    free, missed = _nearest(problem, torque, place)
    dry = np.concatenate([robot.motors.coulomb for robot in cell.robots])  # it may hold as much of it
    beyond = np.abs(missed) - 2 * dry
    worst = int(np.argmax(beyond))
    unit = [unit for robot in cell.robots for unit in robot.torque_units][worst]
    if beyond[worst] > HOLDS * np.max(np.abs(torque)):
        return (
            f"the torques given for the {where} do not hold the cell still: {joint_names(cell)[worst]} misses what "
            f"balances the others by {abs(missed[worst]):.4g} {unit}. "
            "Take those of a plan that ends there, or give none."
        )
    values = problem.A[place, :, :-2] @ free
    over, under = values - problem.upper[place], problem.lower[place] - values
    row = int(np.argmax(np.maximum(over, under)))
    if max(over[row], under[row]) > ON_LIMIT:
        limit = problem.active_row(row, upper=bool(over[row] > under[row]))
        return f"the torques given for the {where} hold the cell still, but beyond a limit: {limit}."
    return None


def _nearest(problem: SampleProblem, torque: Array, place: int) -> tuple[Array, Array]:
    """The free wrenches that come nearest to torques at rest, and by what they miss each of them."""
    columns, offset = problem.torque_map[place, :, :-2], problem.torque_offset[place]
    free = np.linalg.lstsq(columns, torque - offset, rcond=None)[0]
    return free, columns @ free + offset - torque


def stopped_wrenches(problems: Sequence[SampleProblem], weights: Array) -> Array:
    """The free wrenches of the least torques that hold still at the last node, of all loads.

    Args:
        problems: Rows of [F, u, x] at the nodes of a path that comes to rest, one a load.
        weights: W, Shape (m, m).

    Raises:
        SolverError: If no solver answers.
    """
    found = []
    for problem in problems:
        last = problem.at(np.array([problem.samples - 1]))
        still = replace(
            last,
            speed=None,
            torque_speed=None,
            **{name: np.delete(getattr(last, name), -2, axis=2) for name in ("A", "torque_map", "wrench_map")},
        )
        unknowns, _ = distribute_torques(still, 0.0, weights, DEFAULT_SOLVER)
        found.append(unknowns[0, :-1])
    return np.concatenate(found)
