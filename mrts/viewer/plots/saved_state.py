# SPDX-License-Identifier: MIT
"""A saved result as a player shows it: at its own speed, because other torques take the functions of its cell."""

from math import sqrt

import numpy as np

from mrts.base.errors import InputError
from mrts.limits import all_rows, limit_rows
from mrts.scaling.result import LIMIT_TOLERANCE, ScalingResult
from mrts.viewer.offered_speeds import Speeds
from mrts.viewer.player_state import PlayerState


class SavedState(PlayerState):
    """A result that was read from a file; nothing of it is found anew.

    Args:
        result: With a trajectory.

    Raises:
        InputError: If it has none.
    """

    def __init__(self, result: ScalingResult) -> None:
        done = result.trajectory
        if done is None:
            raise InputError("result", f"has no motion to play: {result.status.value}.")
        self.sample, self.profile, self.timing, self.refusal = 0, "constant", None, ""
        self.result, self.trajectory = result, done
        self.speeds = Speeds({}, done.c, done.c, 1.0, done.c)
        rows = limit_rows(result.cell, result.motion)
        self.excess = np.max(rows.excess(rows.value(done.torque, done.wrench, 0.0, sqrt(done.c2))), axis=1, initial=0.0)
        self.excess[self.excess <= LIMIT_TOLERANCE] = 0.0
        self._rows = all_rows(result.cell, result.motion)

    def choose_speed(self, c: float) -> None:
        """Play at the speed that was saved.

        Args:
            c: That speed.

        Raises:
            InputError: If it is another.
        """
        if c != self.trajectory.c:
            raise InputError("c", "a saved result is played as it was saved: view the cell and its motion.", value=c)
