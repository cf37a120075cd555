# SPDX-License-Identifier: MIT
"""The command line `mrts`; its verbs are in mrts/commands.

Exit codes: 0 feasible, 1 a named infeasible outcome, 2 bad input.
"""

import argparse
import io
import logging
import sys
from collections.abc import Sequence

from mrts import __version__
from mrts.commands import configurations, demo, export, generate, report, scale
from mrts.commands.exit_codes import BAD_INPUT
from mrts.errors import MrtsError

VERBS = (demo, generate, scale, configurations, report, export)
"""In the order of `--help`."""

PIPE_CLOSED = 141
"""What a shell reports of a program whose reader went away."""

INTERRUPTED = 130
"""What a shell expects of a program that Ctrl-C ended."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line.

    Args:
        arguments: Without the program's name; None takes those of the process.

    Returns:
        Exit code.
    """
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="replace")  # c² on a terminal without ²
    logging.basicConfig(format="mrts: %(message)s", level=logging.WARNING)
    options = _parser().parse_args(arguments)
    try:
        code: int = options.run(options)
        sys.stdout.flush()
    except MrtsError as error:
        print(f"mrts: error: {error}", file=sys.stderr)
        return BAD_INPUT
    except BrokenPipeError:
        sys.stderr.close()  # the reader went away; nothing more to say
        return PIPE_CLOSED
    except OSError as error:
        sys.stdout = None  # its buffer cannot be written; Python would try again at exit
        print(f"mrts: error: cannot write: {error.strerror}", file=sys.stderr)
        return BAD_INPUT
    except KeyboardInterrupt:
        print("mrts: interrupted", file=sys.stderr)
        return INTERRUPTED
    return code


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="mrts",
        description="How fast may several robot arms carry one object, and with which torques?",
        epilog="Exit code: 0 feasible, 1 a named infeasible outcome, 2 bad input.",
    )
    parser.add_argument("--version", action="version", version=f"mrts {__version__}")
    verbs = parser.add_subparsers(required=True, metavar="VERB")
    for verb in VERBS:
        verb.add(verbs)
    return parser
