# SPDX-License-Identifier: MIT
# PYTHON_ARGCOMPLETE_OK
"""The command line `mrts`; its verbs are in mrts/commands, its exit codes in mrts/console/exit_codes.py."""

import argparse
import atexit
import gc
import logging
import os
import re
import shlex
import signal
import sys
from collections.abc import Container, Sequence
from importlib import import_module
from pathlib import Path
from typing import Any, NoReturn

from mrts.base.errors import MotionError, MrtsError
from mrts.base.printable import message_text
from mrts.base.version import __version__
from mrts.commands.completion import complete, is_completing
from mrts.console.defect import describe_defect, trace
from mrts.console.exit_codes import BAD_INPUT, DEFECT, PIPE_CLOSED, SIGNALLED
from mrts.console.signals import EndedBySignal, persistent_interrupt
from mrts.console.terminal import (
    QUIET,
    RemarkHandler,
    encode_anything,
    fail,
    fail_raw,
    flush_answer,
    open_closed_streams,
    warn,
)

VERBS = {
    "demo": "run the paper's examples",
    "new": "begin a cell from URDFs alone: hands, bases, a motion that can be played",
    "check": "all that is wrong, assumed, or out of reach in a cell and a motion, at once, without a compiler",
    "generate": "generate the C of a cell",
    "scale": "find the range of c², choose c², distribute the torques",
    "configurations": "compare all inverse-kinematics branches of the arms",
    "sweep": "solve all variants of a study: numbers of cell and motion that vary",
    "place": "where to put the arms and how to hold the object: the layout that may be played fastest",
    "identify": "armature and friction of the motors from a recording of the arms' free motion",
    "view": "a cell in the browser, its motion at any speed against all limits; pictures and films",
    "report": "write a saved result or a study as an HTML page that opens offline",
    "export": "write a self-contained C library of a cell for a controller",
}
"""In the order of `--help`, with what it says of each; its module in mrts/commands is imported if it is the one."""

MAY_STAND_ALONE = {"--rates"}
"""Options with or without a value."""

NEGATIVE = re.compile(r"-[.\d]")
"""How a value begins that is no option."""

ENDINGS = {signal.SIGINT: "interrupted", signal.SIGTERM: "terminated", signal.SIGHUP: "the terminal is gone"}
"""What is said when a signal ends the work."""

QUIET_HELP = "print nothing but errors and what an option '-' asks for; files are written all the same"

EPILOG = """\
examples:
  mrts demo                                       the paper's examples, with files to start from
  mrts new lift --robot arm.urdf                  a cell and a motion of your own robots, to start from
  mrts check cell.yaml motion.yaml                what is wrong with files, or out of reach?
  mrts scale cell.yaml motion.yaml                how fast may this motion be played?
  mrts view cell.yaml motion.yaml                 the same in the browser, at any speed
  mrts VERB --help                                options and examples of a verb

exit code: 0 feasible, 1 a named infeasible outcome, 2 bad input or an output that cannot be written,
  70 a defect of mrts, 130 Ctrl-C, 141 the reader of the output went away, 129 and 143 other signals"""

THREADS_OF_BLAS = ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "GOTO_NUM_THREADS")
"""Where none is set, numpy's BLAS starts a thread a core, which waits in a loop for matrices larger than any here."""

