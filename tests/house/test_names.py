"""Names that are read: a call says what its values are, nothing is defined that nobody calls, a unit has one home."""

import ast
import re
from collections import Counter

import pytest
from conftest import ROOT

import mrts

pytestmark = pytest.mark.quick

SOURCES = {
    path: path.read_text(encoding="utf-8") for folder in ("mrts", "codegen") for path in (ROOT / folder).rglob("*.py")
}
TREES = {path: ast.parse(text) for path, text in SOURCES.items()}

CALLED_BY_OTHERS = {"emit": "logging", "ignore_aliases": "PyYAML", "list_commands": "Click"}
CALLED_BY_OTHERS |= dict.fromkeys(("_repr_html_", "_repr_mimebundle_", "_repr_png_"), "notebooks")
CALLED_BY_OTHERS |= dict.fromkeys(("get_n_in", "get_n_out", "get_sparsity_in"), "CasADi")
"""Methods that nobody here calls, and who does."""


def definitions(kind):
    """Definitions of a kind, with the file of each."""
    return [(path, node) for path, tree in TREES.items() for node in ast.walk(tree) if isinstance(node, kind)]


def test_nothing_is_defined_that_nobody_uses():
    pages = [path.read_text(encoding="utf-8") for path in (ROOT / "mrts").rglob("*.html")]
    words = Counter(word for text in [*SOURCES.values(), *pages] for word in re.findall(r"\w+", text))
    documented = "".join(path.read_text(encoding="utf-8") for path in (ROOT / "docs").rglob("*.md"))
    unused = [
        f"{path.relative_to(ROOT)}: {node.name}"
        for path, node in definitions(ast.FunctionDef | ast.ClassDef)
        if words[node.name] == 1
        and node.name not in {*CALLED_BY_OTHERS, *mrts.__all__}
        and not re.fullmatch(r"__\w+__", node.name)
        and not any("validator" in ast.unparse(each) for each in node.decorator_list)
        and not re.search(rf"\b{node.name}\b", documented)
    ]
    assert unused == []
