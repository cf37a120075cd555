"""Cells, motions and results pass between processes and copy: equal results, libraries of their own."""

import copy
import os
import pickle
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context

import pytest
from same_cells import same_cell

import mrts


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


@pytest.mark.parametrize("again", [copy.deepcopy, lambda thing: pickle.loads(pickle.dumps(thing))])  # noqa: S301
def test_what_a_user_holds_comes_back_as_it_was(planar_cell, lift, lifted, again):
    moved = planar_cell.with_values({"robots.left.base.xyz": [0.01, 0.02, 0], "gravity": [0, -1.6, 0]})
    other = again(moved)
    assert same_cell(other, moved)
    assert mrts.scale(other, lift).json_text() == mrts.scale(moved, lift).json_text()
    assert not other.robots[0].torque_upper.flags.writeable
    infeasible = mrts.scale(planar_cell.with_mass(24.0), lift)
    uncertain = mrts.scale(planar_cell.with_variation(mass=(0.2, 6.0)), lift)
    for result in (lifted, infeasible, uncertain, mrts.retime(planar_cell, lift)):
        assert again(result).json_text() == result.json_text()
    assert again(lifted).residuals() == lifted.residuals()