DEBUG_HELP = "print the traceback of a defect of mrts, for a report of it"


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line.

    Args:
        arguments: Without the program's name; None takes those of the process.

    Returns:
        Exit code.
    """
    if not any(name in os.environ for name in THREADS_OF_BLAS):
        os.environ[THREADS_OF_BLAS[0]] = "1"
    atexit.register(gc.freeze)  # what is there at the end goes with the process: nothing is to be searched for garbage
    open_closed_streams()
    encode_anything()
    options: argparse.Namespace | None = None
    try:
        try:
            options = _options(arguments)
        finally:
            flush_answer()  # of --help
        with persistent_interrupt():
            code: int = options.run(options)
            flush_answer()
    except MrtsError as error:
        fail(f"error: {error}")
        if isinstance(error, MotionError) and options is not None:
            _advise_check(options)
        return BAD_INPUT
    except BrokenPipeError:
        return PIPE_CLOSED
    except OSError as error:
        place = f"{error.filename}: " if error.filename else ""
        fail(f"error: {place}the system says: {error.strerror or error}.")
        return BAD_INPUT
    except KeyboardInterrupt as error:
        number = error.number if isinstance(error, EndedBySignal) else signal.SIGINT
        fail(ENDINGS[signal.Signals(number)])
        return SIGNALLED + number
    except (Exception, SystemExit) as error:
        if options is None and isinstance(error, SystemExit):
            raise  # argparse has answered
        if options is not None and options.debug:
            fail_raw(trace(error))
        fail(describe_defect(error))
        return DEFECT
    return code


def _advise_check(options: argparse.Namespace) -> None:
    """Say what tells more of a motion that the arms do not follow."""
    cell, motion = getattr(options, "cell", None), getattr(options, "motion", None)
    if cell is not None and motion is not None:
        files = f"{shlex.quote(str(cell))} {shlex.quote(str(motion))}"
        warn(f"how near each arm comes, and what would work: mrts check {files}")


def _options(arguments: Sequence[str] | None) -> argparse.Namespace:
    """What the line asks for.

    Raises:
        SystemExit: If argparse has answered by itself.
    """
    logging.basicConfig(handlers=[RemarkHandler()], level=logging.WARNING)
    words = sys.argv[1:] if arguments is None else arguments
    verb = next((word for word in words if not word.startswith("-")), None)
    parser = _parser(VERBS if is_completing() else {verb})
    complete(parser)
    _check_verb(parser, verb)
    options = parser.parse_args(files_apart(negatives_attached(words), MAY_STAND_ALONE))
    QUIET.set(options.quiet)
    return options


class _Parser(argparse.ArgumentParser):
    """Its messages quote what was typed, and names of files are not empty."""

    def __init__(self, **settings: Any) -> None:
        super().__init__(**settings)
        self.register("type", Path, _named)

    def error(self, message: str) -> NoReturn:
        """Print the message and where the options stand, and leave; a usage of twenty lines would hide it."""
        fail(f"error: {message_text(message)} ('{self.prog} --help' has the options, and examples)")
        raise SystemExit(BAD_INPUT)


def _named(text: str) -> Path:
    """The file or folder of a name: an empty one would be the folder that the caller is in."""
    if not text:
        raise argparse.ArgumentTypeError("must not be empty: name a file or a folder")
    return Path(text)


def negatives_attached(words: Sequence[str]) -> list[str]:
    """The words of a line with each value that begins with a minus sign attached to its option: --base=-0.5,0,0.

    argparse takes it for an option where it is not a single number.

    Args:
        words: Of the line.
    """
    attached: list[str] = []
    for word in words:
        option = attached[-1] if attached else ""
        if NEGATIVE.match(word) and option.startswith("--") and option != "--" and "=" not in option:
            attached[-1] = f"{option}={word}"
        else:
            attached.append(word)
    return attached


def files_apart(words: Sequence[str], may_stand_alone: set[str]) -> list[str]:
    """The words of a line with each option that is followed by a file put last, where it stands alone.

    Args:
        words: Of the line.
        may_stand_alone: Options with or without a value.
    """
    kept: list[str] = []
    alone: list[str] = []
    for word, following in zip(words, [*words, ""][1:], strict=True):
        is_option = word.startswith("--") and any(name.startswith(word) for name in may_stand_alone) and word != "--"
        (alone if is_option and _is_file(following) else kept).append(word)
    end = kept.index("--") if "--" in kept else len(kept)
    return [*kept[:end], *alone, *kept[end:]]


def _is_file(word: str) -> bool:
    """Whether a word is meant for a file or a folder: no number, but there, or with a folder or an ending."""
    try:
        float(word)
    except ValueError:
        path = Path(word)
        return bool(word) and not word.startswith("-") and (path.suffix != "" or len(path.parts) > 1 or path.exists())
    return False


def _parser(wanted: Container[str | None]) -> argparse.ArgumentParser:
    """The parser of the whole line, with the arguments of some verbs."""
    parser = _Parser(
        prog="mrts",
        description="How fast may several robot arms carry one object, and with which torques?",
        epilog=EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--version", action="version", version=f"mrts {__version__}")
    parser.add_argument("-q", "--quiet", action="store_true", help=QUIET_HELP)
    parser.add_argument("--debug", action="store_true", help=DEBUG_HELP)
    verbs = parser.add_subparsers(required=True, metavar="VERB")
    for name, meaning in VERBS.items():
        verb = verbs.add_parser(name, help=meaning, formatter_class=argparse.RawDescriptionHelpFormatter)
        if name in wanted:
            module = import_module(f"mrts.commands.{name}")
            verb.epilog = module.EXAMPLES
            module.add(verb)
            verb.add_argument("-q", "--quiet", action="store_true", default=argparse.SUPPRESS, help=QUIET_HELP)
            verb.add_argument("--debug", action="store_true", default=argparse.SUPPRESS, help=DEBUG_HELP)
    return parser


def _check_verb(parser: argparse.ArgumentParser, verb: str | None) -> None:
    """Guess what a misspelt verb was to be; argparse only lists what there is."""
    if verb is not None and verb not in VERBS:
        import difflib  # noqa: PLC0415 (for this message only)

        close = difflib.get_close_matches(verb, VERBS, n=1)
        hint = f"did you mean '{close[0]}'?" if close else f"there are {', '.join(VERBS)}."
        parser.error(f"there is no verb '{verb}': {hint}")
