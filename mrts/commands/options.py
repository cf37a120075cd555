# SPDX-License-Identifier: MIT
"""What a command is, and the options that several commands share.

An option has the name of the argument of the Python API that it gives, which checks it; an error of that argument is
told of the option. Options that are not given are left to the defaults of the API.
"""

import os
import shlex
from collections.abc import Callable, Container, Iterable, Iterator, Mapping
from contextlib import contextmanager
from functools import reduce
from inspect import cleandoc
from math import isfinite, nan
from operator import itemgetter
from pathlib import Path
from textwrap import dedent, indent
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

import click
from click import argument, option
from click.core import ParameterSource

from mrts.base.atomic_file import check_writable
from mrts.base.errors import InputError, MotionError, require_extra
from mrts.commands.console import DEBUG, QUIET, put, warn, working
from mrts.plots import FIGURE_FORMATS

if TYPE_CHECKING:
    from mrts.base.arrays import Array
    from mrts.cell.cell import Cell
    from mrts.following.coordinate import ClosureBound
    from mrts.motion.joint_table import JointTable
    from mrts.motion.object_motion import ObjectMotion
    from mrts.program.load_sharing import LoadSharing
    from mrts.scaling.scale import ScalingResult
    from mrts.timing.result import RetimingResult

PROBE = "mrts-probe"
"""A file that is tried, but not left, in a folder that is to be written."""

ANY_COUNT = range(1, 1 << 30)
"""Of numbers in a list."""

MOST_TOLD = 5
"""Numbers of which a saved result has others than a cell file."""

Decorator = Callable[[Callable[..., Any]], Callable[..., Any]]


class Named(click.Path):
    """A file or a folder.

    Args:
        suffixes: That a file may have; none for any.
    """

    def __init__(self, *suffixes: str, **kind: Any) -> None:
        super().__init__(**kind)
        self.suffixes = suffixes

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Path:  # noqa: ARG002
        """The path; an empty name would be the folder that the caller is in."""
        if not str(value) and param is not None:
            raise InputError(param.name or "", "must not be empty: name a file or a folder.")
        path = Path(value)
        is_folder = self.dir_okay and path.is_dir()
        if self.suffixes and path.suffix.lower() not in self.suffixes and not is_folder and param is not None:
            folder = "be a folder, or " if self.dir_okay else ""
            raise InputError(param.name or "", f"must {folder}end in {' or '.join(self.suffixes)}.", value=str(path))
        return path


class Written(Named):
    """A file or a folder that a command writes.

    Attributes:
        is_folder: Whether it is one.
        is_new: Whether it must not exist.
        dash: Whether `-` stands for standard output.
        needs: Packages that write it.
        extra: That brings them.
    """

    def __init__(
        self, *suffixes: str, folder: bool = False, new: bool = False, dash: bool = False,
        needs: tuple[str, ...] = (), extra: str = "",
    ) -> None:  # fmt: skip
        super().__init__(*suffixes, file_okay=not folder, dir_okay=folder)
        self.is_folder, self.is_new, self.dash = folder, new, dash
        self.needs, self.extra = needs, extra

    def check(self, option: str, path: Path) -> None:
        """Fail before any work if it cannot be written."""
        require_extra(option, self.extra, *self.needs)
        is_file = path.suffix[1:] in FIGURE_FORMATS if not path.exists() else not path.is_dir()
        if self.is_new and path.exists():
            raise InputError(path, "exists already: a bag is written into a new folder. Remove it, or name another.")
        if self.is_folder and is_file:
            raise InputError(option, "names a file, but writes a folder.", value=str(path))
        if not self.is_folder and not path.absolute().parent.is_dir():
            raise InputError(option, "is in a folder that is not there: make it, or name another.", value=str(path))
        try:
            check_writable(path / PROBE if self.is_folder and not self.is_new else path)
        except InputError as error:
            raise InputError(path, error.rule) from None


