# SPDX-License-Identifier: MIT
"""The command line: `mrts demo`, `mrts generate`, `mrts scale`, `mrts configurations`, `mrts export`.

Exit codes: 0 feasible, 1 a named infeasible outcome, 2 bad input.
"""

import argparse
import io
import logging
import shutil
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from mrts import __version__
from mrts.errors import InputError, MrtsError

if TYPE_CHECKING:
    from mrts.cell import Cell
    from mrts.load_sharing import LoadSharing
    from mrts.result import ScalingResult
    from mrts.rigid_transform import Array
    from mrts.scaling import Selection

FEASIBLE, INFEASIBLE, BAD_INPUT = 0, 1, 2
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

    demo = verbs.add_parser("demo", help="run the paper's examples", epilog="Example: mrts demo -o mrts-demo")
    demo.add_argument("-o", "--output", type=Path, default=Path("mrts-demo"), metavar="DIR",
                      help="folder for the figures and example files (default: %(default)s)")  # fmt: skip
    demo.add_argument("--solver", default=None, help="solver of the registry (default: kernel)")
    demo.set_defaults(run=_demo)

    generate = verbs.add_parser(
        "generate", help="generate the C of a cell", epilog="Example: mrts generate cell.yaml -o generated/my_cell"
    )
    generate.add_argument("cell", type=Path, metavar="CELL", help="cell file")
    generate.add_argument("-o", "--output", type=Path, metavar="DIR",
                          help="folder for the C file and manifest.json (default: the user's cache)")  # fmt: skip
    generate.set_defaults(run=_generate)

    scale = verbs.add_parser(
        "scale",
        help="find the range of c², choose c², distribute the torques",
        epilog="Example: mrts scale cell.yaml motion.yaml --fastest --json result.json",
    )
    _add_cell_and_motion(scale)
    choice = scale.add_mutually_exclusive_group()
    choice.add_argument("--fastest", action="store_const", const="fastest", dest="select",
                        help="play as fast as the limits allow (default)")  # fmt: skip
    choice.add_argument("--nominal", action="store_const", const="nominal", dest="select", help="play as given, c² = 1")
    choice.add_argument("--c2", type=float, dest="select", metavar="VALUE", help="play at this c²")
    scale.add_argument("--share", metavar="equal|A,B,…",
                       help="fixed distribution of the load: equal, or one share an arm")  # fmt: skip
    scale.add_argument("--load", default="auto", metavar="QUESTION",
                       help="of a load that varies: guaranteed (for every load; the default if the cell gives "
                       "object.variation), possible (for some load), grid:N (for N masses), or nominal")  # fmt: skip
    scale.add_argument("--carry", metavar="KEY=VALUE,…",
                       help="torques for this load of the box, as mass=1.5,izz=0.8 (default: nominal)")  # fmt: skip
    scale.add_argument("--no-wrench-limits", action="store_true", help="ignore the limits on the contact wrenches")
    scale.add_argument("--formulation", choices=["wrench", "torque"], default="wrench",
                       help="unknowns of the programs (default: %(default)s)")  # fmt: skip
    scale.add_argument("--solver", default=None, help="solver of the registry (default: kernel)")
    scale.add_argument("--json", type=Path, metavar="FILE", help="write the whole result ('-' is standard output)")
    scale.add_argument("--csv", type=Path, metavar="FILE", help="write the scaled trajectory as a table")
    scale.add_argument("--ros-bag", type=Path, metavar="DIR",
                       help="write the scaled trajectory as a ROS 2 bag (MCAP; needs the extra 'ros')")  # fmt: skip
    scale.add_argument("--plot", type=Path, metavar="DIR", help="write figures (needs the extra 'plot')")
    scale.set_defaults(run=_scale)
    _add_configurations(verbs)
    _add_export(verbs)
    return parser


def _add_cell_and_motion(verb: argparse.ArgumentParser) -> None:
    verb.add_argument("cell", type=Path, metavar="CELL", help="cell file, or a folder that `mrts generate` wrote")
    verb.add_argument("motion", type=Path, metavar="MOTION", help="motion file")


def _add_configurations(verbs: "argparse._SubParsersAction[argparse.ArgumentParser]") -> None:
    study = verbs.add_parser(
        "configurations",
        help="compare all inverse-kinematics branches of the arms",
        epilog="Example: mrts configurations cell.yaml motion.yaml --show 5",
    )
    _add_cell_and_motion(study)
    study.add_argument("--share", metavar="equal|A,B,…", help="fixed distribution of the load")
    study.add_argument("--cap", type=int, default=1024, help="most combinations to evaluate (default: %(default)s)")
    study.add_argument("--show", type=int, default=10, metavar="N", help="rows to print (default: %(default)s)")
    study.add_argument("--solver", default=None, help="solver of the registry (default: kernel)")
    study.add_argument("--json", type=Path, metavar="FILE", help="write the whole ranking ('-' is standard output)")
    study.set_defaults(run=_configurations)


