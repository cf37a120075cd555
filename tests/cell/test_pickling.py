"""Cells, motions and results pass between processes and copy: equal results, libraries of their own."""

import copy
import os
import pickle
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context

import numpy as np
import pytest

import mrts


def through_pickle(thing):
    return pickle.loads(pickle.dumps(thing))  # noqa: S301 (our own bytes)


def c2_of(cell, motion):
    """What a worker does."""
    result = mrts.scale(cell, motion)
    return result.json_text(), os.environ["MRTS_CACHE_DIR"]


def use_cache(folder):
    os.environ["MRTS_CACHE_DIR"] = folder


def pool(initializer, *arguments):
    return ProcessPoolExecutor(1, get_context("spawn"), initializer, arguments)


@pytest.mark.quick
def test_a_worker_with_an_empty_cache_finds_the_same(planar_cell, lift, lifted, tmp_path):
    """As on another machine: neither the cell file nor the cache is there, the C travels."""
    heavier = planar_cell.with_mass(4.0)
    with pool(use_cache, str(tmp_path)) as workers:
        results = list(workers.map(c2_of, [planar_cell, heavier], [lift, lifted.motion]))
    assert {folder for *_, folder in results} == {str(tmp_path)}
    assert [text for text, *_ in results] == [lifted.json_text(), mrts.scale(heavier, lift).json_text()]
    assert len(list(tmp_path.glob("lib/*/cell.so"))) == 1  # compiled once, bound twice


@pytest.fixture(scope="module")
def everything(planar_cell, lift, lifted, tmp_path_factory):
    """Every kind of thing that a user holds."""
    folder = tmp_path_factory.mktemp("everything")
    table = folder / "trajectory.csv"
    names = [f"q.{robot.name}/{joint}" for robot in planar_cell.robots for joint in robot.joints]
    rows = [",".join(["t", *names]), *(",".join(map(repr, map(float, row))) for row in
            np.column_stack([lift.time, lifted.motion.q]))]  # fmt: skip
    table.write_text("\n".join(rows))
    mrts.save_result(lifted, folder / "result.npz")
    study = mrts.scale(planar_cell.with_variation(mass=(0.2, 6.0)), lift)
    return {
        "cell": planar_cell,
        "moved cell": planar_cell.with_values({
            "robots.left.base.xyz": [0.01, 0.02, 0], "robots.right.grasp.rpy": [0, 0, 3.1], "gravity": [0, -1.6, 0],
            "robots.left.torque": [80.0, 70.0, 40.0],
        }),
        "joint table": mrts.load_motion(table),
        "result": lifted,
        "uncertain": study,
        "infeasible": mrts.scale(planar_cell.with_mass(24.0), lift),
        "loaded": mrts.load_result(folder / "result.npz"),
        "retimed": mrts.retime(planar_cell, lift),
        "configurations": mrts.rank_configurations(planar_cell, lift),
    }  # fmt: skip


def same(ours, theirs, where):
    """Whether two values agree in every field, however deep."""
    assert type(ours) is type(theirs), where
    if isinstance(ours, np.ndarray):
        np.testing.assert_array_equal(ours, theirs, err_msg=where)
    elif isinstance(ours, dict):
        assert ours.keys() == theirs.keys(), where
        for key, value in ours.items():
            same(value, theirs[key], f"{where}[{key}]")
    elif isinstance(ours, list | tuple):
        assert len(ours) == len(theirs), where
        for index, value in enumerate(ours):
            same(value, theirs[index], f"{where}[{index}]")
    elif hasattr(ours, "__dataclass_fields__"):
        for name in ours.__dataclass_fields__:
            if hasattr(ours, name):
                same(getattr(ours, name), getattr(theirs, name), f"{where}.{name}")
    elif isinstance(ours, str | int | float | bool | type(None)):
        assert ours == theirs, where


@pytest.mark.parametrize("again", [copy.deepcopy, through_pickle])
def test_everything_comes_back_as_it_was(everything, lift, lifted, again):
    for name, thing in everything.items():
        other = again(thing)
        assert other is not thing, name
        same(thing, other, name)
        assert repr(other) == repr(thing), name
        if hasattr(thing, "json_text"):
            assert other.json_text() == thing.json_text(), name
        if isinstance(thing, mrts.Cell):
            assert mrts.scale(other, lift).json_text() == mrts.scale(thing, lift).json_text(), name
            assert not other.robots[0].torque_upper.flags.writeable
    assert again(lifted).residuals() == lifted.residuals()