class Command(click.Command):
    """A command of the line, whose function is given what the line gives."""

    def __init__(self, **settings: Any) -> None:
        super().__init__(**settings, add_help_option=False)
        self.params += EVERYWHERE

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        """Read the words of the line."""
        with self._errors_of_options(ctx):
            _, _, order = self.make_parser(ctx).parse_args(list(args))
            for param in order:
                once = isinstance(param, click.Option) and not (param.multiple or param.is_flag)
                if once and order.count(param) > 1:
                    raise InputError(param.name or "", "is given twice.")
            return super().parse_args(ctx, args)

    def invoke(self, ctx: click.Context) -> Any:
        """Try the outputs, and run the command."""
        given = ParameterSource.COMMANDLINE
        ctx.params = {name: v for name, v in ctx.params.items() if ctx.get_parameter_source(name) is given or v}
        self._check_outputs(ctx.params)
        try:
            with self._errors_of_options(ctx):
                return super().invoke(ctx)
        except MotionError as error:
            if {"cell", "motion"} <= ctx.params.keys():
                files = shlex.join(str(ctx.params[name]) for name in ("cell", "motion"))
                error.add_note(f"how near each arm comes, and what would work: mrts check {files}")
            raise

    @contextmanager
    def _errors_of_options(self, ctx: click.Context) -> Iterator[None]:
        """What is wrong with an argument of Python is told of the option that gives it."""
        try:
            yield
        except InputError as error:
            options = {each.name: _shown(each) for each in self.params}
            if error.where not in options or error.where in map(str, ctx.params.values()):  # a file of that name
                raise
            value = None if error.value is True else error.value
            raise InputError(
                options[error.where], error.rule, key=error.key, value=value, others=error.others
            ) from None

    def _check_outputs(self, given: Mapping[str, Any]) -> None:
        inputs = [each for each in self.params if not isinstance(each.type, Written)]
        named = {
            os.path.realpath(file): _shown(each) for each in inputs if isinstance(file := given.get(each.name), Path)
        }
        kinds = [(_shown(each), each.type, given[each.name]) for each in self.params if each.name in given]
        for name, kind, path in kinds:
            if not isinstance(kind, Written) or (str(path) == "-" and kind.dash):
                continue
            if str(path) == "-":
                raise InputError(name, "writes a file; only --json takes '-' for standard output.", value="-")
            place = os.path.realpath(path)
            if place in named:
                raise InputError(name, f"names the same file as {named[place]}.", value=str(path))
            named[place] = name
            kind.check(name, path)


def _shown(param: click.Parameter) -> str:
    """How the line names a parameter: --output, or DIR."""
    return param.opts[-1] if isinstance(param, click.Option) else param.human_readable_name.strip("[]")


def printing(text: Callable[[click.Context], str]) -> Callable[[click.Context, click.Parameter, bool], None]:
    """What an option does that prints a text and ends the program."""

    def show(ctx: click.Context, _param: click.Parameter, asked: bool) -> None:  # noqa: FBT001 (Click's)
        if asked and not ctx.resilient_parsing:
            put(text(ctx))
            ctx.exit()

    return show


def _switch(variable: Any) -> Callable[[click.Context, click.Parameter, bool], None]:
    def switch(_ctx: click.Context, _param: click.Parameter, asked: bool) -> None:  # noqa: FBT001 (Click's)
        if asked:
            variable.set(True)

    return switch


def _flag(*names: str, callback: Any, help: str) -> click.Option:  # noqa: A002 (Click's)
    return click.Option(names, is_flag=True, is_eager=True, expose_value=False, callback=callback, help=help)


EVERYWHERE = [
    _flag("-q", "--quiet", callback=_switch(QUIET),
          help="print nothing but errors and what an option '-' asks for; files are written all the same"),
    _flag("--debug", callback=_switch(DEBUG), help="print the traceback of a defect of mrts, for a report of it"),
    _flag("-h", "--help", callback=printing(click.Context.get_help), help="show this message and end"),
]  # fmt: skip
"""Options of every command, and of the line before it."""


