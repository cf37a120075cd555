"""A study solved by processes of this machine or a Dask cluster: the same table whoever solves it, whatever ends."""

import os
import shutil
import signal
import sys
import time
from contextlib import ExitStack

import numpy as np
import pytest
from conftest import DATA
from faulty_study import faulty
from own_limits import tenth
from study_files import planar_study
from sweep_processes import assert_same_table, driver_command, kill, parts, processes, started, until, workers

import mrts
import mrts.studies.sweep as engine
from mrts.studies.variants import solve_variants

STUDY = """
vary: {object.mass: {from: 1, to: 30}, "robots.left.base.xyz[0]": {from: -1.5, to: 0.5}}
between: 0.001
sample: sobol
count: 24
"""
CHUNK = 2

SEED = 17


@pytest.fixture(scope="module")
def study(tmp_path_factory):
    """Some variants are infeasible, some out of reach."""
    return planar_study(tmp_path_factory.mktemp("study"), STUDY)


@pytest.fixture(scope="module")
def alone(study):
    """The table without chunks, workers and files."""
    return solve_variants(study, 0, study.variants)


@pytest.fixture(autouse=True)
def many_chunks(monkeypatch):
    monkeypatch.setattr(engine, "chunk_size", lambda _study: CHUNK)


@pytest.fixture(scope="module")
def solved(study, tmp_path_factory):
    """The folder of the study, solved by two workers, and what was told meanwhile."""
    out, told = tmp_path_factory.mktemp("solved") / "out", []
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(engine, "chunk_size", lambda _study: CHUNK)
        mrts.sweep(study, out, workers=2, progress=lambda *progress: told.append(progress))
    return out, told


@pytest.fixture
def out(solved, tmp_path):
    """A copy of it."""
    return shutil.copytree(solved[0], tmp_path / "out")


@pytest.mark.quick
def test_two_workers_give_the_table_that_none_gives(solved, alone):
    out, told = solved
    table = mrts.read_study_folder(out).table()
    assert_same_table(table, alone)
    assert len(parts(out)) == 12
    assert set(table["status"].to_pylist()) == {"feasible", "infeasible", "unreachable"}
    assert told == [(done, 24) for done in range(0, 25, CHUNK)]


def test_a_complete_study_is_read_not_solved(out, study, alone):
    before = {path: path.stat().st_mtime_ns for path in out.glob("rows/*")}
    assert len(before) == 12
    assert_same_table(mrts.sweep(str(study.path), str(out), workers=1), alone)
    assert {path: path.stat().st_mtime_ns for path in out.glob("rows/*")} == before


def test_a_driver_that_is_ended_at_any_moment_loses_nothing(tmp_path):
    """By kill -9, by Ctrl-C, by a queue's SIGTERM; its workers end with it. More is left than is solved meanwhile."""
    study = planar_study(tmp_path, STUDY.replace("count: 24", "count: 240"))
    out, delay = tmp_path / "out", np.random.default_rng(SEED)
    for number in (signal.SIGKILL, signal.SIGINT, signal.SIGTERM):
        with started(driver_command(study.path, "-o", out, "--workers", 2)) as driver:
            before = len(parts(out)) if out.exists() else 0
            until(lambda before=before: out.exists() and len(parts(out)) > before)
            time.sleep(delay.uniform(0, 0.1))
            os.kill(driver.pid, number)
            _, said = driver.communicate()
            if number is not signal.SIGKILL:
                assert driver.returncode == 128 + number
                assert "of 240 variants: the same command goes on from there" in said
            until(lambda driver=driver: not processes(driver.pid))
    assert len(parts(out)) < mrts.read_study_folder(out).chunks
    (out / "rows" / ".part-00000000.half.parquet").write_bytes(b"PAR1")
    assert_same_table(mrts.sweep(study, out, workers=2), solve_variants(study, 0, study.variants))
    assert not list(out.rglob(".part*"))


def test_a_variant_that_no_worker_survives_is_a_row_and_costs_no_other(alone, tmp_path):
    """Killed, as where memory runs out, or stumbling over a defect."""
    small = faulty(planar_study(tmp_path, STUDY), deadly=(5,), stumbling=(20, 21))
    table = mrts.sweep(small, workers=2)
    failed = {5: "the process that solved it ended each time", 20: "ZeroDivisionError: 1 / 0", 21: "ZeroDivisionError"}
    for variant, reason in failed.items():
        row = table.slice(variant, 1).to_pylist()[0]
        assert (row["variant"], row["status"], row["c2_upper"], row["duration"]) == (variant, "failed", None, None)
        assert row["object.mass"] == alone["object.mass"][variant]
        assert reason in row["reason"]
    others = [variant for variant in range(24) if variant not in failed]
    columns = {name: [values[k] for k in others] for name, values in alone.items()}
    assert_same_table(table.take(others), columns)


def test_a_limit_given_in_python_is_kept_by_workers_or_refused(tmp_path):
    own = planar_study(tmp_path, "vary: {object.mass: [0.4, 0.5]}")
    assert mrts.sweep(own, workers=1)["status"].to_pylist() == ["feasible", "feasible"]
    assert own.with_limits(tenth) != own
    assert mrts.sweep(own.with_limits(tenth), workers=1)["status"].to_pylist() == ["infeasible", "infeasible"]
    with pytest.raises(mrts.InputError, match="study: limits: must be functions of a module that workers can import"):
        mrts.sweep(own.with_limits(lambda _cell, _motion: None), workers=1)


LOCALLY = ("--host", "127.0.0.1", "--port", "0", "--no-dashboard", "--no-show")
SCHEDULER = [sys.executable, "-m", "distributed.cli.dask_scheduler", *LOCALLY]
WORKER = [sys.executable, "-m", "distributed.cli.dask_worker", "--no-dashboard"]


@pytest.fixture(scope="module")
def cluster(tmp_path_factory):
    """Address of a scheduler with a worker of two threads, whose cache is its own; and the worker's session."""
    folder = tmp_path_factory.mktemp("cluster")
    with ExitStack() as stack:
        told = stack.enter_context(started(SCHEDULER)).stderr
        address = until(lambda: next((word for word in told.readline().split() if "tcp://" in word), None))
        environment = os.environ | {"MRTS_CACHE_DIR": str(folder)}
        command = [*WORKER, address, "--nthreads", "2", "--local-directory", str(folder)]
        session = stack.enter_context(started(command, env=environment)).pid
        until(lambda: workers(session))
        yield address, session


@pytest.mark.quick
def test_a_cluster_gives_the_same_bits_though_a_worker_is_killed(cluster, alone, tmp_path):
    """The study's cell file and URDF are gone once it is read, as on another machine."""
    for name in ("cell.yaml", "planar_arm.urdf"):
        shutil.copy(DATA / name, tmp_path)
    study = planar_study(tmp_path, STUDY, cell=tmp_path / "cell.yaml")
    (tmp_path / "cell.yaml").unlink()
    (tmp_path / "planar_arm.urdf").unlink()
    (address, session), out, done = cluster, tmp_path / "out", []

    def kill_one(solved, _variants):
        done.append(solved)
        if len(done) == 3:
            kill(workers(session)[0])

    table = mrts.sweep(study, out, scheduler=address, progress=kill_one)
    assert_same_table(table, alone)
    assert len(parts(out)) == 12
    assert done[-1] == study.variants
