"""What pages, docstrings and comments mention exists: files of the house by path, modules by dotted name."""

import importlib
import io
import re
import tokenize

import pytest
from conftest import ROOT

pytestmark = pytest.mark.quick

PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md"))]
SOURCES = [path for folder in ("mrts", "codegen") for path in sorted((ROOT / folder).rglob("*.py"))]
KERNEL = sorted((ROOT / "mrts/kernel/c").rglob("*.[ch]"))
OTHERS = [ROOT / "Makefile", ROOT / "mkdocs.yml", ROOT / "pyproject.toml", *KERNEL]

FOLDERS = ("mrts", "codegen", "tests", "benchmarks", "docs", "generated")
PATH = re.compile(rf"(?<![\w./-])((?:{'|'.join(FOLDERS)})/[\w./-]*[\w/])")
NAME = re.compile(r"(?<![\w./{}<-])(\w+\.(?:py|c|h))\b(?!\()")
DOTTED = re.compile(r"(?<![\w./@-])(mrts(?:_codegen)?(?:\.[A-Za-z_]\w*)+)")
RECIPE_FILES = re.compile(r'^```\w+ title="([^"]+)"$', re.MULTILINE)

ELSEWHERE = {
    "generated/my_cell": "a user's",
    "tests/test_main.c": "in an exported library",
    "play.c": "of its page",
    "tests/vectors.h": "in an exported library",
    "dual_ur5_override.h": "in an exported library",
    "model.c": "in an exported library",
    "NAME.c": "in a generated cell",
    "math.h": "of the system",
    "sysexits.h": "of the system",
    "mrts.viewer.connections": "a logger",
}
"""What is mentioned but is nowhere here, and why."""

FILES = {path.name for path in (*ROOT.iterdir(), *(path for name in FOLDERS for path in (ROOT / name).rglob("*")))}


def prose(path):
    """Comments and texts of a Python file; of the changelog its newest part; another file as a whole."""
    text = path.read_text(encoding="utf-8")
    if path.name == "CHANGELOG.md":
        return text[: text.find("\n## ", text.index("\n## ") + 1)]
    if path.suffix == ".py":
        tokens = tokenize.generate_tokens(io.StringIO(text).readline)
        return "\n".join(t.string for t in tokens if t.type in {tokenize.COMMENT, tokenize.STRING})
    return text


def resolves(name):
    """Whether a dotted name leads to a module or to what is in one."""
    parts = name.split(".")
    found = importlib.import_module(parts[0])
    for index, part in enumerate(parts[1:], 2):
        if not hasattr(found, part):
            try:
                importlib.import_module(".".join(parts[:index]))
            except ImportError:
                return False
        found = getattr(found, part)
    return True


def test_what_is_mentioned_exists():
    wrong = {}
    for path in (*PAGES, *SOURCES, *OTHERS, ROOT / "CHANGELOG.md"):
        text = prose(path)
        new = RECIPE_FILES.findall(text)
        allowed = {*ELSEWHERE, *new, *(name.removesuffix(".py").replace("/", ".") for name in new)}
        missing = [name for name in PATH.findall(text) if not (ROOT / name).exists()]
        missing += [name for name in NAME.findall(text) if name not in FILES]
        missing += [name for name in DOTTED.findall(text) if not resolves(name)]
        if not set(missing) <= allowed:
            wrong[str(path)] = set(missing) - allowed
    assert wrong == {}
