"""The order of a workbench's answers: coarse ones before whole ones, newer ones before older, all before a ranking.

The work is the real one; where its order matters it waits at a gate for the test, so that no clock decides.
"""

import time
from dataclasses import replace
from threading import Event

import numpy as np
import pytest
from conftest import DATA

import mrts
from mrts.motion.motion_file import described_motion, sample_motion
from mrts.viewer.panel import outcome_html
from mrts.viewer.workbench import workbench
from mrts.viewer.workbench.answer import find_answer
from mrts.viewer.workbench.choices import COARSE_SAMPLES, Choices, Given
from mrts.viewer.workbench.workbench import Workbench

UR5 = DATA.parent / "dual_ur5"
PATIENCE = 60.0
"""[s]"""

SAME = 1e-9
"""Of numbers that were found twice by the same programs."""


@pytest.fixture
def bench(dual_ur5):
    path = UR5 / "lift_and_turn.yaml"
    description = described_motion(path).model_copy(update={"samples": 201})
    opened = Workbench(Given(dual_ur5, sample_motion(description), description))
    yield opened
    opened.close()


class Gate:
    """A place that work does not pass before it is opened."""

    def __init__(self):
        self.reached, self.opened = Event(), Event()

    def wait(self):
        self.reached.set()
        assert self.opened.wait(PATIENCE)


@pytest.fixture
def gates(monkeypatch):
    """Gates of a ranking, by the number of configurations that are done."""
    found = {}

    def ranked(*given, progress, **named):
        def waiting(done, total):
            progress(done, total)
            if done in found:
                found[done].wait()

        return mrts.rank_configurations(*given, progress=waiting, **named)

    monkeypatch.setattr(workbench, "rank_configurations", ranked)
    yield found
    for gate in found.values():
        gate.opened.set()


def answers_of(bench, *, until=lambda _answer: False):
    """All that is taken until there is nothing left to do, or until one that is waited for."""
    end, taken = time.monotonic() + PATIENCE, []
    while True:
        waits = bench.waits
        for one in bench.take():
            taken.append(one)
            if until(one):
                return taken
        if not waits:
            return taken
        assert time.monotonic() < end
        time.sleep(0.001)


def test_a_coarse_answer_comes_first_says_so_and_is_replaced(bench):
    """The whole one is that of `mrts.retime`; the coarse one has fewer samples and keeps limits at these alone."""
    bench.edit(Choices(profile="smooth", mass=9.0))
    coarse, whole = answers_of(bench)
    assert coarse.coarse
    assert not whole.coarse
    assert len(coarse.state.excess) == COARSE_SAMPLES
    assert "Coarse, the whole answer follows" in outcome_html(coarse.state, coarse=coarse.coarse)
    assert "Coarse" not in outcome_html(whole.state, coarse=whole.coarse)
    wanted = mrts.retime(bench.given.cell.with_mass(9.0), bench.given.motion, rates=whole.choices.torque_rate)
    assert whole.state.trajectory.duration == pytest.approx(wanted.duration, rel=SAME)
    assert bench.answer is whole
    bench.ask(0.5)  # of a whole answer, whole at once
    (slower,) = answers_of(bench)
    assert not slower.coarse
    assert slower.state.trajectory.duration == pytest.approx(2 * wanted.duration, rel=SAME)


def test_what_is_newer_ends_work_on_a_whole_answer(bench, monkeypatch):
    masses = np.linspace(8.1, 9.0, 4).tolist()
    begins = {mass: Gate() for mass in masses[:-1]}

    def find(given, choices, *others, coarse):
        if not coarse and choices.mass in begins:
            begins[choices.mass].wait()
        return find_answer(given, choices, *others, coarse=coarse)

    monkeypatch.setattr(workbench, "find_answer", find)
    taken = []
    for before, mass in zip([None, *masses], masses, strict=False):
        bench.edit(Choices(profile="smooth", mass=mass), "mass")
        if before is not None:
            begins[before].opened.set()
        taken += answers_of(bench, until=lambda one: one.coarse)
    taken += answers_of(bench)
    assert [one.choices.mass for one in taken if one.coarse] == masses
    assert [one.choices.mass for one in taken if not one.coarse] == masses[-1:]


def test_answers_come_while_configurations_are_ranked(bench, gates):
    """Nothing of them is lost: the ranking is that of `mrts.rank_configurations`."""
    gates |= {2: Gate(), 4: Gate()}
    bench.rank()
    assert gates[2].reached.wait(PATIENCE)
    before = bench.ranked
    bench.edit(replace(bench.choices, mass=11.0))
    gates[2].opened.set()
    *_, answer = answers_of(bench, until=lambda one: one.choices.mass == 11.0 and not one.coarse)
    during = bench.ranked
    assert before[0] <= during[0] < during[1]
    wanted = mrts.scale(bench.given.cell.with_mass(11.0), bench.given.motion)
    assert answer.state.result.range.upper.c2 == pytest.approx(wanted.range.upper.c2, rel=SAME)
    assert bench.study is None
    gates[4].opened.set()
    answers_of(bench)
    alone = mrts.rank_configurations(bench.given.cell, bench.given.motion)
    assert [one.c2_upper for one in bench.study.ranked] == [one.c2_upper for one in alone.ranked]


def test_a_ranking_can_be_stopped(bench, gates):
    gates[1] = Gate()
    bench.rank()
    assert gates[1].reached.wait(PATIENCE)
    bench.stop_ranking()
    gates[1].opened.set()
    assert bench.ranked is None
    assert answers_of(bench) == []
    bench.edit(replace(bench.choices, mass=9.0))
    assert answers_of(bench)[-1].choices.mass == 9.0
    assert bench.study is None
