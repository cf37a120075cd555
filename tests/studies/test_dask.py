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
from mrts.studies.variant_rows import solve_variants

STUDY = """
vary: {object.mass: {from: 1, to: 30}, "robots.left.base.xyz[0]": {from: -1.5, to: 0.5}}
torques: true
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

    def kill_one(progress):
        done.append(progress.done)
        if len(done) == 3:
            kill(workers(session)[0])

    table = mrts.sweep(study, out, scheduler=address, progress=kill_one)
    assert_same_table(table, alone)
    assert len(parts(out)) == 8
    assert done[-1] == study.variants


@pytest.mark.slow
def test_a_scheduler_that_goes_away_is_said_and_the_study_gone_on_with(study, alone, tmp_path):
    with started(SCHEDULER) as scheduler:
        address = address_of(scheduler)
        with started([*WORKER, address, "--nthreads", "1", "--local-directory", str(tmp_path)]):

            def kill_scheduler(progress):
                if progress.done:
                    kill(scheduler.pid)

            with pytest.raises(mrts.InputError, match=r"scheduler = 'tcp://.*': is gone"):
                mrts.sweep(study, tmp_path / "out", scheduler=address, progress=kill_scheduler)
    assert 0 < len(parts(tmp_path / "out")) < mrts.read_study_folder(tmp_path / "out").chunks
    assert_same_table(mrts.sweep(study, tmp_path / "out", workers=1), alone)


@pytest.mark.slow
def test_a_worker_of_another_version_is_refused(cluster, study, monkeypatch):
    monkeypatch.setattr("mrts.studies.chunks.__version__", "0.0.9")
    with pytest.raises(mrts.InputError, match=r"worker: runs mrts .*, the sweep 0\.0\.9: install the same"):
        mrts.sweep(study, scheduler=cluster[0])
