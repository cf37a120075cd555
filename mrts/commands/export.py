# SPDX-License-Identifier: MIT
"""`mrts export`."""

from pathlib import Path
from typing import TYPE_CHECKING, Any

from click import Choice, argument, option

from mrts.base.errors import InputError
from mrts.base.regular_file import is_folder
from mrts.commands import options
from mrts.commands.console import FEASIBLE, say, working
from mrts.commands.options import Named, Written

if TYPE_CHECKING:
    from mrts.following.coordinate import ClosureBound
    from mrts.program.rate_limits import Rates


@options.command
@argument("cell", type=Named(), metavar="CELL", help="cell file")
@option("-o", "--output", type=Written(folder=True), required=True, metavar="DIR", help="folder for the library")
@option("--precision", type=Choice(["double", "float"]), default="double", show_default=True, help="of its numbers")
@option("--name", help="prefix of all names (default: the cell's name)")
@option("--motion", type=Named(), metavar="MOTION", help="motion of the test vectors (default: a short lift)")
@option("--plan", type=Named(".npz", dir_okay=False), metavar="RESULT.npz",
        help="a plan to be played at any speed (docs/override.md)")  # fmt: skip
@option("--fastest-override", type=float, metavar="W", help="largest speed along the plan (default: 1, the plan's)")
@option("--backwards", is_flag=True, help="the plan may run back as well")
@options.rates
@options.closure
def run(
    cell: Path,
    output: Path,
    motion: Path | None = None,
    closure: "ClosureBound | None" = None,
    *,
    plan: Path | None = None,
    fastest_override: float = 1.0,
    backwards: bool = False,
    rates: "Rates | None" = None,
    **given: Any,
) -> int:
    """Write a self-contained C library of a cell for a controller.

    Examples:
        mrts export cell.yaml -o embedded/my_cell --precision float
        mrts export cell.yaml -o embedded/arms --name arms
        mrts export cell.yaml -o embedded/my_cell --plan result.npz --precision float
        make -C embedded/my_cell test example
    """
    from mrts.cell.generation import export_to
    from mrts.control.speed_override import SpeedOverride
    from mrts.following.coordinate import coordinate
    from mrts.motion.motion_file import load_motion
    from mrts.output.embedded_tables import embedded_tables, own_motion

    if is_folder(cell):
        raise InputError(cell, "an export starts from the cell file, not from a generated folder.")
    compiled = options.compiled_cell(cell)
    played = None
    if plan is not None:
        with working(f"tables of {plan}"):
            planned = options.result_of_cell(compiled, plan)
            played = SpeedOverride(planned, fastest=fastest_override, backwards=backwards, rates=rates)
    elif backwards or fastest_override != 1 or rates is not None:
        rule = "there is none that could be played faster, backwards or within rates. Give a saved result."
        raise InputError("--plan", rule)
    along = own_motion(compiled) if motion is None else coordinate(compiled, load_motion(motion), closure)
    tables = embedded_tables(compiled, along)
    with working(f"writing {output}"):
        written = export_to(cell, output, tables=tables, plan=None if played is None else played.tables, **given)
    say(f"{compiled.name}: {given['precision']} precision, {len(tables['VECTOR_ROWS'])} test vectors, in {output}:")
    say("\n".join(f"  {name}" for name in written))
    if played is not None:
        say(played.stops().sentence())
    return FEASIBLE
