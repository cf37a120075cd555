"""The least reserve with which a plan survives: the search on plans whose answer is known, and on a real one."""

import pytest
from command_line import mrts_command
from shipped_cells import DATA

import mrts
from mrts.simulation import reserve as searching


class Played:
    """A simulation that uses 1.25 times what is planned."""

    def __init__(self, reserve):
        self.plan = self
        self.duration = 1 + reserve
        self.share = 1.25 * (1 - reserve)
        self.uses = ((None, self),)
        self.name = "left/fx contact wrench"
        self.passed = (self,) if self.share > 1 else ()


@pytest.mark.parametrize(("most", "found"), [(1.0, 0.2), (0.1, None)])
def test_the_search_ends_at_the_least_that_keeps_all(lifted, monkeypatch, most, found):
    asked = []

    def solve(reserve):
        asked.append(reserve)
        return lifted if reserve < most else mrts.scale(lifted.cell.with_mass(1e4), lifted.motion)

    monkeypatch.setattr(searching, "simulate", lambda *_: Played(asked[-1]))
    search = mrts.least_reserve(solve)
    assert asked[0] == 0
    assert len(asked) < 9
    if found is None:
        assert (search.found, search.reserve) == (None, None)
    else:
        assert found <= search.reserve <= found + searching.WITHIN
        assert search.found is lifted


def test_what_needs_no_reserve_has_none(lifted, monkeypatch):
    monkeypatch.setattr(searching, "simulate", lambda *_: Played(0.5))
    assert mrts.least_reserve(lambda _: lifted).reserve == 0


def test_a_lighter_load_counts_too(lifted):
    """Of the tried plans the first is the worse of both: the load heavier, and lighter by as much."""
    errors = mrts.PlantErrors(mass=0.05, friction_error=0.0)
    assert (errors.opposite().mass, errors.opposite().com.tolist()) == (-0.05, [0.0, 0.0, 0.0])
    first = mrts.least_reserve(lambda _: lifted, errors=errors).tried[0]
    both = [mrts.simulate(lifted, errors=each).uses[0][1].share for each in (errors, errors.opposite())]
    assert first.share == max(both) != min(both)


@pytest.mark.slow
def test_the_command_finds_a_plan_that_is_kept(tmp_path):
    cell, motion, plan = (
        DATA / "dual_ur5" / "cell.yaml",
        DATA / "dual_ur5" / "lift_and_turn.yaml",
        tmp_path / "plan.csv",
    )
    done = mrts_command("scale", cell, motion, "--reserve", "auto", "--csv", plan, "--plot", tmp_path / "plots")
    assert (done.returncode, done.stderr) == (0, "")
    assert (tmp_path / "plots" / "reserve.png").exists()
    assert mrts_command("simulate", cell, plan).returncode == 0
    assert mrts_command("configurations", cell, motion, "--reserve", "auto").returncode == 2
