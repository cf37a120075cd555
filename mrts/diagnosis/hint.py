# SPDX-License-Identifier: MIT
"""A likely mistake."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Hint:
    """What may be meant instead.

    Attributes:
        code: Stable name of its kind, such as "millimetres", for programs.
        text: A sentence for people.
    """

    code: str
    text: str
