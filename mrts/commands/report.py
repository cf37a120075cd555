# SPDX-License-Identifier: MIT
"""`mrts report`."""

import argparse
from pathlib import Path

from mrts.base.errors import InputError
from mrts.base.regular_file import is_folder
from mrts.commands.options.common import require
from mrts.console.exit_codes import FEASIBLE, INFEASIBLE
from mrts.console.output_files import check_outputs
from mrts.console.terminal import say

EXAMPLES = """\
examples:
  mrts report result.npz -o report.html
  mrts report found -o report.html                          of what mrts sweep wrote into the folder found
  mrts scale cell.yaml motion.yaml --report report.html     without saving the result"""


def add(report: argparse.ArgumentParser) -> None:
    """Add the arguments of the verb."""
    report.add_argument("result", type=Path, metavar="RESULT", help="saved result (.npz), or the folder of a study")
    report.add_argument("-o", "--output", type=Path, default=Path("report.html"), metavar="FILE",
                        help="HTML file to write (default: %(default)s)")  # fmt: skip
    report.set_defaults(run=run)


def run(options: argparse.Namespace) -> int:
    """Write the report."""
    require("plotly", "mrts report", "report", wanted=True)
    from mrts.output.saved_result import load_result
    from mrts.report import write_report

    if options.output.suffix not in {".html", ".htm"}:
        raise InputError("--output", "writes a file that ends in .html.", value=str(options.output))
    check_outputs({"--output": options.output}, {})
    if is_folder(options.result):
        return _report_study(options.result, options.output)
    result = load_result(options.result)
    write_report(result, options.output)
    say(f"{result.cell.name}: {result.status.value}; the report is {options.output}")
    return FEASIBLE if result.status.admits_motion else INFEASIBLE


def _report_study(folder: Path, output: Path) -> int:
    """Write the report of what a sweep has found so far."""
    from mrts.plots.study_table import read_study_table
    from mrts.plots.study_words import outcome_text
    from mrts.report import write_study_report

    found = read_study_table(folder)
    write_study_report(found, output)
    say(f"{found.name}: {outcome_text(found)}; the report is {output}")
    return FEASIBLE if found.admitted.any() else INFEASIBLE
