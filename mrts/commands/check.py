# SPDX-License-Identifier: MIT
"""`mrts check`."""

from pathlib import Path
from typing import TYPE_CHECKING

from click import argument, option

from mrts.base.errors import InputError
from mrts.commands import options
from mrts.commands.console import BAD_INPUT, FEASIBLE, INFEASIBLE, QUIET, Outputs, fail, working
from mrts.commands.options import Named

if TYPE_CHECKING:
    from mrts.following.coordinate import ClosureBound

CODES = {"fine": FEASIBLE, "impossible": INFEASIBLE, "wrong-input": BAD_INPUT}
"""Exit code by what came of the check."""


@options.command
@argument("cell", type=Named(), metavar="CELL|PLAN",
          help="cell file; with --cell a plan: a CSV table or a ROS 2 bag")  # fmt: skip
@argument("motion", type=Named(), required=False, metavar="[MOTION]",
          help="motion file, CSV table, or ROS 2 bag with joint trajectories")  # fmt: skip
@option("--cell", "of_cell", type=Named(), metavar="CELL",
        help="the cell that plays the plan: every limit is evaluated at its rows and between them")  # fmt: skip
@options.closure
@options.json
@option("-v", "--verbose", is_flag=True, help="of a plan, print all limits, not those used most")
def run(
    cell: Path,
    motion: Path | None = None,
    of_cell: Path | None = None,
    closure: "ClosureBound | None" = None,
    json: Path | None = None,
    *,
    verbose: bool = False,
) -> int:
    """What is wrong, assumed, or out of reach in a cell and a motion, all at once, without a compiler; or in a plan.

    Examples:
        mrts check cell.yaml
        mrts check cell.yaml motion.yaml
        mrts check cell.yaml motion.yaml -q --json - | jq .hints
        mrts check plan.csv --cell cell.yaml            the last look at a plan, whoever made it, before a robot moves
    """
    if of_cell is not None:
        if motion is not None:
            raise InputError("MOTION", "does not go with --cell, which checks a plan by itself.", value=str(motion))
        return _plan(cell, of_cell, closure, json, verbose=verbose)
    if closure is not None:
        raise InputError("closure", "is of a plan: give --cell too.")
    if cell.suffix.lower() == ".csv":
        raise InputError(cell, "is a table: of a plan, name the cell that plays it by --cell.")
    from mrts.starting.check import check

    with working(f"checking {cell}") as progress:
        found = check(cell, motion, progress=progress)
    code = Outputs(found, json).answer(found.lines(), CODES[found.status])
    if found.status == "wrong-input" and (json is not None or QUIET.get()):
        place = "" if json is None else f" (all of it: {json})"
        fail(f"error: {found.outcome()}{place}")
    return code


def _plan(plan: Path, cell: Path, closure: "ClosureBound | None", json: Path | None, *, verbose: bool) -> int:
    from mrts.starting.plan_check import check_plan

    limited = options.compiled_cell(cell)
    with working(f"checking {plan}"):
        found = check_plan(limited, plan, closure=closure)
    return Outputs(found, json).answer(found.lines(every=verbose), CODES[found.status])
