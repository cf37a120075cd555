# SPDX-License-Identifier: MIT
"""`mrts export`."""

import argparse
from pathlib import Path

from mrts.base.errors import InputError
from mrts.base.regular_file import is_folder
from mrts.commands.options.common import add_closure, cell_option, closure_option
from mrts.console.exit_codes import FEASIBLE
from mrts.console.output_files import check_outputs
from mrts.console.progress import working
from mrts.console.terminal import say

EXAMPLES = """\
examples:
  mrts export cell.yaml -o embedded/my_cell --precision float
  mrts export cell.yaml -o embedded/my_cell --functions range,torques --name arms
  make -C embedded/my_cell test example"""


def add(export: argparse.ArgumentParser) -> None:
    """Add the arguments of the verb."""
    export.add_argument("cell", type=Path, metavar="CELL", help="cell file")
    export.add_argument("-o", "--output", type=Path, required=True, metavar="DIR", help="folder for the library")
    export.add_argument("--precision", choices=["double", "float"], default="double", help="(default: %(default)s)")
    export.add_argument("--functions", default="", metavar="A,B,…",
                        help="of terms, range, share, torques (default: all, with tests and an example)")  # fmt: skip
    export.add_argument("--name", metavar="NAME", help="prefix of all names (default: the cell's name)")
    export.add_argument("--motion", type=Path, metavar="MOTION",
                        help="motion of the test vectors (default: a short lift)")  # fmt: skip
    add_closure(export)
    export.set_defaults(run=run)


def run(options: argparse.Namespace) -> int:
    """Write the library."""
    from mrts.cell.generation import comes_with_tests, export_to
    from mrts.following.coordinate import coordinate
    from mrts.motion.motion_file import load_motion
    from mrts.output.embedded_limits import embedded_limits
    from mrts.output.embedded_test_vectors import make_vectors, own_motion

    if is_folder(options.cell):
        raise InputError(options.cell, "an export starts from the cell file, not from a generated folder.")
    check_outputs({}, {"--output": options.output})
    cell = cell_option(options.cell)
    limits = embedded_limits(cell)
    parts = tuple(part for part in options.functions.split(",") if part)
    vectors, samples = [], 0
    if comes_with_tests(parts):
        if options.motion is None:
            motion = own_motion(cell)
        else:
            motion = coordinate(cell, load_motion(options.motion), closure_option(options.closure))
        vectors, samples = make_vectors(cell, motion), motion.samples
    with working(f"writing {options.output}"):
        written = export_to(
            options.cell,
            options.output,
            limits=limits,
            vectors=vectors,
            path_samples=samples,
            precision=options.precision,
            parts=parts,
            name=options.name,
        )
    say(f"{cell.name}: {options.precision} precision, {len(vectors)} test vectors, in {options.output}:")
    say("\n".join(f"  {name}" for name in written))
    return FEASIBLE
