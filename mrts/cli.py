# SPDX-License-Identifier: MIT
"""The command line `mrts`; its commands are in mrts/commands."""

import atexit
import gc
import logging
import os
import signal
import sys
import textwrap
import traceback
from collections.abc import Sequence
from importlib import import_module
from pathlib import Path

import click

from mrts.base.errors import MrtsError, message_text
from mrts.base.regular_file import FILES_READ
from mrts.base.version import __version__
from mrts.commands.console import (
    BAD_INPUT,
    DEBUG,
    QUIET,
    RemarkHandler,
    encode_anything,
    fail,
    fail_raw,
    open_closed_streams,
    warn,
)
from mrts.commands.options import EVERYWHERE, printing
from mrts.commands.signals import persistent_interrupt

COMMANDS = {
    "demo": "run the paper's examples",
    "new": "begin a cell from URDFs alone: hands, bases, a motion that can be played",
    "check": "all that is wrong, assumed, or out of reach in a cell and a motion, at once, without a compiler",
    "generate": "generate the C of a cell",
    "scale": "find the range of c², choose c², distribute the torques",
    "configurations": "compare all inverse-kinematics branches of the arms",
    "sweep": "solve all variants of a study: numbers of cell and motion that vary",
    "place": "where to put the arms and how to hold the object: the layout that may be played fastest",
    "simulate": "whether a plan keeps its limits when a controller plays it on an imperfect cell",
    "identify": "armature and friction of the motors from a recording of the arms' free motion",
    "view": "a cell in the browser, its motion at any speed against all limits; pictures and films",
    "report": "write a saved result or a study as an HTML page that opens offline",
    "export": "write a self-contained C library of a cell for a controller",
}
"""In the order of `--help`, with what it says of each; the module in mrts/commands is imported if it is the one."""

DEFECT = 70
"""Exit code: mrts itself failed. EX_SOFTWARE of sysexits.h."""

PIPE_CLOSED = 141
"""What a shell reports of a program whose reader went away."""

SIGNALLED = 128
"""What a shell adds to the number of the signal that ended a program."""

LONGEST_REASON = 300
"""Letters of the words of an exception that nobody expected."""

REPORT = (
    "This is a defect of mrts, whatever the input. Please report it, with the files and with what the same command "
    "prints with --debug."
)

ENDINGS = {signal.SIGINT: "interrupted", signal.SIGTERM: "terminated", signal.SIGHUP: "the terminal is gone"}
"""What is said when a signal ends the work."""

EPILOG = """\
\b
examples:
  mrts demo                                       the paper's examples, with files to start from
  mrts new lift --robot arm.urdf                  a cell and a motion of your own robots, to start from
  mrts check cell.yaml motion.yaml                what is wrong with files, or out of reach?
  mrts scale cell.yaml motion.yaml                how fast may this motion be played?
  mrts view cell.yaml motion.yaml                 the same in the browser, at any speed
  mrts COMMAND --help                             options and examples of a command

\b
exit code: 0 feasible, 1 a named infeasible outcome, 2 bad input or an output that cannot be written,
  70 a defect of mrts, 130 Ctrl-C, 141 the reader of the output went away, 129 and 143 other signals"""

THREADS_OF_BLAS = ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "GOTO_NUM_THREADS")
"""Where none is set, numpy's BLAS starts a thread a core, which waits in a loop for matrices larger than any here."""

COMPLETION = "_MRTS_COMPLETE"
"""Set by a shell that asks how a line goes on."""


class _Commands(click.Group):
    """The line; of its commands only the one that it names is imported."""

    def list_commands(self, ctx: click.Context) -> list[str]:  # noqa: ARG002 (Click's)
        """In the order of `COMMANDS`."""
        return list(COMMANDS)

    def resolve_command(
        self, ctx: click.Context, args: list[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        """The command that the line names."""
        name, command, rest = super().resolve_command(ctx, args)
        return name, command and import_module(f"mrts.commands.{name}").run, rest


LINE = _Commands(
    commands=[click.Command(name, short_help=meaning) for name, meaning in COMMANDS.items()],
    help="How fast may several robot arms carry one object, and with which torques?",
    epilog=EPILOG,
    params=[
        *EVERYWHERE,
        click.Option(["--version"], is_flag=True, is_eager=True, expose_value=False,
                     callback=printing(lambda _: f"mrts {__version__}"), help="show the version and end"),
    ],
    add_help_option=False,
    no_args_is_help=False,
    context_settings={"max_content_width": 120},
)  # fmt: skip


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
    logging.basicConfig(handlers=[RemarkHandler()], level=logging.WARNING)
    FILES_READ.clear()
    QUIET.set(False)
    DEBUG.set(False)
    words = [*(sys.argv[1:] if arguments is None else arguments)]
    try:
        with persistent_interrupt():
            code = _run(words)
    except (MrtsError, click.UsageError) as error:
        fail(f"error: {_usage(error, words) if isinstance(error, click.UsageError) else error}")
        for note in getattr(error, "__notes__", ()):
            warn(note)
        return BAD_INPUT
    except BrokenPipeError:
        return PIPE_CLOSED
    except OSError as error:
        place = f"{error.filename}: " if error.filename else ""
        fail(f"error: {place}the system says: {error.strerror or error}.")
        return BAD_INPUT
    except KeyboardInterrupt as error:
        number = error.args[0] if error.args else signal.SIGINT
        fail(ENDINGS[signal.Signals(number)])
        return SIGNALLED + number
    except (Exception, SystemExit) as error:  # noqa: BLE001 (told as a defect)
        if DEBUG.get():
            versions = f"mrts {__version__}, Python {sys.version.split()[0]} on {sys.platform}"
            fail_raw("".join(traceback.format_exception(error)) + versions)
        fail(_defect(error))
        return DEFECT
    return code


def _usage(error: click.UsageError, words: list[str]) -> str:
    """What is wrong with the line, in one line: a usage of twenty would hide it."""
    named = [word for word in words if word in COMMANDS][:1]  # Click does not know it where an option lacks its value
    command = " ".join(["mrts", *named]) if error.ctx is None else error.ctx.command_path
    text = message_text(error.format_message()).rstrip(".")
    return f"{text} ('{command} --help' has the options, and examples)"


def _defect(error: BaseException) -> str:
    """One paragraph: what happened, where, and what to do."""
    package = Path(__file__).parent
    frames = [frame for frame in traceback.extract_tb(error.__traceback__) if package in Path(frame.filename).parents]
    place = f" at {Path(frames[-1].filename).name}:{frames[-1].lineno}" if frames else ""
    if isinstance(error, MemoryError):
        return f"out of memory{place}. Give the motion fewer samples, or the load fewer uncertain parameters."
    reason = textwrap.shorten(" ".join(traceback.format_exception_only(error)), LONGEST_REASON, placeholder="…")
    return f"internal error{place}: {reason.rstrip('.')}. {REPORT}"


def _run(words: list[str]) -> int:
    """Run what the line names, or answer the shell that completes it."""
    if COMPLETION in os.environ:
        from click.shell_completion import shell_complete  # noqa: PLC0415 (for the shell only)

        return shell_complete(LINE, {}, "mrts", COMPLETION, os.environ[COMPLETION])
    try:
        with LINE.make_context("mrts", words) as context:
            code: int = LINE.invoke(context)
    except click.exceptions.Exit as ended:  # --help, --version
        code = ended.exit_code
    return code
