# SPDX-License-Identifier: MIT
"""`mrts sweep`."""

import argparse
from collections import Counter
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING

from mrts.base.errors import InputError
from mrts.commands.options.common import add_plot, plot_form, require
from mrts.console.exit_codes import FEASIBLE, INFEASIBLE
from mrts.console.output_files import Outputs, check_outputs
from mrts.console.progress import working
from mrts.console.terminal import say, warn

if TYPE_CHECKING:
    from mrts.studies.study import Study
    from mrts.studies.study_folder import StudyFolder
    from mrts.sweeps.sweep_progress import SweepProgress, Tally

EXAMPLES = """\
examples:
  mrts sweep study.yaml --dry-run
  mrts sweep study.yaml -o found --top 3 --plot plots
  mrts sweep study.yaml -o found --scheduler tcp://10.0.0.1:8786"""


def add(verb: argparse.ArgumentParser) -> None:
    """Add the arguments of the verb."""
    verb.add_argument("study", type=Path, metavar="STUDY", help="study file")
    verb.add_argument("-o", "--output", type=Path, metavar="DIR",
                      help="folder for the table (Parquet): a new one, or one in which this study goes on")  # fmt: skip
    verb.add_argument("--workers", type=int, metavar="N", help="processes on this machine (default: one a core)")
    verb.add_argument("--scheduler", metavar="local|tcp://HOST:PORT",
                      help="workers of this Dask scheduler, or of a Dask cluster made on this machine (needs the "
                      "extra 'cluster')")  # fmt: skip
    verb.add_argument("--top", type=int, default=0, metavar="K",
                      help="solve the best K again with limits kept between the samples, print them, and write them as "
                      "cell and motion files into DIR")  # fmt: skip
    add_plot(verb, "figures")
    verb.add_argument("--dry-run", action="store_true",
                      help="say what the study varies and asks, and how long it will take")  # fmt: skip
    verb.set_defaults(run=run)


def run(options: argparse.Namespace) -> int:
    """Solve a study."""
    from mrts.studies.study_file import read_study
    from mrts.studies.study_folder import require_pyarrow
    from mrts.sweeps.worker_pools import check_workers

    options.plot_format = plot_form(options)
    require("joblib", "mrts sweep", "study", wanted=options.scheduler is None)
    try:
        check_workers(options.workers, options.scheduler)
    except InputError as error:
        raise InputError(f"--{error.where}", error.rule, value=error.value) from None
    if options.top < 0:
        raise InputError("--top", "must be at least 0.", value=options.top)
    if options.output is None and not options.dry_run:
        raise InputError("--output", "is missing: name a folder for the table, or ask for --dry-run.")
    check_outputs({}, {"--output": options.output, "--plot": options.plot})
    require_pyarrow()
    with working(f"reading {options.study}"):
        study = read_study(options.study)
    if options.dry_run:
        return _estimated(study, options.workers)
    folder, tally = _solved(study, options)
    return _answered(study, folder, tally, options)


def _estimated(study: "Study", workers: int | None) -> int:
    from joblib import cpu_count

    from mrts.studies.dry_run import estimate

    with working("trying a few variants"):
        found = estimate(study)
    for line in found.lines(workers or cpu_count()):
        say(line)
    return FEASIBLE


def _solved(study: "Study", options: argparse.Namespace) -> "tuple[StudyFolder, Tally]":
    """The folder of a study, complete; where the work is interrupted, how to go on is said."""
    from mrts.program.held_interrupt import held_interrupt
    from mrts.studies.study_folder import read_study_folder
    from mrts.sweeps.sweep import solve_study

    try:
        with working(f"sweeping {study.path.name}") as show:

            def tell(progress: "SweepProgress") -> None:
                show(progress.done, progress.variants, str(progress))

            return solve_study(study, options.output, options.workers, options.scheduler, tell)
    except KeyboardInterrupt:
        with held_interrupt(), suppress(InputError):  # an interrupt comes again until it is obeyed
            done = read_study_folder(options.output).dataset().count_rows()
            warn(f"{options.output} holds {done} of {study.variants} variants: the same command goes on from there")
        raise


def _answered(study: "Study", folder: "StudyFolder", tally: "Tally", options: argparse.Namespace) -> int:
    """Print what was found, and write what was asked for."""
    from mrts.sweeps.best_variants import best_lines, write_best

    outputs = Outputs()
    admitted = tally.statuses["feasible"] + tally.statuses["unbounded"]
    counts = ", ".join(f"{count} {status}" for status, count in Counter(tally.statuses).most_common())
    say(f"{study.path.name}: {study.variants} variants: {counts}", "strong" if admitted else "bad")
    found = tally.progress()
    if found.best is not None:
        say(f"best: variant {found.best_variant}, {found.best:.4g} s")
    if options.top and admitted:
        with outputs.attempt(folder.path):
            with working("solving the best again"):
                best = write_best(study, folder, options.top)
            for line in best_lines(best, folder.path):
                say(line)
    if options.plot is not None:
        with outputs.attempt(options.plot):
            from mrts.plots import write_study_plots

            write_study_plots(folder.path, options.plot, options.plot_format)
    for line in outputs.lines():
        say(line)
    return outputs.code(FEASIBLE if admitted else INFEASIBLE)
