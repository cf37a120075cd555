# SPDX-License-Identifier: MIT
"""Options that several verbs share."""

import argparse
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

from mrts.base.errors import InputError
from mrts.base.formats.figure_formats import FIGURE_FORMATS
from mrts.console.progress import working

if TYPE_CHECKING:
    from mrts.base.arrays import Array
    from mrts.cell.cell import Cell
    from mrts.following.grasp_closure import ClosureBound
    from mrts.motion.joint_table import JointTable
    from mrts.motion.object_motion import ObjectMotion
    from mrts.program.load_sharing import LoadSharing


def add_cell_and_motion(verb: argparse.ArgumentParser) -> None:
    """Add the two files that nearly every verb reads."""
    verb.add_argument("cell", type=Path, metavar="CELL", help="cell file, or a folder that `mrts generate` wrote")
    verb.add_argument("motion", type=Path, metavar="MOTION",
                      help="motion file, CSV table, or ROS 2 bag with joint trajectories")  # fmt: skip


def add_plot(verb: argparse.ArgumentParser, what: str) -> None:
    """Add the options of verbs that draw.

    Args:
        verb: The verb.
        what: Which figures, for its help.
    """
    verb.add_argument("--plot", type=Path, metavar="DIR", help=f"write {what} (needs the extra 'plot')")
    verb.add_argument("--plot-format", choices=FIGURE_FORMATS, help=f"of --plot (default: {FIGURE_FORMATS[0]})")


def plot_form(options: argparse.Namespace) -> str:
    """The format of `--plot`, before any work.

    Raises:
        InputError: If there is no `--plot` to have one, it names a picture, or its package is missing.
    """
    if options.plot_format is not None and options.plot is None:
        raise InputError(
            "--plot-format", "says how --plot writes figures: give --plot DIR too.", value=options.plot_format
        )
    if options.plot is not None and options.plot.suffix[1:] in FIGURE_FORMATS and not options.plot.is_dir():
        rule = "names a picture, and pictures are written into a folder: name that; --plot-format says of which kind."
        raise InputError("--plot", rule, value=str(options.plot))
    require("matplotlib", "--plot", "plot", wanted=options.plot is not None)
    return options.plot_format or FIGURE_FORMATS[0]


def add_closure(verb: argparse.ArgumentParser) -> None:
    """Add the option of verbs that take motions of joints."""
    verb.add_argument("--closure", metavar="M[,RAD]",
                      help="of joint motion: how far hands may be off their grasps, onto which they are then moved; "
                      "2.5 rad per m where only m is given (default: 0.002,0.005)")  # fmt: skip


def closure_option(text: str | None) -> "ClosureBound | None":
    """The bound that `--closure` gives; None for the default."""
    from mrts.following.grasp_closure import ClosureBound

    if text is None:
        return None
    try:
        position, *rotation = (float(word) for word in text.split(","))
    except ValueError:
        raise InputError("--closure", "must be a number in m, or m and rad, such as 0.002,0.005.", value=text) from None
    if len(rotation) > 1:
        raise InputError("--closure", "takes at most two numbers, m and rad.", value=text)
    try:
        return ClosureBound(position, *rotation)
    except InputError as error:
        raise InputError("--closure", error.rule, key=error.key, value=error.value) from None


def add_between(verb: argparse.ArgumentParser) -> None:
    """Add the option of verbs that keep limits between samples."""
    verb.add_argument("--between", default=None, metavar="SHARE|off",
                      help="share of a limit by which it may be overstepped between the samples; samples are added "
                      "where it takes them (default: 1e-4; off looks at the given samples alone)")  # fmt: skip


def between_option(text: str | None) -> float | None:
    """The tolerance that `--between` gives; None for the bare samples."""
    from mrts.program.excess import BETWEEN, checked_tolerance

    if text is None:
        return BETWEEN
    if text == "off":
        return None
    try:
        share = float(text)
    except ValueError:
        raise InputError("--between", "must be a number such as 1e-4, or off.", value=text) from None
    try:
        return checked_tolerance(share)
    except InputError as error:
        raise InputError("--between", error.rule.replace("None", "off"), value=text) from None


def cell_option(path: Path) -> "Cell":
    """The cell of a file or folder; on first use generated and compiled, which a terminal sees."""
    from mrts.cell.loading import load_cell

    with working(f"generating and compiling {path}"):
        return load_cell(path)


def add_reserve(verb: argparse.ArgumentParser) -> None:
    """Add the option of verbs that find ranges."""
    verb.add_argument("--reserve", type=float, default=0.0, metavar="SHARE",
                      help="share of every limit that is kept free, such as 0.1 (default: 0)")  # fmt: skip


