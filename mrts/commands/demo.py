# SPDX-License-Identifier: MIT
"""`mrts demo`."""

import argparse
import shutil
import sys
from pathlib import Path

from mrts.console.exit_codes import FEASIBLE
from mrts.console.output_files import check_outputs
from mrts.console.progress import working
from mrts.console.terminal import say, warn

EXAMPLES = """\
examples:
  mrts demo                  the table; figures and files in the folder mrts-demo
  mrts demo -o somewhere"""


def add(demo: argparse.ArgumentParser) -> None:
    """Add the arguments of the verb."""
    demo.add_argument("-o", "--output", type=Path, default=Path("mrts-demo"), metavar="DIR",
                      help="folder for the figures and example files (default: %(default)s)")  # fmt: skip
    demo.add_argument("--solver", default=None, help="solver of the registry (default: kernel)")
    demo.set_defaults(run=run)


def run(options: argparse.Namespace) -> int:
    """Run the paper's examples."""
    from mrts.commands.paper_examples import NOTE, format_table, run_demo, write_demo_files
    from mrts.program.solvers import DEFAULT_SOLVER

    check_outputs({}, {"--output": options.output})
    with working("running the paper's examples") as progress:
        rows = run_demo(options.solver or DEFAULT_SOLVER, progress)
    say("Two planar arms lift a bar (section VI of the paper): largest admissible c² in r(t) = c t\n", "strong")
    say(format_table(rows))
    say(f"\n{NOTE}\n")
    with working(f"writing {options.output}"):
        drawn = write_demo_files(options.output, rows)
    if not drawn:
        warn("the figures need matplotlib: pip install 'mrts[plot]'")
    folder = options.output / "planar_dual_arm"
    figures = "figures 4 to 8, the uncertain load, and " if drawn else ""
    say(f"Written to {options.output}: {figures}the files of the examples, a folder each. Try next:")
    plot = f" --plot {options.output}" if drawn else ""
    say(f"  {_command()} scale {folder / 'cell.yaml'} {folder / 'lift.yaml'}{plot}")
    return FEASIBLE


def _command() -> str:
    """How this program was called, for commands to try."""
    called = Path(sys.argv[0])
    if called.name == "__main__.py":
        return "python -m mrts"
    return called.name if shutil.which(called.name) else sys.argv[0]
