# SPDX-License-Identifier: MIT
"""Texts with @WORDS@ to fill."""

import re
from pathlib import Path

FOLDER = Path(__file__).parent / "templates"


def filled(template: str, words: dict[str, str]) -> str:
    """A template with its words in place.

    Args:
        template: Path inside the folder of templates.
        words: What stands for each @WORD@.

    Raises:
        KeyError: If the template wants a word that there is not.
    """
    text = (FOLDER / template).read_text(encoding="utf-8")
    return re.sub(r"@([A-Z_]+)@", lambda match: words[match.group(1)], text)
