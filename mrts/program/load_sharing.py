# SPDX-License-Identifier: MIT
"""A fixed distribution of the load over the arms (the paper's section IV)."""

from dataclasses import dataclass

import numpy as np

from mrts.base.arrays import Array, EqualByNumbers
from mrts.base.errors import InputError, as_array
from mrts.cell.cell import Cell
from mrts.following.coordinated_motion import CoordinatedMotion

SHARE_TOLERANCE = 1e-9
"""How far the shares may sum from 1: they are typed with few digits."""

BALANCE_TOLERANCE = 1e-9
"""Largest net effect of an internal wrench on the object, relative to the wrench itself."""


@dataclass(frozen=True, eq=False)
class LoadSharing(EqualByNumbers):
    """Arm i carries the share α_i of the load, plus a prescribed internal wrench.

    Attributes:
        shares: α_i >= 0 with Σ α_i = 1, Shape (n,); None is equal shares.
        internal_wrench: Stacked wrenches in base axes with Σ B_i F_i = 0, Shape (n w,) or (N, n w) [N, N m];
            None is no internal wrench.
    """

    shares: Array | None = None
    internal_wrench: Array | None = None

    def __post_init__(self) -> None:
        """Torques may be asked for later: what can be written to is copied.

        Raises:
            InputError: If it is not numbers of one shape.
        """
        for name, value in (("shares", self.shares), ("internal_wrench", self.internal_wrench)):
            if isinstance(value, np.ndarray | list):
                own = as_array(name, value)
                own.setflags(write=False)
                object.__setattr__(self, name, own)

    @property
    def varies(self) -> bool:
        """Whether the internal wrench is given for each sample, so that it is not known at others."""
        return self.internal_wrench is not None and np.ndim(self.internal_wrench) > 1

    def inputs(self, cell: Cell, motion: CoordinatedMotion) -> dict[str, Array]:
        """Inputs of the generated fixed distribution.

        Raises:
            InputError: If a shape is wrong, the shares do not sum to 1, or the internal wrench moves the object.
        """
        robots = len(cell.robots)
        size = robots * len(cell.wrench_components)
        shares = np.full(robots, 1 / robots) if self.shares is None else as_array("shares", self.shares)
        total, right = np.sum(shares), shares.shape == (robots,) and np.isfinite(shares).all() and (shares >= 0).all()
        if not right or abs(total - 1) > SHARE_TOLERANCE:
            rule = f"must be {robots} finite numbers >= 0, one for each robot, that sum to 1; they sum to {total:.12g}."
            raise InputError("sharing", rule, key="shares", value=shares.tolist())
        if self.internal_wrench is None:
            return {"shares": shares, "internal_wrench": np.zeros(size)}
        internal = as_array("internal_wrench", self.internal_wrench)
        if internal.shape not in {(size,), (motion.samples, size)} or not np.isfinite(internal).all():
            raise InputError(
                "internal_wrench",
                f"must be finite with Shape ({size},) or ({motion.samples}, {size}); it has {internal.shape}.",
            )
        internal = np.broadcast_to(internal, (motion.samples, size))
        B = cell.functions("terms", motion.samples, motion.inputs(cell.load))["B"]
        net = np.max(np.abs(np.einsum("nij,nj->ni", B, internal)), axis=1)
        worst = int(np.argmax(net))
        if net[worst] > BALANCE_TOLERANCE * (1 + float(np.max(np.abs(internal[worst])))):
            raise InputError(
                "internal_wrench",
                f"must not move the object: at sample {worst} its net effect Σ B_i F_i is {net[worst]:.3g} (N, N m).",
            )
        return {"shares": shares, "internal_wrench": internal}
