"""The rooms of mrts: each imports only what stands above it."""

import ast
import re

import pytest
from conftest import ROOT

pytestmark = pytest.mark.quick

PACKAGE = ROOT / "mrts"

PAGE = (ROOT / "docs" / "extending.md").read_text(encoding="utf-8")
ROOMS = dict(re.findall(r"^\| `(\w+)` \| .+ \| `([\w.]+)` \|$", PAGE, re.MULTILINE))
"""In the order of the contributors' table, with where to start. A room imports itself and what stands above it."""

SHARED = (
    "mrts.cell.cell_file",
    "mrts.cell.record",
    "mrts.cell.robot",
    "mrts.cell.hands",
    "mrts.cell.points",
)
"""What the build time makes of a cell."""

APART = ("output", "viewer")
"""Each has its own library, and none the other's."""

ROOT_FILES = {"__init__.py", "__init__.pyi", "__main__.py", "cli.py", "py.typed"}


def modules():
    """Path of every module by its dotted name."""
    found = {}
    for path in sorted(PACKAGE.rglob("*.py")):
        parts = path.relative_to(ROOT).with_suffix("").parts
        found[".".join(parts[:-1] if parts[-1] == "__init__" else parts)] = path
    return found


def imports(path, known, *, everywhere):
    """Dotted names of our modules that a file imports, at its top only or also inside functions and for types only."""
    tree = ast.parse(path.read_text(encoding="utf-8"))
    names = set()
    for node in ast.walk(tree) if everywhere else tree.body:
        if isinstance(node, ast.Import):
            names |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.module:
            whole = {f"{node.module}.{alias.name}" for alias in node.names}
            names |= {name if name in known else node.module for name in whole}
    return names & known.keys()


def room(name):
    """The room of a module, None for what stands at the root."""
    parts = name.split(".")
    return parts[1] if len(parts) > 1 and (PACKAGE / parts[1]).is_dir() else None


def test_every_folder_is_a_room_of_the_table():
    folders = {path.name for path in PACKAGE.iterdir() if path.is_dir() and path.name != "__pycache__"}
    assert folders - {"data"} == set(ROOMS)
    assert [name for name, start in ROOMS.items() if not (PACKAGE / name / start).is_file()] == []
    assert {path.name for path in PACKAGE.iterdir() if path.is_file()} == ROOT_FILES


def above(name):
    """What a room may import, itself aside."""
    return [other for other in list(ROOMS)[: list(ROOMS).index(name)] if not {name, other} <= set(APART)]


def test_a_room_imports_only_what_stands_above_it():
    known = modules()
    wrong = [
        (name, other)
        for name, path in known.items()
        if room(name)
        for other in imports(path, known, everywhere=True)
        if room(other) != room(name) and room(other) not in above(room(name))
    ]
    assert wrong == []


def test_build_time_shares_only_what_cell_files_describe():
    known = modules()
    for path in (ROOT / "codegen").rglob("*.py"):
        for name in imports(path, known, everywhere=True):
            assert name.startswith(("mrts.base", *SHARED)), (path, name)


def test_no_circle_of_modules():
    known = modules()
    below = {name: imports(path, known, everywhere=False) - {name} for name, path in known.items()}
    while below:
        free = {name for name, needs in below.items() if not needs & below.keys()}
        assert free, f"these import each other: {sorted(below)}"
        below = {name: needs for name, needs in below.items() if name not in free}
