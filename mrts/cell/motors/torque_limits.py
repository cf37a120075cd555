# SPDX-License-Identifier: MIT
"""Least and largest torques of an arm's joints, as they are given."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from mrts.base.arrays import Array
from mrts.base.errors import InputError


def given_torque_limits(
    where: Path | str, key: str, lower: Sequence[float] | None, upper: Sequence[float], joints: Sequence[str]
) -> tuple[Array, Array]:
    """Torque limits, one a joint, each Shape (n,) [N m, N for prismatic joints].

    Args:
        where: The file, or what else they are given in, for messages.
        key: Of the limits in it.
        lower: None where they are symmetric, which is then -upper.
        upper: Largest torques.
        joints: Their names.

    Raises:
        InputError: If one side has another length, or a lower limit is not below the upper one.
    """
    sides = {key: upper} if lower is None else {f"{key}.lower": lower, f"{key}.upper": upper}
    for name, values in sides.items():
        if len(values) != len(joints):
            rule = f"must have {len(joints)} values, one for each of {', '.join(joints)}."
            raise InputError(where, rule, key=name, value=values)
    most = np.array(upper, dtype=float)
    least = -most if lower is None else np.array(lower, dtype=float)
    if np.any(least >= most):
        joint = int(np.argmax(least >= most))
        raise InputError(
            where,
            f"the lower torque limit {least[joint]:g} of joint '{joints[joint]}' must be below the upper one, "
            f"{most[joint]:g} (a symmetric limit must be > 0).",
            key=key,
        )
    return least, most
