# SPDX-License-Identifier: MIT
"""`mrts check`."""

import argparse
from pathlib import Path

from mrts.console.exit_codes import BAD_INPUT, FEASIBLE, INFEASIBLE
from mrts.console.output_files import Outputs, check_outputs
from mrts.console.progress import working
from mrts.console.terminal import fail, put, say

CODES = {"fine": FEASIBLE, "impossible": INFEASIBLE, "wrong-input": BAD_INPUT}
"""Exit code by what came of the check."""

EXAMPLES = """\
examples:
  mrts check cell.yaml
  mrts check cell.yaml motion.yaml
  mrts check cell.yaml motion.yaml -q --json - | jq .hints"""


def add(check: argparse.ArgumentParser) -> None:
    """Add the arguments of the verb."""
    check.add_argument("cell", type=Path, metavar="CELL", help="cell file")
    check.add_argument("motion", type=Path, metavar="MOTION", nargs="?",
                       help="motion file, CSV table, or ROS 2 bag with joint trajectories")  # fmt: skip
    check.add_argument("--json", type=Path, metavar="FILE", help="write all of it ('-' is standard output)")
    check.set_defaults(run=run)


def run(options: argparse.Namespace) -> int:
    """Check a cell and a motion."""
    from mrts.diagnosis.check import check

    check_outputs({"--json": options.json}, {})
    with working(f"checking {options.cell}") as progress:
        found = check(options.cell, options.motion, progress=progress)
    outputs = Outputs()
    if options.json is not None and str(options.json) != "-":
        with outputs.attempt(options.json):
            found.write_json(options.json)
    if str(options.json) == "-":
        put(found.json_text())
    else:
        outcome, *details = found.lines()
        say(outcome, "strong" if found.status == "fine" else "bad")
        for line in details:
            say(line, "note" if line.startswith(("hint:", "warning:")) else "plain")
        for line in outputs.lines():
            say(line)
    if found.status == "wrong-input" and (options.json is not None or options.quiet):
        place = "" if options.json is None else f" (all of it: {options.json})"
        fail(f"error: {found.outcome()}{place}")
    return outputs.code(CODES[found.status])
