"""The differential harness: what a state answers equals itself, and a changed row, outcome or torque is seen."""

from copy import deepcopy

import pytest
from answers import answers_of
from compare import compared
from drawn_cases import write_cases

CASES = range(5)
"""Of one planar structure."""


@pytest.fixture(scope="module")
def asked(tmp_path_factory):
    folder = tmp_path_factory.mktemp("cases")
    write_cases(folder, 0, CASES)
    return {case.name: dict(answers_of(case)) for case in sorted(folder.iterdir())}


@pytest.mark.parametrize("change", ["nothing", "rows", "outcome", "torque", "absent"])
def test_each_part_of_an_answer_counts(asked, change):
    before = asked
    after = deepcopy(before)
    answers = next(answers for answers in after.values() if answers.get("factor", {}).get("outcome") == "feasible")
    if change == "nothing":
        assert compared(before, after)
        return
    if change == "rows":
        answers["factor"]["upper"]["rows"] = ["arm9/j0 torque (upper, 1 N m)"]
    elif change == "outcome":
        answers["factor"]["outcome"] = "infeasible"
    elif change == "torque":
        answers["factor"]["arrays"]["torque"] *= 1 + 1e-5
    else:
        del answers["factor"]
    assert not compared(before, after)
