# SPDX-License-Identifier: MIT
"""`mrts check`."""

from pathlib import Path
from typing import TYPE_CHECKING

from click import argument

from mrts.base.errors import InputError
from mrts.commands import options
from mrts.commands.console.exit_codes import BAD_INPUT, FEASIBLE, INFEASIBLE
from mrts.commands.console.output_files import Outputs
from mrts.commands.console.progress import working
from mrts.commands.console.terminal import QUIET, fail
from mrts.commands.options import Named

if TYPE_CHECKING:
    from mrts.starting.cell_check import CellCheck

CODES = {"fine": FEASIBLE, "impossible": INFEASIBLE, "wrong-input": BAD_INPUT}
"""Exit code by what came of the check."""

EXAMPLES = """\
examples:
  mrts check cell.yaml
  mrts check cell.yaml motion.yaml
  mrts check cell.yaml motion.yaml -q --json - | jq .hints
  mrts check arm.urdf                             a URDF or xacro by itself, before there is a cell"""


@options.command(EXAMPLES)
@argument("cell", type=Named(), metavar="CELL", help="cell file, or a URDF or xacro by itself")
@argument("motion", type=Named(), required=False, metavar="[MOTION]",
          help="motion file, CSV table, or ROS 2 bag with joint trajectories")  # fmt: skip
@options.json
@options.xacro_arg
def run(cell: Path, motion: Path | None = None, json: Path | None = None, xacro_arg: tuple[str, ...] = ()) -> int:
    """What is wrong, assumed, or out of reach in a cell and a motion, all at once, without a compiler."""
    found = _found(cell, motion, options.xacro_arguments(xacro_arg))
    outputs = Outputs()
    outputs.write(json, found.write_json)
    code = outputs.answer(found.lines(), CODES[found.status], json, found)
    if found.status == "wrong-input" and (json is not None or QUIET.get()):
        place = "" if json is None else f" (all of it: {json})"
        fail(f"error: {found.outcome()}{place}")
    return code


def _found(cell: Path, motion: Path | None, xacro_args: dict[str, str]) -> "CellCheck":
    from mrts.starting.cell_check import is_urdf
    from mrts.starting.check import check
    from mrts.starting.urdf_check import check_urdf

    if is_urdf(cell):
        if motion is not None:
            raise InputError("MOTION", "does not go with a URDF, which is checked by itself.", value=str(motion))
        return check_urdf(cell, xacro_args)
    if xacro_args:
        raise InputError("xacro_arg", "a cell file gives its own: 'xacro_args' of each robot.")
    with working(f"checking {cell}") as progress:
        return check(cell, motion, progress=progress)
