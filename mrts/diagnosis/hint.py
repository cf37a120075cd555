# SPDX-License-Identifier: MIT
"""A likely mistake."""

from dataclasses import dataclass

from mrts.base.notebook.in_notebooks import InNotebooks


@dataclass(frozen=True)
class Hint(InNotebooks):
    """What may be meant instead.

    Attributes:
        code: Stable name of its kind, such as "millimetres", for programs.
        text: A sentence for people.
    """

    code: str
    text: str