def limited_cell_option(
    options: argparse.Namespace,
    motion: "ObjectMotion | JointTable | None" = None,
    closure: "ClosureBound | None" = None,
) -> "Cell":
    """The cell of a verb with the reserve, and without the limits that its options drop.

    Args:
        options: Of the verb.
        motion: That the arms must follow: where they cannot, nothing is compiled first.
        closure: Of a motion of joints.
    """
    from mrts.cell.loading import cell_to_compile

    uncompiled = None if motion is None else cell_to_compile(options.cell)
    if uncompiled is not None and motion is not None:
        from mrts.following.coordinate import coordinate

        coordinate(uncompiled, motion, closure)
    cell = cell_option(options.cell)
    _check_share(options.share, cell)
    if getattr(options, "no_wrench_limits", False):
        cell = cell.without_wrench_limits()
    try:
        cell = cell.with_reserve(options.reserve)
    except InputError as error:
        raise InputError("--reserve", error.rule, value=error.value) from None
    return cell.without_velocity_limits() if options.no_velocity_limits else cell


def sharing_option(text: str | None) -> "LoadSharing | None":
    """The distribution that `--share` names; None for a free one."""
    import numpy as np

    from mrts.program.load_sharing import LoadSharing

    if text is None:
        return None
    if text == "equal":
        return LoadSharing()
    try:
        shares = [float(word) for word in text.split(",")]
    except ValueError:
        raise InputError("--share", "must be 'equal' or numbers such as 0.6,0.4.", value=text) from None
    return LoadSharing(np.array(shares))


def weights_option(text: str | None, cell: "Cell") -> "Array | None":
    """The weights that `--weights` names for the joints of a cell; None for those of their limits."""
    import numpy as np

    from mrts.program.torque_distribution import torque_weights

    if text is None:
        return None
    try:
        numbers = [float(word) for word in text.split(",")]
    except ValueError:
        raise InputError("--weights", "must be a number, or numbers such as 1,1,4.", value=text) from None
    given = np.array(numbers[0] if len(numbers) == 1 else numbers)
    try:
        torque_weights(given, cell)
    except InputError as error:
        raise InputError("--weights", error.rule, value=text) from None
    return given


def _check_share(text: str | None, cell: "Cell") -> None:
    """Check that `--share` has one share for each arm of the cell."""
    sharing = sharing_option(text)
    if sharing is None:
        return
    try:
        sharing.of_robots(len(cell.robots))
    except InputError as error:
        raise InputError("--share", error.rule, value=text) from None


def numbers_option(
    option: str, text: str, example: str, units: Mapping[str, tuple[str, float]] | None = None
) -> dict[str, float]:
    """The numbers of an option that takes KEY=NUMBER,….

    Args:
        option: For the message.
        text: What was given.
        example: Of what is right.
        units: By key a unit that may stand behind its number, and what 1 of its number is in that unit.

    Raises:
        InputError: If it is something else.
    """
    numbers: dict[str, float] = {}
    for part in text.split(","):
        name, number = (word.strip() for word in part.partition("=")[::2])
        if name in numbers:
            raise InputError(option, f"gives {name} twice.", value=text)
        unit, one = (units or {}).get(name, ("", 1.0))
        try:
            if unit and number.endswith(unit):
                numbers[name] = float(f"{float(number.removesuffix(unit)) / one:.12g}")  # an end of a range stays one
            else:
                numbers[name] = float(number)
        except ValueError:
            raise InputError(option, f"must be KEY=NUMBER, such as {example}.", value=text) from None
    return numbers


def add_xacro_arg(verb: argparse.ArgumentParser, of: str) -> None:
    """Add the option of verbs that expand xacros.

    Args:
        verb: The verb.
        of: What is a xacro, for its help.
    """
    verb.add_argument("--xacro-arg", action="append", default=[], metavar="NAME=VALUE",
                      help=f"argument of {of}; once for each")  # fmt: skip


def xacro_arguments(given: list[str]) -> dict[str, str]:
    """Values of a xacro's arguments by name.

    Args:
        given: Of each `--xacro-arg`.

    Raises:
        InputError: If one has no name, or no value, or stands twice.
    """
    arguments: dict[str, str] = {}
    for text in given:
        name, sign, value = text.partition("=")
        if not name or not sign or name in arguments:
            raise InputError("--xacro-arg", "must be NAME=VALUE, each name once.", value=text)
        arguments[name] = value
    return arguments


def require(package: str, option: str, extra: str, *, wanted: bool) -> None:
    """Fail before any work if an option's package is missing."""
    from importlib.util import find_spec

    if wanted and find_spec(package) is None:
        raise InputError(option, f"needs {package}: pip install 'mrts[{extra}]'.")
