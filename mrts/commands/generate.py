# SPDX-License-Identifier: MIT
"""`mrts generate`."""

from pathlib import Path

from click import argument, option

from mrts.base.errors import InputError
from mrts.commands import options
from mrts.commands.console.exit_codes import FEASIBLE
from mrts.commands.console.progress import working
from mrts.commands.console.terminal import say
from mrts.commands.options import Named, Written

EXAMPLES = """\
examples:
  mrts generate cell.yaml -o generated/my_cell
  mrts scale generated/my_cell motion.yaml                  runs without the URDFs
  mrts generate cell.yaml -o generated/my_cell --bake       bases, grasps and gravity as numbers in the C"""


@options.command(EXAMPLES)
@argument("cell", type=Named(), metavar="CELL", help="cell file")
@option("-o", "--output", type=Written(folder=True), metavar="DIR",
        help="folder for the C file and manifest.json (default: the user's cache)")  # fmt: skip
@option("--bake", is_flag=True,
        help="fold gravity, bases, grasps and held joints into the C as numbers: fewer instructions, but each cell "
        "file has C of its own; needs -o")  # fmt: skip
def run(cell: Path, output: Path | None = None, *, bake: bool = False) -> int:
    """Generate the C of a cell."""
    from mrts.cell.generation import generate_to

    if bake and output is None:
        raise InputError("bake", "needs -o DIR: the cache holds what all cells with the same chains share.")
    with working(f"generating {cell}"):
        manifest, source = generate_to(cell, output, bake=bake)
    say(f"{manifest.cell.name}: {len(manifest.functions)} functions in {source}")
    for function in manifest.functions.values():
        say(f"  {function.symbol:<40} {function.instructions:>6} instructions")
    return FEASIBLE
