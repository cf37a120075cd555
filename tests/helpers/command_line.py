"""The command line as a user runs it: a process of its own."""

import subprocess
import sys


def mrts_command(*arguments, **options):
    command = [sys.executable, "-m", "mrts", *map(str, arguments)]
    return subprocess.run(command, capture_output=True, text=True, check=False, **options)
