# SPDX-License-Identifier: MIT
"""Values of a YAML text changed where they stand: what was not changed, comments too, stays as it was written."""

import json
import re
from collections.abc import Mapping, Sequence
from typing import Any

import yaml

from mrts.base.errors import InputError

Key = str | int

PLAIN = re.compile(
    r"(?!(?:true|false|yes|no|on|off|null|y|n)$)[A-Za-z./][A-Za-z0-9_./-]*[A-Za-z][A-Za-z0-9_./-]*", re.IGNORECASE
)
"""Text that needs no quotes in YAML; without a letter it may be a number."""


def edited_yaml(text: str, edits: Mapping[tuple[Key, ...], Any]) -> str:
    """A YAML text with other values.

    Args:
        text: That has been read before.
        edits: New values by where they are, as ("robots", 0, "base", "xyz"); what is missing there is added, in an
            existing mapping.

    Raises:
        InputError: If there is no such place, or an alias repeats what was there.
    """
    for keys, value in edits.items():
        try:
            root = yaml.compose(text, Loader=yaml.SafeLoader)
        except yaml.YAMLError:
            raise InputError("YAML", "an alias repeats what is to be replaced; write it out.") from None
        text = _edited(text, root, keys, value)
    return text


def _edited(text: str, node: Any, keys: tuple[Key, ...], value: Any) -> str:
    for depth, key in enumerate(keys):
        child = _child(node, key)
        if child is None:
            for later in reversed(keys[depth + 1 :]):
                value = {later: value}
            return _with_key(text, node, key, value)
        node = child
    start: int = node.start_mark.index
    return text[:start] + flow(value) + text[_end(node) :]


def _child(node: Any, key: Key) -> Any:
    if isinstance(node, yaml.SequenceNode) and isinstance(key, int) and -len(node.value) <= key < len(node.value):
        return node.value[key]
    if isinstance(node, yaml.MappingNode):
        return next((value for name, value in node.value if name.value == key), None)
    raise InputError("YAML", "there is no such place in the file.", key=str(key))


def _end(node: Any) -> int:
    """Where the text of a node ends; of a block its mark is where the next one begins, behind comments."""
    if isinstance(node, yaml.CollectionNode) and not node.flow_style and node.value:
        last = node.value[-1]
        return _end(last[1] if isinstance(last, tuple) else last)
    end: int = node.end_mark.index
    return end


def _with_key(text: str, node: Any, key: Key, value: Any) -> str:
    if not isinstance(node, yaml.MappingNode) or not isinstance(key, str):
        raise InputError("YAML", "there is no such place in the file.", key=str(key))
    end, entry = _end(node), f"{key}: {flow(value)}"
    if node.flow_style:
        return text[: end - 1] + (", " if node.value else "") + entry + text[end - 1 :]
    line = text.find("\n", end)
    line = len(text) if line < 0 else line
    indent: int = node.value[0][0].start_mark.column
    return text[:line] + "\n" + " " * indent + entry + text[line:]


def flow(value: Any) -> str:
    """A value on one line of YAML; numbers with all their digits."""
    if isinstance(value, Mapping):
        return "{" + ", ".join(f"{key}: {flow(part)}" for key, part in value.items()) + "}"
    if isinstance(value, str):
        return value if PLAIN.fullmatch(value) else json.dumps(value, ensure_ascii=False)
    if isinstance(value, Sequence):
        return "[" + ", ".join(map(flow, value)) + "]"
    if isinstance(value, float) and value.is_integer() and abs(value) < 1e15:  # noqa: PLR2004 (whole without loss)
        return str(int(value))
    return json.dumps(value) if value is None or isinstance(value, bool) else repr(value)
