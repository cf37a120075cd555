"""A command at a real terminal: a pseudo-terminal of its own, keys typed when something shows."""

import os
import subprocess
import sys
import threading
from dataclasses import dataclass

PATIENCE = 120.0
"""[s]"""

SPAWN = (
    "import os, pty, sys; code = os.waitstatus_to_exitcode(pty.spawn(sys.argv[1:]));"
    "sys.exit(code if code >= 0 else 128 - code)"  # as a shell says it
)

KEEP_OUTPUT = (
    "import os, sys, termios; modes = termios.tcgetattr(0); modes[3] |= termios.NOFLSH;"
    "termios.tcsetattr(0, termios.TCSANOW, modes); os.execvp(sys.argv[1], sys.argv[1:])"
)
"""A terminal discards what is on its way when Ctrl-C is typed; on a busy machine that may be the answer to it."""


@dataclass
class Session:
    code: int
    shown: str


def at_terminal(command, *, keys=(), **environment):
    """Run a command at a terminal; `keys` are pairs (text, what to type once that text has been shown), in order."""
    inherited = {name: value for name, value in os.environ.items() if name not in {"NO_COLOR", "COLUMNS"}}
    with subprocess.Popen(
        [sys.executable, "-c", SPAWN, sys.executable, "-c", KEEP_OUTPUT, *map(str, command)],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        env=inherited | {"TERM": "xterm", "PYTHONUNBUFFERED": "1"} | environment,
    ) as process:
        deadline = threading.Timer(PATIENCE, process.kill)  # what is waited for may never come
        deadline.start()
        shown, searched, waiting = b"", 0, list(keys)
        while chunk := os.read(process.stdout.fileno(), 4096):
            shown += chunk
            while waiting and waiting[0][0].encode() in shown[searched:]:
                text, typed = waiting.pop(0)
                searched = shown.index(text.encode(), searched) + len(text.encode())
                process.stdin.write(typed.encode())
                process.stdin.flush()
        deadline.cancel()
        assert not waiting, (waiting, shown)
    return Session(process.returncode, shown.decode())
