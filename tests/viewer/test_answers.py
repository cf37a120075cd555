"""The order of a workbench's answers: coarse ones before whole ones, newer ones before older, all before a ranking."""

import time
from dataclasses import replace

import numpy as np
import pytest
from conftest import DATA

import mrts
from mrts.motion.motion_file import described_motion, sample_motion
from mrts.viewer.panel import outcome_html
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


def test_what_is_newer_ends_work_on_a_whole_answer(bench):
    masses = np.linspace(8.1, 9.0, 4)
    taken = []
    for mass in masses:
        bench.edit(Choices(profile="smooth", mass=float(mass)), "mass")
        taken += answers_of(bench, until=lambda one: one.coarse)
    taken += answers_of(bench)
    assert [one.choices.mass for one in taken if one.coarse] == masses.tolist()
    assert [one.choices.mass for one in taken if not one.coarse] == [masses[-1]]


def test_answers_come_while_configurations_are_ranked(bench):
    """Nothing of them is lost: the ranking is that of `mrts.rank_configurations`."""
    bench.rank()
    end = time.monotonic() + PATIENCE
    while bench.ranked is not None and bench.ranked[0] < 2:
        assert time.monotonic() < end
        time.sleep(0.001)
    before = bench.ranked
    bench.edit(replace(bench.choices, mass=11.0))
    (answer,) = answers_of(bench, until=lambda one: one.choices.mass == 11.0)
    during = bench.ranked
    assert before[0] <= during[0] < during[1]
    wanted = mrts.scale(bench.given.cell.with_mass(11.0), bench.given.motion)
    assert answer.state.result.range.upper.c2 == pytest.approx(wanted.range.upper.c2, rel=SAME)
    assert bench.study is None
    answers_of(bench)
    alone = mrts.rank_configurations(bench.given.cell, bench.given.motion)
    assert [one.c2_upper for one in bench.study.ranked] == [one.c2_upper for one in alone.ranked]


def test_a_ranking_can_be_stopped(bench):
    bench.rank()
    end = time.monotonic() + PATIENCE
    while bench.ranked[0] < 1:
        assert time.monotonic() < end
        time.sleep(0.001)
    bench.stop_ranking()
    assert bench.ranked is None
    assert answers_of(bench) == []
    bench.edit(replace(bench.choices, mass=9.0))
    assert answers_of(bench)[-1].choices.mass == 9.0
    assert bench.study is None
