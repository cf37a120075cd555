# SPDX-License-Identifier: MIT
"""`mrts place`."""

import argparse
from pathlib import Path

from mrts.base.errors import InputError
from mrts.commands.options.common import add_between, between_option
from mrts.console.exit_codes import FEASIBLE, INFEASIBLE
from mrts.console.output_files import Outputs, check_outputs
from mrts.console.progress import working
from mrts.console.terminal import say, warn

EXAMPLES = """\
examples:
  mrts place study.yaml -o best.yaml
  mrts place study.yaml -o best.yaml --starts 10 --seconds 60"""


def add(verb: argparse.ArgumentParser) -> None:
    """Add the arguments of the verb."""
    verb.add_argument("study", type=Path, metavar="STUDY",
                      help="study file; 'vary' names numbers of base, grasp or posture, each from and to")  # fmt: skip
    verb.add_argument("-o", "--output", type=Path, required=True, metavar="FILE",
                      help="the cell file of the best layout; Ctrl-C writes the best so far")  # fmt: skip
    verb.add_argument("--starts", type=int, metavar="N",
                      help="from how many layouts to search for the nearest best one (default: 3)")  # fmt: skip
    verb.add_argument("--look", type=int, metavar="N",
                      help="of how many layouts the starts are the best (default: 64)")  # fmt: skip
    verb.add_argument("--seconds", type=float, metavar="S", help="end the search after so long (default: no limit)")
    add_between(verb)
    verb.set_defaults(run=run)


def run(options: argparse.Namespace) -> int:
    """Search the best layout."""
    from mrts.layout.place import LOOKED_AT, STARTS, place
    from mrts.studies.study_file import read_study

    check_outputs({"--output": options.output})
    between = between_option(options.between)
    with working(f"reading {options.study}"):
        study = read_study(options.study)
    with working(f"placing {study.cell['name']}") as progress:
        try:
            found = place(
                study,
                starts=STARTS if options.starts is None else options.starts,
                looked_at=LOOKED_AT if options.look is None else options.look,
                seconds=options.seconds,
                between=between,
                progress=progress,
            )
        except InputError as error:
            option = {"starts": "--starts", "looked_at": "--look", "seconds": "--seconds"}.get(error.where)
            if option is None:
                raise
            raise InputError(option, error.rule, value=error.value) from None
    outputs = Outputs()
    if found.after is None:
        warn(f"no layout can be played: {options.output} not written")
    else:
        with outputs.attempt(options.output):
            found.write(options.output)
    outcome, *lines = found.lines()
    say(outcome, "strong" if found.after is not None else "bad")
    for line in (*lines, *outputs.lines()):
        say(line)
    return outputs.code(INFEASIBLE if found.after is None else FEASIBLE)
