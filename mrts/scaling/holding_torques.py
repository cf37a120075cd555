# SPDX-License-Identifier: MIT
"""Torques and wrenches that hold the object still where a motion starts from rest and comes to rest."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property, partial
from typing import Self

import numpy as np
from numpy.typing import NDArray

from mrts.base.arrays import Array
from mrts.base.notebook.in_notebooks import InNotebooks
from mrts.base.remark import Remark
from mrts.cell.cell import Cell
from mrts.following.coordinated_motion import CoordinatedMotion
from mrts.motion.rows_at_rest import pushing_ends
from mrts.program.formulation import DistributionName, FormulationName
from mrts.program.load_sharing import LoadSharing
from mrts.program.motion_widening import motion_widening
from mrts.program.reserve import TORQUES
from mrts.program.sample_problem import build_sample_problem
from mrts.program.sample_ranges import SampleRanges
from mrts.program.torque_distribution import TORQUE_WIDENING
from mrts.program.widening import widening_at

WHAT = "whether the cell can hold still"
"""What is found, for messages."""


@dataclass(frozen=True)
class Holding(InNotebooks):
    """What a controller needs before the first and after the last sample, at both ends of a motion.

    Attributes:
        ends: Whether there are such torques at the start, and at the end: only where the motion is at rest there but
            accelerates, and the limits let the cell hold still.
        find: Finds torques, Shape (2, m), and wrenches, Shape (2, n w), which is done when one is asked for.
    """

    ends: tuple[bool, bool]
    find: Callable[[], tuple[Array, Array]]

    @classmethod
    def known(cls, ends: tuple[bool, bool], torque: Array, wrench: Array) -> Self:
        """With torques and wrenches that were found before."""
        return cls(ends, partial(_both, torque, wrench))

    @property
    def torque(self) -> Array:
        """Shape (2, m) [N m or N]; zero where there are none.

        Raises:
            SolverError: If no solver answers.
        """
        return self._found[0]

    @property
    def wrench(self) -> Array:
        """Robot after robot in base axes, Shape (2, n w) [N, N m]; zero where there are none.

        Raises:
            SolverError: If no solver answers.
        """
        return self._found[1]

    @cached_property
    def _found(self) -> tuple[Array, Array]:
        return self.find()


def holding_at_ends(
    cell: Cell,
    motion: CoordinatedMotion,
    samples: SampleRanges | None,
    sharing: LoadSharing | None,
    formulation: FormulationName,
    weights: Array,
    solver: str,
    distribute: DistributionName,
) -> tuple[Holding, tuple[Remark, ...]]:
    """The torques of the motion's own distribution at both ends at rest, which is c² = 0.

    Args:
        cell: The cell, with its load.
        motion: Its motion.
        samples: The ranges of c²: where 0 is in none, the limits do not let the cell hold still. Dry friction does
            not count for it. None where they are not known: those of the two ends are then found where they matter.
        sharing: A fixed distribution of the load, None for a free one.
        formulation: Unknowns of the programs.
        weights: W, Shape (m, m).
        solver: Name in the registry.
        distribute: What redundant torques are chosen by.

    Returns:
        The torques, and what to say where there are none although a controller needs them.

    Raises:
        SolverError: If no solver answers.
    """
    pushing, places = pushing_ends(motion.dq, motion.ddq), (0, motion.samples - 1)
    if not any(pushing):
        free = [False, False]
    elif any(np.any(robot.motors.coulomb) for robot in cell.robots):
        still, shared = _still(motion, sharing, np.array(places))  # friction that opposes a motion does not hold
        problem = build_sample_problem(cell, still, formulation=formulation, sharing=shared)
        free = (widening_at(problem, 0.0, solver, WHAT) <= TORQUE_WIDENING).tolist()
    elif samples is not None and not samples.several:  # else it may be in a lower interval
        free = [bool(samples.lower[place] <= 0) for place in places]
    else:
        at_ends, shared = np.array(places), _of_samples(sharing, np.array(places))
        widening = motion_widening(cell, motion, np.zeros(2), formulation=formulation, sharing=shared, samples=at_ends)
        free = (widening <= TORQUE_WIDENING).tolist()
    ends = (pushing[0] and free[0], pushing[1] and free[1])
    remarks = tuple(
        Remark(
            "no-row-at-rest",
            f"the limits do not let the cell hold still where the motion {('starts', 'ends')[end]}, so tables and bags "
            f"{('begin', 'end')[end]} with the torques of the motion: a controller must not stay there.",
            places[end],
        )
        for end in (0, 1)
        if pushing[end] and not free[end]
    )
    held = [place for place, end in zip(places, ends, strict=True) if end]
    if not held:
        nothing = np.zeros((2, motion.q.shape[1])), np.zeros((2, len(cell.robots) * len(cell.wrench_components)))
        return Holding.known(ends, *nothing), remarks
    asked = partial(_still_torques, cell, motion, sharing, np.array([held[0], held[-1]]), formulation)
    return Holding(ends, partial(_held, partial(asked, distribute, solver, weights), ends)), remarks


def _both(torque: Array, wrench: Array) -> tuple[Array, Array]:
    return torque, wrench


def _held(asked: Callable[[], tuple[Array, Array, int]], ends: tuple[bool, bool]) -> tuple[Array, Array]:
    """What holds still at the ends that need it, zero at the others."""
    torque, wrench, _ = asked()
    kept = np.array(ends)[:, None]
    return np.where(kept, torque, 0.0), np.where(kept, wrench, 0.0)


def _still_torques(
    cell: Cell,
    motion: CoordinatedMotion,
    sharing: LoadSharing | None,
    chosen: NDArray[np.int_],
    formulation: FormulationName,
    distribute: DistributionName,
    solver: str,
    weights: Array,
) -> tuple[Array, Array, int]:
    """Torques and wrenches at some samples at which the joints stand."""
    still, shared = _still(motion, sharing, chosen)
    return TORQUES[distribute](cell, still, formulation, shared, solver, 0.0, weights)


def _still(
    motion: CoordinatedMotion, sharing: LoadSharing | None, chosen: NDArray[np.int_]
) -> tuple[CoordinatedMotion, LoadSharing | None]:
    """Some samples at which the joints stand, with the distribution there."""
    stands = np.zeros((len(chosen), motion.q.shape[1]))
    return replace(motion.at(chosen), dq=stands, ddq=stands, travel=None), _of_samples(sharing, chosen)


def _of_samples(sharing: LoadSharing | None, chosen: NDArray[np.int_]) -> LoadSharing | None:
    """The distribution at some samples."""
    internal = None if sharing is None else sharing.internal_wrench
    if sharing is None or internal is None or np.ndim(internal) == 1:
        return sharing
    return replace(sharing, internal_wrench=np.asarray(internal)[chosen])
