# SPDX-License-Identifier: MIT
"""The exceptions of mrts.

An infeasible motion is an outcome (`mrts.ScalingStatus`), never an exception. What raises is wrong input
and a tool that failed. Every message names the value, the rule and what to do.
"""

import reprlib
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from mrts.result import ScalingResult


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


class SelectionError(MrtsError):
    """The requested c² is not in the admissible range, or no single value answers the request.

    Attributes:
        result: The `ScalingResult` with the range that was found; None before there is one.
    """

    result: "ScalingResult | None" = None


class MotionError(MrtsError):
    """The joints cannot follow the object's path: out of reach, singular, or off the plane."""


class CompilerError(MrtsError):
    """The C compiler failed, or none is there and nothing else can evaluate the generated C."""


class SolverError(MrtsError):
    """No solver returned an answer that passes its own verification."""
