# SPDX-License-Identifier: MIT
"""YAML without surprises, and edits of a text that leave the rest of it, comments too, as it was written.

No key stands twice, numbers are those of YAML 1.2, and no small text means a huge value.
"""

import json
import re
from collections.abc import Mapping, Sequence
from typing import Any, cast

import yaml
from yaml.composer import ComposerError

from mrts.base.errors import InputError

MAX_YAML_BYTES = 1_000_000
MAX_YAML_VALUES = 20_000
"""Nearly two thousand waypoints: read in a second, and far above any cell. Larger data go into tables."""

LINE = 110

MAX_YAML_DEPTH = 20
"""A cell file is 5 deep."""


Key = str | int

PLAIN = re.compile(
    r"(?!(?:true|false|yes|no|on|off|null|y|n)$)[A-Za-z./][A-Za-z0-9_./-]*[A-Za-z][A-Za-z0-9_./-]*", re.IGNORECASE
)
"""Text that needs no quotes in YAML; without a letter it may be a number."""


class _StrictLoader(yaml.SafeLoader):
    """SafeLoader that refuses duplicate keys and reads numbers as YAML 1.2 does: `1e-3` is one, `1:30` is none.

    A value that an alias repeats counts as often as it is repeated: what a file means cannot be larger than a file
    without aliases could be.
    """

    yaml_implicit_resolvers = {  # noqa: RUF012 (PyYAML's own class attribute)
        first: [(tag, pattern) for tag, pattern in resolvers if not tag.endswith((":int", ":float"))]
        for first, resolvers in yaml.SafeLoader.yaml_implicit_resolvers.items()
    }

    def __init__(self, stream: str) -> None:
        super().__init__(stream)
        self._values, self._depth = 0, 0
        self._sizes: dict[yaml.Node, int] = {}

    def compose_node(self, parent: yaml.Node | None, index: Any) -> yaml.Node | None:
        event = cast("Any", self).peek_event()  # PyYAML's types leave it out
        mark = event.start_mark
        before = self._values
        self._depth += 1
        if self._depth > MAX_YAML_DEPTH:
            raise ComposerError(problem=f"lists and keys lie more than {MAX_YAML_DEPTH} deep", problem_mark=mark)
        node = super().compose_node(parent, index)
        self._depth -= 1
        if isinstance(event, yaml.AliasEvent) and node not in self._sizes:
            raise ComposerError(problem=f"'*{event.anchor}' stands inside of what it repeats", problem_mark=mark)
        if node is not None:
            self._values = before + self._sizes.get(node, self._values - before + 1)
            self._sizes[node] = self._values - before
        if self._values > MAX_YAML_VALUES:
            raise ComposerError(
                problem=f"it holds more than {MAX_YAML_VALUES} values; what is longer belongs into a table",
                problem_mark=mark,
            )
        return node

    def compose_mapping_node(self, anchor: Any) -> yaml.MappingNode:
        node = super().compose_mapping_node(anchor)
        seen: set[str] = set()
        for key_node, _ in node.value:
            if not isinstance(key_node, yaml.ScalarNode):
                raise ComposerError(problem="a key must be text", problem_mark=key_node.start_mark)
            if key_node.value in seen:
                raise ComposerError(
                    problem=f"the key '{key_node.value}' stands twice", problem_mark=key_node.start_mark
                )
            seen.add(key_node.value)
        return node


# more digits are no number that fits anywhere, and Python refuses to read thousands
_StrictLoader.add_implicit_resolver("tag:yaml.org,2002:int", re.compile(r"^[-+]?[0-9]{1,300}$"), list("-+0123456789"))
_StrictLoader.add_implicit_resolver(
    "tag:yaml.org,2002:float",
    re.compile(r"^([-+]?(\.[0-9]+|[0-9]+(\.[0-9]*)?)([eE][-+]?[0-9]+)?|[-+]?\.(inf|Inf|INF)|\.(nan|NaN|NAN))$"),
    list("-+0123456789."),
)


class _StrictDumper(yaml.SafeDumper):
    """What `_StrictLoader` reads as text stands in quotes where it looks like a number, and nothing is an alias."""

    yaml_implicit_resolvers = _StrictLoader.yaml_implicit_resolvers

    def ignore_aliases(self, _data: Any) -> bool:
        return True


def yaml_text(value: Any) -> str:
    """YAML text of a value, keys in their order, lists of numbers in one line; `parse_yaml` reads the same value."""
    text: str = yaml.dump(
        value, Dumper=_StrictDumper, default_flow_style=None, sort_keys=False, allow_unicode=True, width=LINE
    )
    return text


def parse_yaml(text: str) -> Any:
    """Value of a YAML text.

    Raises:
        ValueError: If it is not YAML, or too much of it; the message ends the sentence "this file …".
    """
    try:
        return yaml.load(text, Loader=_StrictLoader)  # noqa: S506 (a SafeLoader)
    except yaml.YAMLError as error:
        mark = getattr(error, "problem_mark", None)
        place = f" at line {mark.line + 1}, column {mark.column + 1}" if mark else ""
        problem = getattr(error, "problem", None) or getattr(error, "reason", None) or "it cannot be parsed"
        raise ValueError(f"is not valid YAML{place}: {problem}") from None
    except ValueError as error:
        raise ValueError(f"holds a value that YAML cannot read: {error}") from None


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
