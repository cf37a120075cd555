# SPDX-License-Identifier: MIT
"""How much of its limits a played motion uses along time, a picture for each kind of limit."""

from dataclasses import dataclass

import numpy as np

from mrts.base.arrays import Array
from mrts.limits.rows import RowName
from mrts.scaling.limit_use import used_shares
from mrts.scaling.scaled_trajectory import ScaledTrajectory

TITLES = {
    "torque": "Joint torques",
    "wrench": "Contact wrenches",
    "velocity": "Joint velocities",
    "contact": "What the hands hold",
    "motor speed": "Motor speeds",
    "torque-speed": "Torques at speed",
}
"""Of kinds of limits in the order of their pictures; others come after them by their own name."""


@dataclass(frozen=True)
class LimitShares:
    """The limits of one kind.

    Attributes:
        kind: As in `mrts.limits.rows.RowName`.
        labels: A line each: `left/elbow`.
        share: Of its limit that each line uses, 1 at the limit, never below 0, Shape (N, lines).
    """

    kind: str
    labels: tuple[str, ...]
    share: Array

    @property
    def title(self) -> str:
        """What they are, for people."""
        return TITLES.get(self.kind, self.kind.capitalize())

    @property
    def largest(self) -> Array:
        """Of all lines at each sample, Shape (N,)."""
        largest: Array = np.max(self.share, axis=1)
        return largest

    @property
    def ranked(self) -> list[int]:
        """Lines, the one that comes nearest to its limit first."""
        return [int(line) for line in np.argsort(-np.max(self.share, axis=0), kind="stable")]


def limit_shares(done: ScaledTrajectory) -> list[LimitShares]:
    """The shares of all limits that there are, velocities also where their limits are reported only.

    The rows of one contact, such as the directions of its friction, make one line.

    Args:
        done: A played motion.
    """
    names, share = used_shares(done)
    kinds = dict.fromkeys([*TITLES, *(name.kind for name in names)])
    found = []
    for kind in kinds:
        lines: dict[str, list[int]] = {}
        for row, name in enumerate(names):
            if name.kind == kind:
                lines.setdefault(_label(name), []).append(row)
        if lines:
            together = [np.max(share[:, members], axis=1, initial=0.0) for members in lines.values()]
            found.append(LimitShares(kind, tuple(lines), np.column_stack(together)))
    return found


def _label(name: RowName) -> str:
    return name.contact or (f"{name.robot}/{name.element}" if name.robot else str(name))