def command(function: Callable[..., int]) -> Command:
    """Make a command of a function, whose docstring is its help."""
    text, _, examples = cleandoc(function.__doc__ or "").partition("Examples:\n")
    epilog = f"\b\nexamples:\n{indent(dedent(examples), '  ')}"
    return click.command(cls=Command, help=text, epilog=epilog, context_settings={"max_content_width": 120})(function)


def take(given: dict[str, Any], names: Iterable[str]) -> dict[str, Any]:
    """Those of the arguments given that have some names; they are taken out of the others."""
    return {name: given.pop(name) for name in names if name in given}


def numbers(where: str, text: str, rule: str, counts: Container[int] = ANY_COUNT) -> list[float]:
    """Finite numbers with commas between them."""
    try:
        found = [float(word) for word in text.split(",")]
    except ValueError:
        found = [nan]
    if not all(map(isfinite, found)) or len(found) not in counts:
        raise InputError(where, rule, value=text)
    return found


def listed(
    where: str, rule: str, make: Callable[[Any], Any], words: Mapping[str, Any] = MappingProxyType({}),
    counts: Container[int] = ANY_COUNT,
) -> Callable[[str], Any]:  # fmt: skip
    """What reads an option of which a value is made: numbers, or what a word stands for."""
    return lambda text: make(words[text] if text in words else numbers(where, text, rule, counts))


def array(values: list[float]) -> "Array":
    """The numbers, Shape (n,)."""
    import numpy as np

    return np.array(values)


def _sharing(shares: list[float] | None) -> "LoadSharing":
    from mrts.program.load_sharing import LoadSharing

    return LoadSharing() if shares is None else LoadSharing(array(shares))


def _closure(bounds: list[float]) -> "ClosureBound":
    from mrts.following.coordinate import ClosureBound

    return ClosureBound(*bounds)


def _rate(given: list[float]) -> bool | float:
    if given[0] <= 0:
        raise InputError("rates", RATES, value=given[0])
    return given[0]


def together(*decorators: Decorator) -> Decorator:
    """Some options as one decorator, in the order of the help."""
    return lambda function: reduce(lambda of, decorator: decorator(of), reversed(decorators), function)


RATES = "must be 'cell', or a number > 0, a multiple of torque limits per second."
"""Rule of `--rates`."""

HTML = Written(".html", ".htm", needs=("jinja2", "plotly"), extra="report")

cell = argument("cell", type=Named(), metavar="CELL", help="cell file, or a folder that `mrts generate` wrote")
motion = argument(
    "motion", type=Named(), metavar="MOTION", help="motion file, CSV table, or ROS 2 bag with joint trajectories"
)
share = option(
    "--share", "sharing", metavar="equal|A,B,…",
    type=listed("sharing", "must be 'equal' or numbers such as 0.6,0.4.", _sharing, {"equal": None}),
    help="fixed distribution of the load: equal, or one share an arm",
)  # fmt: skip
closure = option(
    "--closure", metavar="M[,RAD]",
    type=listed("closure", "must be a number in m, or m and rad, such as 0.002,0.005.", _closure, counts=(1, 2)),
    help="of joint motion: how far hands may be off their grasps, onto which they are then moved; 2.5 rad per m where "
    "only m is given (default: 0.002,0.005)",
)  # fmt: skip
between = option(
    "--between", metavar="SHARE|off",
    type=listed("between", "must be a number such as 1e-4, or off.", itemgetter(0), {"off": [None]}, counts=(1,)),
    help="share of a limit by which it may be overstepped between the samples; samples are added where it takes them "
    "(default: 1e-4; off looks at the given samples alone)",
)  # fmt: skip
weights = option(
    "--weights", metavar="W|A,B,…",
    type=listed("weights", "must be a number, or numbers such as 1,1,4.",
                lambda given: given[0] if len(given) == 1 else array(given)),
    help="what the squares of torques weigh: 1 for all alike (as in the paper), or one a joint (default: 1 / limit² of "
    "each)",
)  # fmt: skip
rates = option(
    "--rates", metavar="cell|SHARE",
    type=listed("rates", RATES, _rate, {"cell": [True]}, counts=(1,)),
    help="keep limits of rates: those of the cell file (torque_rate, contact_rate and jerk); with a number, such as "
    "11.5, joints without a torque_rate get that multiple of their torque limit per second",
)  # fmt: skip
solver = option("--solver", help="solver of the registry (default: kernel)")
json = option("--json", type=Written(dash=True), metavar="FILE", help="write all of it ('-' is standard output)")


