# SPDX-License-Identifier: MIT
"""What the command line prints."""

import sys


def say(text: str) -> None:
    """Print a line of the answer."""
    print(text)


def warn(text: str) -> None:
    """Print a remark beside the answer."""
    print(f"mrts: {text}", file=sys.stderr)


def show_progress(done: int, total: int) -> None:
    """One line on a terminal, rewritten; gone when the work is done."""
    if sys.stderr.isatty():
        text = f"load {done} of {total}" if done < total else ""
        print(f"\r\x1b[K{text}", end="", file=sys.stderr, flush=True)
