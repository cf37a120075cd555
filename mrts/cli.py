# SPDX-License-Identifier: MIT
# PYTHON_ARGCOMPLETE_OK
"""The command line `mrts`; its verbs are in mrts/commands.

Exit codes: 0 feasible, 1 a named infeasible outcome, 2 bad input.
"""

import argparse
import difflib
import io
import logging
import sys
from collections.abc import Sequence
from typing import NoReturn

from mrts import __version__
from mrts.commands import configurations, demo, export, generate, report, scale, view
from mrts.commands.completion import complete
from mrts.commands.exit_codes import BAD_INPUT
from mrts.commands.interrupt import persistent_interrupt
from mrts.commands.terminal import QUIET, RemarkHandler, fail
from mrts.errors import MrtsError
from mrts.printable import message_text

VERBS = (demo, generate, scale, configurations, view, report, export)
"""In the order of `--help`."""

PIPE_CLOSED = 141
"""What a shell reports of a program whose reader went away."""

INTERRUPTED = 130
"""What a shell expects of a program that Ctrl-C ended."""


QUIET_HELP = "print nothing but errors and what an option '-' asks for; files are written all the same"

EPILOG = """\
examples:
  mrts demo                                       the paper's examples, with files to start from
  mrts scale cell.yaml motion.yaml                how fast may this motion be played?
  mrts scale cell.yaml motion.yaml --plot plots   the same with figures
  mrts VERB --help                                options and examples of a verb

exit code: 0 feasible, 1 a named infeasible outcome, 2 bad input"""


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
    logging.basicConfig(handlers=[RemarkHandler()], level=logging.WARNING)
    parser, verbs = _parser()
    complete(parser)
    _check_verb(parser, verbs, sys.argv[1:] if arguments is None else arguments)
    options = parser.parse_args(arguments)
    QUIET.set(options.quiet)
    try:
        with persistent_interrupt():
            code: int = options.run(options)
        sys.stdout.flush()
    except MrtsError as error:
        fail(f"error: {error}")
        return BAD_INPUT
    except BrokenPipeError:
        sys.stderr.close()  # the reader went away; nothing more to say
        return PIPE_CLOSED
    except OSError as error:
        sys.stdout = None  # its buffer cannot be written; Python would try again at exit
        fail(f"error: cannot write: {error.strerror}")
        return BAD_INPUT
    except KeyboardInterrupt:
        fail("interrupted")
        return INTERRUPTED
    return code


class _Parser(argparse.ArgumentParser):
    """Its messages quote what was typed."""

    def error(self, message: str) -> NoReturn:
        """Print usage and message, and leave."""
        super().error(message_text(message))


def _parser() -> tuple[argparse.ArgumentParser, list[str]]:
    """The parser of the whole line, and the names of the verbs."""
    parser = _Parser(
        prog="mrts",
        description="How fast may several robot arms carry one object, and with which torques?",
        epilog=EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--version", action="version", version=f"mrts {__version__}")
    parser.add_argument("-q", "--quiet", action="store_true", help=QUIET_HELP)
    verbs = parser.add_subparsers(required=True, metavar="VERB")
    for verb in VERBS:
        verb.add(verbs)
    for of_verb in verbs.choices.values():
        of_verb.formatter_class = argparse.RawDescriptionHelpFormatter
        of_verb.add_argument("-q", "--quiet", action="store_true", default=argparse.SUPPRESS, help=QUIET_HELP)
    return parser, list(verbs.choices)


def _check_verb(parser: argparse.ArgumentParser, verbs: list[str], words: Sequence[str]) -> None:
    """Guess what a misspelt verb was to be; argparse only lists what there is."""
    verb = next((word for word in words if not word.startswith("-")), None)
    if verb is not None and verb not in verbs:
        close = difflib.get_close_matches(verb, verbs, n=1)
        hint = f"did you mean '{close[0]}'?" if close else f"there are {', '.join(verbs)}."
        parser.error(f"there is no verb '{verb}': {hint}")