LIMITS = ("reserve", "no_wrench_limits", "no_velocity_limits")
"""Arguments of `compiled_cell` that `limits` gives."""


limits = together(
    option("--reserve", metavar="SHARE",
           type=listed("reserve", "must be a number such as 0.1; of mrts scale also auto.", itemgetter(0),
                       {"auto": ["auto"]}, counts=(1,)),
           help="share of every limit that is kept free, such as 0.1 (default: 0); of mrts scale also auto: the least "
           "with which the plan keeps all limits in mrts simulate"),
    option("--no-wrench-limits", is_flag=True, help="ignore the limits on the contact wrenches"),
    option("--no-velocity-limits", is_flag=True, help="report velocity limits, but let them bound nothing"),
)  # fmt: skip
"""The options that change limits of the cell, as `compiled_cell` takes them."""


def plot(what: str) -> Decorator:
    """The option of a command that plots."""
    folder = Written(folder=True, needs=("matplotlib",), extra="plot")
    return option("--plot", type=folder, metavar="DIR", help=f"write {what} (needs the extra 'plot')")


def result_of_cell(cell: "Cell", path: Path) -> "ScalingResult | RetimingResult":
    """A saved result with the functions of its cell; numbers that the cell has otherwise now are told."""
    from mrts.cell.cell_keys import differences
    from mrts.output.saved_result import load_result

    found = load_result(path, cell)
    if others := [*differences(found.cell, cell)]:
        told = [f"{key} = {saved} (now {given})" for key, saved, given in others[:MOST_TOLD]]
        more = f", and {len(others) - MOST_TOLD} more" * (len(others) > MOST_TOLD)
        warn(f"{path} is played with the numbers that it was found with: {', '.join(told)}{more}")
    return found


def compiled_cell(
    path: Path,
    motion: "ObjectMotion | JointTable | None" = None,
    closure: "ClosureBound | None" = None,
    *,
    reserve: float = 0.0,
    no_wrench_limits: bool = False,
    no_velocity_limits: bool = False,
) -> "Cell":
    """The cell of a file or folder; on first use generated and compiled, which a terminal sees.

    Args:
        path: Of the cell.
        motion: That the arms must follow: where they cannot, nothing is compiled first.
        closure: Of a motion of joints.
        reserve: Share of every limit that is kept free.
        no_wrench_limits: Whether contact wrenches are unlimited.
        no_velocity_limits: Whether velocities are.
    """
    from mrts.cell.cell import cell_to_compile, load_cell

    with working(f"generating and compiling {path}"):
        if motion is not None and (uncompiled := cell_to_compile(path)) is not None:
            from mrts.following.coordinate import coordinate

            coordinate(uncompiled, motion, closure)
        cell = load_cell(path)
    try:
        cell = cell.with_reserve(reserve)
    except InputError as error:
        raise InputError("reserve", error.rule, value=reserve) from None
    cell = cell.without_wrench_limits() if no_wrench_limits else cell
    return cell.without_velocity_limits() if no_velocity_limits else cell