def _add_export(verbs: "argparse._SubParsersAction[argparse.ArgumentParser]") -> None:
    export = verbs.add_parser(
        "export",
        help="write a self-contained C library of a cell for a controller",
        epilog="Example: mrts export cell.yaml -o embedded/my_cell --precision float",
    )
    export.add_argument("cell", type=Path, metavar="CELL", help="cell file")
    export.add_argument("-o", "--output", type=Path, required=True, metavar="DIR", help="folder for the library")
    export.add_argument("--precision", choices=["double", "float"], default="double", help="(default: %(default)s)")
    export.add_argument("--functions", default="", metavar="A,B,…",
                        help="of terms, range, share, torques (default: all, with tests and an example)")  # fmt: skip
    export.add_argument("--name", metavar="NAME", help="prefix of all names (default: the cell's name)")
    export.add_argument("--motion", type=Path, metavar="MOTION",
                        help="motion of the test vectors (default: a short lift)")  # fmt: skip
    export.set_defaults(run=_export)


def _export(options: argparse.Namespace) -> int:
    from mrts.cell import load_cell
    from mrts.cell_cache import export_to
    from mrts.coordinated_motion import coordinate
    from mrts.embedded_test_vectors import make_vectors, own_motion
    from mrts.motion_file import load_motion

    if options.cell.is_dir():
        raise InputError(options.cell, "an export starts from the cell file, not from a generated folder.")
    cell = load_cell(options.cell)
    parts = tuple(part for part in options.functions.split(",") if part)
    vectors, samples = [], 0
    if not parts:  # tests and example go with a library of all parts only
        motion = coordinate(cell, load_motion(options.motion)) if options.motion is not None else own_motion(cell)
        vectors, samples = make_vectors(cell, motion), motion.samples
    written = export_to(options.cell, options.output, vectors, samples, options.precision, parts, options.name)
    _say(f"{cell.name}: {options.precision} precision, {len(vectors)} test vectors, in {options.output}:")
    _say("\n".join(f"  {name}" for name in written))
    return FEASIBLE


def _configurations(options: argparse.Namespace) -> int:
    from mrts.cell import load_cell
    from mrts.configurations import rank_configurations
    from mrts.motion_file import load_motion
    from mrts.object_motion import ObjectMotion
    from mrts.solvers import DEFAULT_SOLVER

    motion = load_motion(options.motion)
    if not isinstance(motion, ObjectMotion):
        raise InputError(options.motion, "a table of joint motion fixes the configuration; give the object's motion.")
    study = rank_configurations(
        load_cell(options.cell),
        motion,
        sharing=_sharing(options.share),
        cap=options.cap,
        solver=options.solver or DEFAULT_SOLVER,
    )
    if str(options.json) == "-":
        _say(study.json_text())
    else:
        _say(study.table(options.show))
        if options.json is not None:
            study.write_json(options.json)
    return FEASIBLE if study.ranked and study.ranked[0].range.status.admits_motion else INFEASIBLE


def _demo(options: argparse.Namespace) -> int:
    from mrts.demo import NOTE, format_table, run_demo, write_demo_files
    from mrts.solvers import DEFAULT_SOLVER

    rows = run_demo(options.solver or DEFAULT_SOLVER)
    _say("Two planar arms lift a bar (section VI of the paper): largest admissible c² in r(t) = c t\n")
    _say(format_table(rows))
    _say(f"\n{NOTE}\n")
    write_demo_files(options.output, rows, note=_warn)
    folder = options.output / "planar_dual_arm"
    _say(f"Written to {options.output}: figures 4 to 8, the uncertain load, and the example's files. Try next:")
    _say(f"  {_command()} scale {folder / 'cell.yaml'} {folder / 'lift.yaml'} --plot {options.output}")
    return FEASIBLE


def _command() -> str:
    """How this program was called, for commands to try."""
    called = Path(sys.argv[0])
    if called.name == "__main__.py":
        return "python -m mrts"
    return called.name if shutil.which(called.name) else sys.argv[0]


