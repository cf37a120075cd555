# SPDX-License-Identifier: MIT
"""`mrts generate`."""

import argparse
from pathlib import Path

from mrts.base.errors import InputError
from mrts.console.exit_codes import FEASIBLE
from mrts.console.output_files import check_outputs
from mrts.console.progress import working
from mrts.console.terminal import say

EXAMPLES = """\
examples:
  mrts generate cell.yaml -o generated/my_cell
  mrts scale generated/my_cell motion.yaml                  runs without the URDFs
  mrts generate cell.yaml -o generated/my_cell --bake       bases, grasps and gravity as numbers in the C"""


def add(generate: argparse.ArgumentParser) -> None:
    """Add the arguments of the verb."""
    generate.add_argument("cell", type=Path, metavar="CELL", help="cell file")
    generate.add_argument("-o", "--output", type=Path, metavar="DIR",
                          help="folder for the C file and manifest.json (default: the user's cache)")  # fmt: skip
    generate.add_argument("--bake", action="store_true",
                          help="fold gravity, bases, grasps and held joints into the C as numbers: fewer instructions, "
                          "but each cell file has C of its own; needs -o")  # fmt: skip
    generate.set_defaults(run=run)


def run(options: argparse.Namespace) -> int:
    """Generate the C of a cell."""
    from mrts.cell.generation import generate_to

    if options.bake and options.output is None:
        raise InputError("--bake", "needs -o DIR: the cache holds what all cells with the same chains share.")
    check_outputs({}, {"--output": options.output})
    with working(f"generating {options.cell}"):
        manifest, source = generate_to(options.cell, options.output, bake=options.bake)
    say(f"{manifest.name}: {len(manifest.functions)} functions in {source}")
    for function in manifest.functions.values():
        say(f"  {function.symbol:<40} {function.instructions:>6} instructions")
    return FEASIBLE
