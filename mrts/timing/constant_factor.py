# SPDX-License-Identifier: MIT
"""The best constant factor of a motion, which a timing is compared with."""

from dataclasses import dataclass
from functools import cached_property

from mrts.cell.cell import Cell
from mrts.following.coordinated_motion import CoordinatedMotion
from mrts.scaling.options import Options
from mrts.scaling.result import ScalingResult
from mrts.scaling.scale import SelectionError, chosen_factor
from mrts.scaling.torques import with_torques


@dataclass(frozen=True)
class ConstantFactor:
    """The best constant factor of a motion, found when it is first read.

    Attributes:
        cell: The cell, with the reserve that it keeps.
        motion: Of the whole cell, as given.
        options: What is asked, checked.
    """

    cell: Cell
    motion: CoordinatedMotion
    options: Options

    @cached_property
    def factor(self) -> ScalingResult:
        """The range and the chosen c², without torques; without a c² where none moves the object.

        Raises:
            MotionError: If the arms cannot hold the object between the samples.
            SolverError: If no solver answers.
        """
        try:
            return chosen_factor(self.cell, self.motion, self.options)[0]
        except SelectionError as error:
            if error.result is None:
                raise
            return error.result

    @cached_property
    def whole(self) -> ScalingResult:
        """`factor` with its torques.

        Raises:
            MotionError: As `factor`.
            SolverError: If no solver answers, or the torques overstep a limit.
        """
        return with_torques(self.factor)
