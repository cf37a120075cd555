"""Runs a recipe of the documentation as a contributor would follow it, in a copy of the repository."""

import os
import shutil
import subprocess
import sys
from dataclasses import dataclass, field
from pathlib import Path

from page_runner import BLOCK, matches

COPIED = ("mrts", "codegen", "docs", "generated", "benchmarks", "tests/house", "tests/cases", "tests/conftest.py")
COPIED += ("README.md", "pyproject.toml")
"""What a recipe changes, and what the house's tests read."""

TYPING = "build/typing"
"""Where codegen/ has its import name, as after `make install`."""

HOUSE = "notation or equation or room or circle or apart"
"""The house's tests that a recipe can break."""


@dataclass
class Recipe:
    """One recipe: its blocks in order, in a copy of the repository.

    A block with a title is that new file, or (`diff`) a change to it; `python` and `sh` are run, each by a process that
    imports the copy; `text` is what the block before prints.
    """

    text: str
    folder: Path
    touched: dict = field(default_factory=dict)
    ran: int = 0

    def copy(self, root):
        for name in COPIED:
            target = self.folder / name
            target.parent.mkdir(parents=True, exist_ok=True)
            skipped = shutil.ignore_patterns("__pycache__", "*.png")
            if (root / name).is_dir():
                shutil.copytree(root / name, target, ignore=skipped)
            else:
                shutil.copy(root / name, target)
        (self.folder / TYPING).mkdir(parents=True)
        (self.folder / TYPING / "mrts_codegen").symlink_to(self.folder / "codegen")
        return self

    def follow(self, *, run=True):
        """Change the copy, and run what is to be run; `touched` keeps what was in each file before."""
        printed = None
        for kind, title, code in BLOCK.findall(self.text):
            if title:
                path = self.folder / title
                self.touched.setdefault(title, path.read_text(encoding="utf-8") if path.exists() else None)
                self.change(title, code) if kind == "diff" else self.write(title, code)
            elif not run:
                continue
            elif kind == "text":
                assert matches(code, printed), f"the page says\n{code}\nbut this is printed:\n{printed}"
            else:
                printed = self.call([sys.executable, "-c", code] if kind == "python" else ["bash", "-eu", "-c", code])
                self.ran += 1
        return self

    def undo(self):
        for title, before in self.touched.items():
            path = self.folder / title
            path.unlink() if before is None else path.write_text(before, encoding="utf-8")

    def write(self, title, code):
        path = self.folder / title
        assert not path.exists(), f"{title} is no new file"
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(code, encoding="utf-8")

    def change(self, title, code):
        """Replace the lines without "+" by those without "-"; they must stand in the file once."""
        path = self.folder / title
        lines = code.splitlines(keepends=True)
        before, after = ("".join(line[1:] or "\n" for line in lines if line[:1] != sign) for sign in "+-")
        text = path.read_text(encoding="utf-8")
        assert text.count(before) == 1, f"{title} does not have once:\n{before}"
        path.write_text(text.replace(before, after), encoding="utf-8")

    def check(self):
        """Lint of the Python files that are touched, and the house's tests, in the copy."""
        python = sorted(title for title in self.touched if title.endswith(".py"))
        if python:
            for verb in (["check"], ["format", "--check"]):
                self.call([str(Path(sys.executable).parent / "ruff"), *verb, *python])
            tests = ["tests/house/test_rooms.py", "tests/house/test_house.py"]
            self.call([sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", *tests, "-k", HOUSE])

    def call(self, command):
        path = f"{Path(sys.executable).parent}:{os.environ['PATH']}"
        environment = os.environ | {"PATH": path, "PYTHONPATH": f"{self.folder}:{self.folder / TYPING}"}
        done = subprocess.run(
            command, cwd=self.folder, env=environment, text=True, check=False, stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
        )  # fmt: skip
        assert done.returncode == 0, f"{command}\n{done.stdout}"
        return done.stdout
