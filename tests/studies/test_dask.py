"""A study solved by a Dask cluster: real schedulers and workers in processes of their own."""

import os
import shutil
import sys
from contextlib import ExitStack

import pytest
from conftest import DATA
from study_files import planar_study
from sweep_processes import assert_same_table, kill, parts, started, until, workers

import mrts
import mrts.studies.sweep as engine
from mrts.studies.variants import solve_variants

STUDY = """
vary: {object.mass: {from: 1, to: 30}, "robots.left.base.xyz[0]": {from: -1.5, to: 0.5}}
between: 0.001
sample: sobol
count: 24
"""
"""Solved one by one, which takes a while."""

LOCALLY = ("--host", "127.0.0.1", "--port", "0", "--no-dashboard", "--no-show")
SCHEDULER = [sys.executable, "-m", "distributed.cli.dask_scheduler", *LOCALLY]
WORKER = [sys.executable, "-m", "distributed.cli.dask_worker", "--no-dashboard"]


def address_of(scheduler):
    """Where a scheduler that has been started says that it is."""
    return until(lambda: next((word for word in scheduler.stderr.readline().split() if "tcp://" in word), None))


@pytest.fixture(scope="module")
def study(tmp_path_factory):
    """Its cell file and URDF are gone once it is read, as on another machine."""
    folder = tmp_path_factory.mktemp("study")
    for name in ("cell.yaml", "planar_arm.urdf"):
        shutil.copy(DATA / name, folder)
    study = planar_study(folder, STUDY, cell=folder / "cell.yaml")
    shutil.rmtree(folder)
    return study


@pytest.fixture(scope="module")
def alone(study):
    return solve_variants(study, 0, study.variants)


@pytest.fixture(autouse=True)
def many_chunks(monkeypatch):
    monkeypatch.setattr(engine, "chunk_size", lambda _study: 3)


@pytest.fixture(scope="module")
def cluster(tmp_path_factory):
    """Address of a scheduler with a worker of two threads, whose cache is its own; and the worker's session."""
    folder = tmp_path_factory.mktemp("cluster")
    with ExitStack() as stack:
        address = address_of(stack.enter_context(started(SCHEDULER)))
        environment = os.environ | {"MRTS_CACHE_DIR": str(folder)}
        command = [*WORKER, address, "--nthreads", "2", "--local-directory", str(folder)]
        session = stack.enter_context(started(command, env=environment)).pid
        until(lambda: workers(session))
        yield address, session


@pytest.mark.quick
def test_a_cluster_gives_the_same_bits_though_a_worker_is_killed(cluster, study, alone, tmp_path):
    address, session = cluster
    out, done = tmp_path / "out", []

    def kill_one(solved, _variants):
        done.append(solved)
        if len(done) == 3:
            kill(workers(session)[0])

    table = mrts.sweep(study, out, scheduler=address, progress=kill_one)
    assert_same_table(table, alone)
    assert len(parts(out)) == 8
    assert done[-1] == study.variants
