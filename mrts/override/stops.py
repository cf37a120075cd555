# SPDX-License-Identifier: MIT
"""How soon, and how far on, all arms stand still wherever a plan is stopped."""

from dataclasses import dataclass

import numpy as np

from mrts.base.arrays import Array
from mrts.base.printable import printable


@dataclass(frozen=True, eq=False)
class Stops:
    """Stops on the path from the largest speed at n places of a plan, and from parts of it.

    Attributes:
        cell: Its name.
        time: Of the plan, Shape (n,) [s].
        stop_time: Until all arms stand still, the longest from any speed; infinite where they do not, Shape (n,) [s].
        distance: What the tip that goes farthest goes meanwhile, Shape (n,) [m].
        loads: How many loads the accelerations are for.
        excess: By how much of itself a limit is passed at most, at nodes and between.
        rates: Whether limits of rates are kept.
    """

    cell: str
    time: Array
    stop_time: Array
    distance: Array
    loads: int
    excess: float
    rates: bool

    def __repr__(self) -> str:
        return f"<Stops: {self.sentence()}>"

    def sentence(self) -> str:
        """What is promised."""
        loads = ", for every load of the box" if self.loads > 1 else ""
        if not np.all(np.isfinite(self.stop_time)):
            where = f"{self.time[int(np.argmax(self.stop_time))]:.4g} s of the plan"
            return f"not every stop ends: from {where} braking within the limits does not bring it to rest"
        longest, way = float(np.max(self.stop_time)), float(np.max(self.distance))
        kept = "inside all limits" if self.excess <= 0 else f"no limit passed by more than {100 * self.excess:.2g} %"
        kept += ", rates of torques too" if self.rates else ", whatever the rates of torques"
        return printable(
            f"from every point of this plan{loads} all arms come to rest on the path within {1e3 * longest:.3g} ms and "
            f"{1e3 * way:.3g} mm, {kept}"
        )
