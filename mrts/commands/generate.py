# SPDX-License-Identifier: MIT
"""`mrts generate`."""

from pathlib import Path

from click import argument, option

from mrts.commands import options
from mrts.commands.console import FEASIBLE, say, warn, working
from mrts.commands.options import Named, Written


@options.command
@argument("cell", type=Named(), metavar="CELL", help="cell file")
@option("-o", "--output", type=Written(folder=True), metavar="DIR",
        help="folder for the C file and manifest.json (default: the user's cache)")  # fmt: skip
def run(cell: Path, output: Path | None = None) -> int:
    """Generate the C of a cell.

    Examples:
        mrts generate cell.yaml -o generated/my_cell
        mrts scale generated/my_cell motion.yaml                  runs without the URDFs
    """
    from mrts.cell.generation import generate_to

    with working(f"generating {cell}"):
        manifest, source = generate_to(cell, output)
    for remark in manifest.cell.remarks:
        warn(remark.text)
    say(f"{manifest.cell.name}: {len(manifest.functions)} functions in {source}")
    for function in manifest.functions.values():
        say(f"  {function.symbol:<40} {function.instructions:>6} instructions")
    return FEASIBLE
