# SPDX-License-Identifier: MIT
"""`mrts sweep`."""

from collections import Counter
from contextlib import suppress
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from click import IntRange, argument, option

from mrts.base.errors import InputError
from mrts.commands import options
from mrts.commands.console import FEASIBLE, INFEASIBLE, Outputs, warn, working
from mrts.commands.options import Named, Written

if TYPE_CHECKING:
    from mrts.studies.study import Study
    from mrts.studies.study_folder import StudyFolder


@options.command
@argument("study", type=Named(), metavar="STUDY", help="study file")
@option("-o", "--output", type=Written(folder=True), required=True, metavar="DIR",
        help="folder for the table (Parquet): a new one, or one in which this study goes on")  # fmt: skip
@option("--workers", type=int, metavar="N", help="processes on this machine (default: one a core)")
@option("--scheduler", metavar="tcp://HOST:PORT",
        help="workers of this Dask scheduler (needs the extra 'cluster')")  # fmt: skip
@option("--top", type=IntRange(0), default=0, metavar="K",
        help="write the best K as cell and motion files into DIR")  # fmt: skip
@options.plot("figures")
def run(
    study: Path,
    output: Path,
    workers: int | None = None,
    scheduler: str | None = None,
    top: int = 0,
    plot: Path | None = None,
) -> int:
    """Solve all variants of a study: numbers of cell and motion that vary.

    Examples:
        mrts sweep study.yaml -o found --top 3 --plot plots
        mrts sweep study.yaml -o found --scheduler tcp://10.0.0.1:8786
    """
    from mrts.studies.study import read_study
    from mrts.studies.sweep import best_variants

    with working(f"reading {study}"):
        asked = read_study(study)
    folder = _solved(asked, output, workers, scheduler)
    outputs, best = Outputs(), best_variants(folder, max(top, 1))
    for rank, variant in enumerate([*best][:top], start=1):
        outputs.write(output / f"best-{rank}", partial(asked.write_variant, variant))
    counts = Counter(folder.table(["status"])["status"].to_pylist())
    told = ", ".join(f"{count} {status}" for status, count in counts.most_common())
    answer = [f"{study.name}: {asked.variants} variants: {told}"]
    answer += [f"best: variant {variant}, {duration:.4g} s" for variant, duration in [*best.items()][:1]]
    if plot is not None:
        from mrts.plots import durations_plot, numbers_plot, read_study_table, write_plots

        table = read_study_table(folder.path)
        outputs.write(plot, lambda to: write_plots([durations_plot(table), numbers_plot(table)], to))
    return outputs.answer(answer, FEASIBLE if counts["feasible"] + counts["unbounded"] else INFEASIBLE)


def _solved(study: "Study", output: Path, workers: int | None, scheduler: str | None) -> "StudyFolder":
    """The folder of a study, complete; where the work is interrupted, how to go on is said."""
    from mrts.base.held_interrupt import held_interrupt
    from mrts.studies.study_folder import read_study_folder
    from mrts.studies.sweep import solve_study

    try:
        with working(f"sweeping {study.path.name}") as progress:
            return solve_study(study, output, workers, scheduler, progress)
    except KeyboardInterrupt:
        with held_interrupt(), suppress(InputError):  # an interrupt comes again until it is obeyed
            done = read_study_folder(output).dataset().count_rows()
            warn(f"{output} holds {done} of {study.variants} variants: the same command goes on from there")
        raise
