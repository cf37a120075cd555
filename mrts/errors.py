# SPDX-License-Identifier: MIT
"""The exceptions of mrts.

An infeasible motion is an outcome (`mrts.ScalingStatus`), never an exception. What raises is wrong input
and a tool that failed. Every message names the value, the rule and what to do.
"""

import reprlib
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray


class MrtsError(Exception):
    """Root of every exception that mrts raises on purpose."""


class InputError(MrtsError):
    """A file, a key or an argument breaks a rule.

    Args:
        where: File, or the name of the argument in the Python API.
        rule: What must hold, and what to do; a sentence.
        key: Path of the key inside the file, such as `robots[0].torque`.
        value: The offending value; left out of the message when None.
    """

    def __init__(self, where: Path | str, rule: str, *, key: str = "", value: object = None) -> None:
        self.where = str(where)
        self.key = key
        self.value = value
        self.rule = rule
        subject = self.where
        if key:
            subject += f": {key}"
        if value is not None:
            subject += f" = {reprlib.repr(value)}"
        super().__init__(f"{subject}: {rule}")


def as_array(name: str, value: object) -> "NDArray[np.float64]":
    """An argument of the Python API as an array of numbers.

    Args:
        name: Of the argument, for the message.
        value: Anything that numpy can read.

    Raises:
        InputError: If it is not numbers of one shape.
    """
    import numpy as np  # noqa: PLC0415 (so that `mrts --help` does without)

    try:
        return np.array(value, dtype=np.float64)
    except (TypeError, ValueError, OverflowError):
        raise InputError(name, "must be numbers of one rectangular shape.", value=value) from None


class MotionError(MrtsError):
    """The joints cannot follow the object's path: out of reach, singular, or off the plane."""


class CompilerError(MrtsError):
    """The C compiler failed, or none is there and nothing else can evaluate the generated C."""


class SolverError(MrtsError):
    """No solver returned an answer that passes its own verification."""
