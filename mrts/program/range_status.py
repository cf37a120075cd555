# SPDX-License-Identifier: MIT
"""What a range of c² is, at a sample and over a motion."""

from enum import Enum


class RangeStatus(Enum):
    """Outcome at one sample, or over the motion; `advice` says what it means there and what to do.

    A sample is empty if every load of a box has a range there, but no c² is in all.
    """

    FEASIBLE = "feasible"
    INFEASIBLE = "infeasible"
    EMPTY = "empty"
    UNBOUNDED = "unbounded"

    @property
    def advice(self) -> str:
        """What this outcome over the motion means and what to do."""
        return {
            "feasible": "Every c² in the range keeps all limits.",
            "infeasible": (
                "Some sample is infeasible at every speed. Move the path, raise a limit, lighten the load, or try "
                "another configuration."
            ),
            "empty": (
                "Every sample, and every load, is feasible at some speed, but no constant c² suits all. Change the "
                "velocity profile, split the motion between the two samples, or narrow the load."
            ),
            "unbounded": "No limit depends on the speed at the samples: you may play it as fast as you like.",
        }[self.value]

    @property
    def admits_motion(self) -> bool:
        """Whether some c² is admissible."""
        return self in {RangeStatus.FEASIBLE, RangeStatus.UNBOUNDED}


SampleStatus = ScalingStatus = RangeStatus
"""The public names: of a sample's range, and of the range over the motion."""
