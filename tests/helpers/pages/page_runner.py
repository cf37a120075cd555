"""Runs a page of the documentation: its code in order, in one folder, and compares what is printed with the page."""

import contextlib
import io
import os
import re
import subprocess
import sys
from dataclasses import dataclass, field
from pathlib import Path

BLOCK = re.compile(r'^```(\w+)(?: title="([^"]+)")?\n(.*?)^```$', re.MULTILINE | re.DOTALL)
FAILURES = ("mrts: error", "infeasible")
"""What a page shows where a command may end with another exit code than 0."""


@dataclass
class Page:
    """One run of a page.

    A `python` block is executed, all in one namespace; `sh` is given to bash, all in one folder; a block with a title
    is written to the file of that name; `text` is the whole output of the block before it, but for … which stands for
    anything; `console` shows what only another machine can run.
    """

    path: Path
    folder: Path
    names: dict = field(default_factory=dict)
    ran: int = 0

    def run(self):
        blocks = BLOCK.findall(self.path.read_text(encoding="utf-8"))
        printed = None
        for index, (kind, title, code) in enumerate(blocks):
            after = blocks[index + 1] if index + 1 < len(blocks) else ("", "", "")
            expected = after[2] if after[0] == "text" else ""
            if title:
                (self.folder / title).parent.mkdir(parents=True, exist_ok=True)
                (self.folder / title).write_text(code, encoding="utf-8")
            elif kind == "python":
                printed = self.python(code)
            elif kind == "sh":
                printed = self.shell(code, may_fail=any(word in expected for word in FAILURES))
            elif kind == "text":
                assert printed is not None, f"{self.path.name}: nothing was run before\n{code}"
                assert matches(code, printed), f"{self.path.name} says\n{code}\nbut this is printed:\n{printed}"
            else:
                assert kind in {"console", "yaml", "xml"}, (kind, code)
        return self

    def python(self, code):
        self.ran += 1
        output = io.StringIO()
        with contextlib.redirect_stdout(output), contextlib.chdir(self.folder):
            exec(compile(code, str(self.path), "exec"), self.names)  # noqa: S102
        return output.getvalue()

    def shell(self, code, *, may_fail):
        self.ran += 1
        environment = os.environ | {"PATH": f"{Path(sys.executable).parent}:{os.environ['PATH']}"}
        command = ["bash", "-eu", "-c", code]
        done = subprocess.run(
            command, cwd=self.folder, env=environment, text=True, check=False, stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
        )  # fmt: skip
        assert done.returncode == 0 or may_fail, f"{self.path.name}: {code}{done.stdout}"
        return done.stdout


def matches(expected, printed):
    """Whether a text is another one but for the places marked … and the white space."""
    pattern = ".*".join(re.escape(part) for part in " ".join(expected.split()).split("…"))
    return re.fullmatch(pattern, " ".join(printed.split())) is not None