def _generate(options: argparse.Namespace) -> int:
    from mrts.cell_cache import generate_to

    manifest, source = generate_to(options.cell, options.output)
    _say(f"{manifest.name}: {len(manifest.functions)} functions in {source}")
    for function in manifest.functions.values():
        _say(f"  {function.symbol:<40} {function.instructions:>6} instructions")
    return FEASIBLE


def _scale(options: argparse.Namespace) -> int:
    from mrts.cell import load_cell
    from mrts.known_load import torques_for_load
    from mrts.motion_file import load_motion
    from mrts.scaling import SelectionError, scale
    from mrts.solvers import DEFAULT_SOLVER
    from mrts.text_report import report_lines

    _require("matplotlib", "--plot", "plot", wanted=options.plot is not None)
    _require("rosbags", "--ros-bag", "ros", wanted=options.ros_bag is not None)
    motion = load_motion(options.motion)
    sharing = _sharing(options.share)
    cell = load_cell(options.cell)
    if options.no_wrench_limits:
        cell = cell.without_wrench_limits()
    select: Selection = "auto" if options.select is None else options.select
    carried = _known_load(cell, options.carry, options.load)
    try:
        result = scale(
            cell,
            motion,
            select,
            sharing=sharing,
            formulation=options.formulation,
            solver=options.solver or DEFAULT_SOLVER,
            load=options.load,
            progress=_progress,
        )
        if carried is not None and result.trajectory is not None:
            result = torques_for_load(result, carried, solver=options.solver or DEFAULT_SOLVER)
    except SelectionError as error:
        if error.result is not None:
            _write(options, error.result)
        raise
    if str(options.json) != "-":
        for line in report_lines(result):
            _say(line)
        if result.fallbacks:
            _warn(f"{result.fallbacks} programs were left by the chosen solver and solved by another")
    _write(options, result)
    return FEASIBLE if result.status.admits_motion else INFEASIBLE


def _sharing(text: str | None) -> "LoadSharing | None":
    import numpy as np

    from mrts.load_sharing import LoadSharing

    if text is None:
        return None
    if text == "equal":
        return LoadSharing()
    try:
        shares = [float(word) for word in text.split(",")]
    except ValueError:
        raise InputError("--share", "must be 'equal' or numbers such as 0.6,0.4.", value=text) from None
    return LoadSharing(np.array(shares))


def _known_load(cell: "Cell", text: str | None, question: str) -> "Array | None":
    """The load of `--carry`."""
    if text is None:
        return None
    if cell.load_box is None:
        raise InputError("--carry", "picks a load of the box, but the cell gives no object.variation.", value=text)
    if question == "possible":
        raise InputError("--carry", "what is possible chooses no c², so there are no torques.", value=text)
    parameters: dict[str, float] = {}
    for part in text.split(","):
        name, _, number = part.partition("=")
        if name.strip() in parameters:
            raise InputError("--carry", f"gives {name.strip()} twice.", value=text)
        try:
            parameters[name.strip()] = float(number)
        except ValueError:
            raise InputError("--carry", "must be KEY=NUMBER, such as mass=1.5,izz=0.8.", value=text) from None
    return cell.load_box.load_at(parameters)


def _progress(done: int, total: int) -> None:
    """One line on a terminal, rewritten; gone when the work is done."""
    if sys.stderr.isatty():
        text = f"load {done} of {total}" if done < total else ""
        print(f"\r\x1b[K{text}", end="", file=sys.stderr, flush=True)


def _write(options: argparse.Namespace, result: "ScalingResult") -> None:
    if options.json is not None:
        if str(options.json) == "-":
            _say(result.json_text())
        else:
            result.write_json(options.json)
    if options.csv is not None:
        from mrts.trajectory_table import write_trajectory_csv

        write_trajectory_csv(result, options.csv)
    if options.ros_bag is not None:
        from mrts.ros_bag import write_ros_bag

        write_ros_bag(result, options.ros_bag)
    if options.plot is not None:
        from mrts.figures import range_figure, trajectory_figure, write_figure

        write_figure(range_figure(result), options.plot / "c2_range.png")
        if result.trajectory is not None:
            title = f"{result.cell.name}, c² = {result.trajectory.c2:.4g}"
            write_figure(trajectory_figure(result, title), options.plot / "torques_and_wrenches.png")


def _require(package: str, option: str, extra: str, *, wanted: bool) -> None:
    """Fail before any work if an option's package is missing."""
    from importlib.util import find_spec

    if wanted and find_spec(package) is None:
        raise InputError(option, f"needs {package}: pip install 'mrts[{extra}]'.")


def _say(text: str) -> None:
    print(text)


def _warn(text: str) -> None:
    print(f"mrts: {text}", file=sys.stderr)
