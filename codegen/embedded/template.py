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
    return in_place((FOLDER / template).read_text(encoding="utf-8"), words)


def sections(template: str) -> dict[str, str]:
    """The texts of a template that holds several, by the names in their headings `@@ NAME`.

    Args:
        template: Path inside the folder of templates.
    """
    _, *rest = re.split(r"(?m)^@@ ([A-Z_]+)\n", (FOLDER / template).read_text(encoding="utf-8"))
    return {name: text.rstrip("\n") for name, text in zip(rest[::2], rest[1::2], strict=True)}


def in_place(text: str, words: dict[str, str]) -> str:
    """A text with its words in place.

    Args:
        text: With @WORDS@.
        words: What stands for each.

    Raises:
        KeyError: If it wants a word that there is not.
    """
    return re.sub(r"@([A-Z_]+)@", lambda match: words[match.group(1)], text)
