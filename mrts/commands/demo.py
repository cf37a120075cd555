# SPDX-License-Identifier: MIT
"""`mrts demo`."""

from pathlib import Path
from typing import Any

from click import option

from mrts.commands import options
from mrts.commands.console import FEASIBLE, say, warn, working
from mrts.commands.options import Written


@options.command
@option("-o", "--output", type=Written(folder=True), default="mrts-demo", show_default=True, metavar="DIR",
        help="folder for the figures and example files")  # fmt: skip
@options.solver
def run(output: Path, **given: Any) -> int:
    """Run the paper's examples.

    Examples:
        mrts demo                  the table; figures and files in the folder mrts-demo
        mrts demo -o somewhere
    """
    from mrts.commands.paper_examples import NOTE, format_table, run_demo, write_demo_files

    with working("running the paper's examples") as progress:
        rows = run_demo(**given, progress=progress)
    say("Two planar arms lift a bar (section VI of the paper): largest admissible c² in r(t) = c t\n", "strong")
    say(format_table(rows))
    say(f"\n{NOTE}\n")
    with working(f"writing {output}"):
        drawn = write_demo_files(output, rows)
    if not drawn:
        warn("the figures need matplotlib: pip install 'mrts[plot]'")
    folder = output / "planar_dual_arm"
    figures = "figures 4 to 8, the uncertain load, and " if drawn else ""
    say(f"Written to {output}: {figures}the files of the examples, a folder each. Try next:")
    plot = f" --plot {output}" if drawn else ""
    say(f"  mrts scale {folder / 'cell.yaml'} {folder / 'lift.yaml'}{plot}")
    return FEASIBLE
