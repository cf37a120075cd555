# SPDX-License-Identifier: MIT
"""YAML without surprises.

No key stands twice, numbers are those of YAML 1.2, and no small text means a huge value.
"""

import math
import re
from typing import Any, cast

import yaml
from yaml.composer import ComposerError

MAX_YAML_BYTES = 1_000_000
MAX_YAML_VALUES = 20_000
"""Nearly two thousand waypoints: read in a second, and far above any cell. Larger data go into tables."""

LINE = 110

MAX_YAML_DEPTH = 20
"""A cell file is 5 deep."""


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


def yaml_text(value: Any, *, one_line: bool = False) -> str:
    """YAML text of a value, keys in their order, lists of numbers in one line; `parse_yaml` reads the same value."""
    flow, width = (True, math.inf) if one_line else (None, LINE)
    text: str = yaml.dump(
        value, Dumper=_StrictDumper, default_flow_style=flow, sort_keys=False, allow_unicode=True, width=width
    )
    return text.removesuffix("...\n").removesuffix("\n") if one_line else text


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
