"""Sweeps in processes of their own, to be killed: the driver, its workers, a Dask scheduler."""

import os
import signal
import subprocess
import sys
import time
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pyarrow as pa
from conftest import ROOT

PATIENCE = 90.0
"""For anything to happen on a busy machine [s]."""

DRIVER = """
import sys
import mrts.studies.sweep
mrts.studies.sweep.chunk_size = lambda study: 2
from mrts.cli import main
sys.exit(main(sys.argv[1:]))
"""


def driver_command(*arguments):
    """Words of `mrts sweep` with chunks of a few variants, so that a short study has many."""
    return [sys.executable, "-c", DRIVER, "sweep", *map(str, arguments)]


@contextmanager
def started(command, **options):
    """A process in a session of its own; whatever is left of it ends with the block."""
    with subprocess.Popen(
        command, start_new_session=True, stderr=subprocess.PIPE, text=True, cwd=ROOT, **options
    ) as process:
        try:
            yield process
        finally:
            process.kill()


def until(condition):
    """Wait until something is true, and return it."""
    end = time.monotonic() + PATIENCE
    while not (found := condition()):
        assert time.monotonic() < end
        time.sleep(0.02)
    return found


def processes(session):
    """Numbers of the processes of a session that run, with the words that they were started by."""
    found = {}
    for folder in Path("/proc").glob("[0-9]*"):
        try:
            state, _, _, of_session = (folder / "stat").read_text().rpartition(")")[2].split()[:4]
            words = (folder / "cmdline").read_text().split("\0")
        except OSError:  # gone meanwhile
            continue
        if int(of_session) == session and state != "Z":
            found[int(folder.name)] = words
    return found


def workers(session):
    """Numbers of a driver's processes that solve chunks: those of loky, or of a LocalCluster's nannies."""
    kinds = ("popen_loky_posix", "multiprocessing.spawn")
    return [number for number, words in processes(session).items() if any(kind in " ".join(words) for kind in kinds)]


def kill(number):
    """As `kill -9`, and as the system does where memory runs out."""
    os.kill(number, signal.SIGKILL)


def parts(folder):
    """Names of the parts that are there."""
    return sorted(path.name for path in folder.glob("rows/part-*.parquet"))


def assert_same_table(found, alone):
    """Every variant of a sweep is there once, in order, with the bits that `solve_variants` gives for all at once."""
    assert found.column_names == list(alone)
    for name, values in alone.items():
        column = found[name]
        if pa.types.is_string(column.type):
            assert column.to_pylist() == values, name
        else:
            numbers = np.array([np.nan if each is None else each for each in values], dtype=float)
            np.testing.assert_array_equal(np.asarray(column.to_numpy(), dtype=float), numbers, err_msg=name)
