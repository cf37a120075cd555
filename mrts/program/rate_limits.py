# SPDX-License-Identifier: MIT
"""How fast torques, contact wrenches and accelerations of a cell may change."""

from dataclasses import dataclass, fields

import numpy as np

from mrts.base.arrays import Array, EqualByNumbers, freeze, without_infinity
from mrts.base.errors import InputError, is_number
from mrts.base.input_file import LARGEST_NUMBER
from mrts.cell.cell import Cell
from mrts.limits.rows import RowName, joint_rows, wrench_rows

Rates = bool | float
"""What a user says of rates: True for those of the cell, or a multiple of torque limits per second [1/s]."""

WHAT_TO_GIVE = (
    "Give a robot of the cell file 'motors: {torque_rate: …}' [N m/s], 'motors: {jerk: …}' [rad/s³] or "
    "'contact_rate: [N/s, N m/s]'; or give a number: 11.5 takes 11.5 times the torque limit of each joint per second, "
    "which is what Franka publishes of its arms (1000 N m/s for 87 N m)."
)


@dataclass(frozen=True, eq=False)
class RateLimits(EqualByNumbers):
    """Largest rates of change of a cell with m joints and n w wrench components; infinity where there is none.

    Attributes:
        torque: |τ̇| of every joint, Shape (m,) [N m/s].
        wrench: |Ḟ| of every wrench component, base axes, Shape (n w,) [N/s, N m/s].
        jerk: |q⃛| of every joint, Shape (m,) [rad/s³].
    """

    torque: Array
    wrench: Array
    jerk: Array

    def __post_init__(self) -> None:
        freeze(self)

    def to_json(self) -> dict[str, list[float | None]]:
        """One list a kind; None stands for infinity."""
        return {entry.name: without_infinity(getattr(self, entry.name)) for entry in fields(self)}


def rate_names(cell: Cell) -> tuple[tuple[RowName, ...], tuple[RowName, ...], tuple[RowName, ...]]:
    """Names of torque rates, wrench rates and jerks, in the order of `RateLimits`."""
    torque = joint_rows(cell, "torque rate", "torque_units", "/s")
    return torque, wrench_rows(cell, "wrench rate", "/s"), joint_rows(cell, "jerk", "position_units", "/s³")


def given_rate_limits(cell: Cell) -> RateLimits:
    """What the cell itself says: `motors.torque_rate`, `contact_rate` and `motors.jerk`, less its reserve."""
    kept = 1.0 - cell.reserve
    return RateLimits(
        torque=kept * cell.stacked("motors.torque_rate"),
        wrench=kept * cell.stacked("contact_rate"),
        jerk=kept * cell.stacked("motors.jerk"),
    )


def rate_limits(cell: Cell, rates: Rates) -> RateLimits:
    """The rates that are to be kept, less the reserve of the cell.

    Args:
        cell: The cell.
        rates: True takes what the cell gives. A number > 0 takes besides, of joints whose motors give no torque rate,
            that multiple of the torque limit per second [1/s]; of limits whose sides differ, of the larger one, which
            is what the motor can give.

    Raises:
        InputError: If `rates` is something else, if it is True but the cell gives no rate at all, or if it is a
            number but a joint has no torque limit.
    """
    given = given_rate_limits(cell)
    if rates is True:
        if not any(np.isfinite(of).any() for of in vars(given).values()):
            raise InputError("rates", f"the cell '{cell.name}' limits no rate. {WHAT_TO_GIVE}", value=rates)
        return given
    if not is_number(rates, 0, LARGEST_NUMBER) or rates == 0:
        raise InputError(
            "rates", f"must be True, or a number > 0 and at most {LARGEST_NUMBER:.0e}. {WHAT_TO_GIVE}", value=rates
        )
    size = np.maximum(np.abs(cell.stacked("torque_lower")), np.abs(cell.stacked("torque_upper")))
    torque = np.where(np.isfinite(given.torque), given.torque, (1.0 - cell.reserve) * rates * size)
    if not np.all(np.isfinite(torque)):
        rule = (
            f"is a multiple of torque limits, but {cell.joint_names[int(np.argmax(torque))]} has none. Give its robot "
            "'motors: {torque_rate: …}' in N m/s, or a torque limit."
        )
        raise InputError("rates", rule, value=rates)
    return RateLimits(torque, given.wrench, given.jerk)
