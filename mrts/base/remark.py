# SPDX-License-Identifier: MIT
"""What a user should know about an answer that stands."""

from dataclasses import dataclass
from typing import Any

from mrts.base.notebook.in_notebooks import InNotebooks
from mrts.base.printable import printable


@dataclass(frozen=True)
class Remark(InNotebooks):
    """One entry of "warnings" in the JSON result.

    Attributes:
        code: Stable name of its kind, such as "not-at-rest", for programs.
        text: A sentence for people.
        sample: Where along the motion, None if it is about all of it.
    """

    code: str
    text: str
    sample: int | None = None

    def __str__(self) -> str:
        return f"warning: {printable(self.text)}"

    def to_json(self) -> dict[str, Any]:
        """Code, text and sample."""
        return {"code": self.code, "text": self.text, "sample": self.sample}
