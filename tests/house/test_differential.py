"""The differential harness: what a state answers equals itself, and a changed limit, row or outcome is seen."""

from copy import deepcopy

import pytest
import yaml
from answers import answers_of
from compare import compared
from drawn_cases import write_cases

CASES = range(5)
"""Of one planar structure."""


def all_answers(folder):
    return {case.name: dict(answers_of(case)) for case in sorted(folder.iterdir())}


@pytest.fixture(scope="module")
def asked(tmp_path_factory):
    folder = tmp_path_factory.mktemp("cases")
    write_cases(folder, 0, CASES)
    return folder, all_answers(folder)


def test_answers_equal_themselves_and_a_changed_limit_is_seen(asked, capsys):
    folder, before = asked
    assert sum(answer["outcome"] == "feasible" for answers in before.values() for answer in answers.values()) > len(
        CASES
    )
    assert compared(before, all_answers(folder))
    for case in folder.iterdir():
        cell = yaml.safe_load((case / "cell.yaml").read_text(encoding="utf-8"))
        cell["robots"][0]["torque"][0] *= 1 + 1e-6
        (case / "cell.yaml").write_text(yaml.safe_dump(cell), encoding="utf-8")
    capsys.readouterr()
    assert not compared(before, all_answers(folder))
    assert "factor, case" in capsys.readouterr().out


@pytest.mark.parametrize("change", ["rows", "outcome", "torque", "absent"])
def test_each_part_of_an_answer_counts(asked, change):
    _, before = asked
    after = deepcopy(before)
    answers = next(answers for answers in after.values() if answers.get("factor", {}).get("outcome") == "feasible")
    if change == "rows":
        answers["factor"]["upper"]["rows"] = ["arm9/j0 torque (upper, 1 N m)"]
    elif change == "outcome":
        answers["factor"]["outcome"] = "infeasible"
    elif change == "torque":
        answers["factor"]["arrays"]["torque"] *= 1 + 1e-5
    else:
        del answers["factor"]
    assert not compared(before, after)
