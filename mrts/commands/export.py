# SPDX-License-Identifier: MIT
"""`mrts export`."""

from pathlib import Path
from typing import TYPE_CHECKING, Any

from click import Choice, argument, option

from mrts.base.errors import InputError
from mrts.base.regular_file import is_folder
from mrts.commands import options
from mrts.commands.console.exit_codes import FEASIBLE
from mrts.commands.console.progress import working
from mrts.commands.console.terminal import say
from mrts.commands.options import Named, Written

if TYPE_CHECKING:
    from mrts.following.grasp_closure import ClosureBound

EXAMPLES = """\
examples:
  mrts export cell.yaml -o embedded/my_cell --precision float
  mrts export cell.yaml -o embedded/my_cell --functions range,torques --name arms
  make -C embedded/my_cell test example"""


@options.command(EXAMPLES)
@argument("cell", type=Named(), metavar="CELL", help="cell file")
@option("-o", "--output", type=Written(folder=True), required=True, metavar="DIR", help="folder for the library")
@option("--precision", type=Choice(["double", "float"]), default="double", show_default=True, help="of its numbers")
@option(
    "--functions", metavar="A,B,…", help="of terms, range, share, torques (default: all, with tests and an example)"
)
@option("--name", help="prefix of all names (default: the cell's name)")
@option("--motion", type=Named(), metavar="MOTION", help="motion of the test vectors (default: a short lift)")
@options.closure
def run(
    cell: Path,
    output: Path,
    functions: str = "",
    motion: Path | None = None,
    closure: "ClosureBound | None" = None,
    **given: Any,
) -> int:
    """Write a self-contained C library of a cell for a controller."""
    from mrts.cell.generation import comes_with_tests, export_to
    from mrts.following.coordinate import coordinate
    from mrts.motion.motion_file import load_motion
    from mrts.output.embedded_limits import embedded_limits
    from mrts.output.embedded_test_vectors import make_vectors, own_motion

    if is_folder(cell):
        raise InputError(cell, "an export starts from the cell file, not from a generated folder.")
    compiled = options.compiled_cell(cell)
    limits = embedded_limits(compiled)
    parts = tuple(part for part in functions.split(",") if part)
    vectors, samples = [], 0
    if comes_with_tests(parts):
        played = own_motion(compiled) if motion is None else coordinate(compiled, load_motion(motion), closure)
        vectors, samples = make_vectors(compiled, played), played.samples
    with working(f"writing {output}"):
        written = export_to(cell, output, limits=limits, vectors=vectors, path_samples=samples, parts=parts, **given)
    say(f"{compiled.name}: {given['precision']} precision, {len(vectors)} test vectors, in {output}:")
    say("\n".join(f"  {name}" for name in written))
    return FEASIBLE
