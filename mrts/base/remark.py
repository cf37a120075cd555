# SPDX-License-Identifier: MIT
"""What a user should know about a cell, a motion, or an answer that stands."""

from dataclasses import dataclass
from typing import Any, Literal

from mrts.base.errors import printable

Severity = Literal["hint", "warning", "assumption"]
"""How much it matters: a likely mistake, what to know before trusting an answer, or what is taken for granted, which is
told by a check alone."""

NEAREST_INERTIA = "inertia-nearest"
"""Code of the remark on an inertia of a URDF that was moved to the nearest one of a body."""


@dataclass(frozen=True)
class Remark:
    """One entry of "warnings" in the JSON result.

    Attributes:
        code: Stable name of its kind, such as "not-at-rest", for programs.
        text: A sentence for people.
        sample: Where along the motion, None if it is about all of it.
        severity: How much it matters.
    """

    code: str
    text: str
    sample: int | None = None
    severity: Severity = "warning"

    @staticmethod
    def hint(code: str, text: str) -> "Remark":
        """A likely mistake."""
        return Remark(code, text, severity="hint")

    @staticmethod
    def assumed(code: str, text: str) -> "Remark":
        """What is taken for granted."""
        return Remark(code, text, severity="assumption")

    def __str__(self) -> str:
        return f"{self.severity}: {printable(self.text)}"

    def to_json(self) -> dict[str, Any]:
        """Code, severity, text and sample."""
        return {"code": self.code, "severity": self.severity, "text": self.text, "sample": self.sample}
