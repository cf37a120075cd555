# SPDX-License-Identifier: MIT
"""`mrts report`."""

from pathlib import Path
from typing import TYPE_CHECKING

from click import argument, option

from mrts.base.errors import InputError
from mrts.base.regular_file import is_folder
from mrts.commands import options
from mrts.commands.console import FEASIBLE, INFEASIBLE, say
from mrts.commands.options import HTML, Named

if TYPE_CHECKING:
    from mrts.program.rate_limits import Rates


@options.command
@argument("result", type=Named(".npz"), metavar="RESULT", help="saved result (.npz), or the folder of a study")
@option("-o", "--output", type=HTML, default="report.html", show_default=True, metavar="FILE", help="page to write")
@option(
    "--cell", type=Named(), metavar="CELL", help="its cell file: draw how soon and how far on a speed override stops"
)
@options.rates
def run(result: Path, output: Path, cell: Path | None = None, rates: "Rates | None" = None) -> int:
    """Write a saved result or a study as an HTML page that opens offline.

    Examples:
        mrts report result.npz -o report.html
        mrts report result.npz --cell cell.yaml                   with what stops on the path take
        mrts report found -o report.html                          of what mrts sweep wrote into the folder found
        mrts scale cell.yaml motion.yaml --report report.html     without saving the result
    """
    from mrts.control.speed_override import SpeedOverride
    from mrts.output.report_page import write_report
    from mrts.output.saved_result import load_result

    if rates is not None and cell is None:
        raise InputError("rates", "are those of stops, which take --cell.", value=rates)
    if is_folder(result):
        if cell is not None:
            raise InputError("cell", "goes with a saved result, not with a study.", value=str(cell))
        return _report_study(result, output)
    found = load_result(result) if cell is None else options.result_of_cell(options.compiled_cell(cell), result)
    write_report(found, output, None if cell is None else SpeedOverride(found, rates=rates).stops())
    say(f"{found.cell.name}: {found.status.value}; the report is {output}")
    return FEASIBLE if found.status.admits_motion else INFEASIBLE


def _report_study(folder: Path, output: Path) -> int:
    from mrts.output.report_page import write_report
    from mrts.plots.study_plots import outcome_text, read_study_table

    found = read_study_table(folder)
    write_report(found, output)
    say(f"{found.name}: {outcome_text(found)}; the report is {output}")
    return FEASIBLE if found.admitted.any() else INFEASIBLE
