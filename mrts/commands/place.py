# SPDX-License-Identifier: MIT
"""`mrts place`."""

from pathlib import Path
from typing import Any

from click import argument, option

from mrts.commands import options
from mrts.commands.console import FEASIBLE, INFEASIBLE, Outputs, check_not_read, warn, working
from mrts.commands.options import Named, Written


@options.command
@argument("study", type=Named(), metavar="STUDY",
          help="study file with 'sample: sobol'; 'vary' gives numbers of base, grasp, posture from and to")  # fmt: skip
@option("-o", "--output", type=Written(), required=True, metavar="FILE",
        help="the cell file of the best layout; Ctrl-C writes the best so far")  # fmt: skip
@option("--starts", type=int, metavar="N", help="from how many layouts to search for the nearest best one (default: 3)")
@option("--look", "looked_at", type=int, metavar="N", help="of how many layouts the starts are the best (default: 64)")
@options.between
def run(study: Path, output: Path, **given: Any) -> int:
    """Where to put the arms and how to hold the object: the layout that may be played fastest.

    Examples:
        mrts place study.yaml -o best.yaml
        mrts place study.yaml -o best.yaml --starts 10 --look 200
    """
    from mrts.studies.place import place
    from mrts.studies.study import read_study

    with working(f"reading {study}"):
        asked = read_study(study)
    check_not_read(output)
    with working(f"placing {asked.cell['name']}") as progress:
        found = place(asked, **given, progress=progress)
    outputs = Outputs()
    if found.after is None:
        warn(f"no layout can be played: {output} not written")
    else:
        outputs.write(output, found.write)
    if found.interrupted:
        warn("Ctrl-C ended the search: a longer one may find a better layout")
    return outputs.answer(found.lines(), INFEASIBLE if found.after is None else FEASIBLE)
