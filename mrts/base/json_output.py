# SPDX-License-Identifier: MIT
"""A value that is written as JSON."""

import json
from abc import ABC, abstractmethod
from pathlib import Path
from typing import Any

from mrts.base.argument_types import as_path
from mrts.base.atomic_file import write_text_atomically


class JsonOutput(ABC):
    """Writes what `to_json` says."""

    @abstractmethod
    def to_json(self) -> dict[str, Any]:
        """All of it as JSON values."""

    def json_text(self) -> str:
        """`to_json` as text."""
        return json.dumps(self.to_json(), allow_nan=False, ensure_ascii=False)

    def write_json(self, path: Path | str) -> None:
        """Write `json_text` to a file, whole or not at all."""
        write_text_atomically(as_path("path", path), self.json_text() + "\n")
