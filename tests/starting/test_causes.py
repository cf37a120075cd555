"""What is named as the cause of a motion that fails is its cause."""

import json
from dataclasses import replace

import numpy as np
import pytest
from conftest import DATA
from motion_tables import columns_of, write_motion, write_table
from shipped_cells import shipped_motion

import mrts
from mrts.base.rigid_transform import RigidTransform
from mrts.cli import main

UPPER_BODY = DATA.parent / "upper_body"
PLANAR = DATA / "cell.yaml", DATA / "lift.yaml"


def joints_of(cell, motion, kept=("q",)):
    """Columns of the joints that follow a motion."""
    cell = mrts.load_cell(cell)
    return cell, columns_of(cell, mrts.follow_object(cell, mrts.load_motion(motion)), kept)


@pytest.mark.parametrize(
    "files", [PLANAR, (UPPER_BODY / "cell.yaml", UPPER_BODY / "lift.yaml")], ids=["chain open", "past a limit"]
)
def test_swapped_columns_are_tried(files, tmp_path):
    _, columns = joints_of(*files)
    names = [name for name in columns if name != "t"]
    half = len(names) // 2
    swapped = {"t": columns["t"]} | dict(
        zip(names, [columns[name] for name in names[half:] + names[:half]], strict=True)
    )
    found = mrts.check(files[0], write_table(tmp_path / "swapped.csv", swapped))
    assert (found.status, [hint.code for hint in found.hints]) == ("impossible", ["swapped-columns"])
    rng = np.random.default_rng(3)
    wrong = columns | {names[0]: columns[names[0]] + rng.uniform(0.1, 0.2)}
    assert mrts.check(files[0], write_table(tmp_path / "wrong.csv", wrong)).hints == ()


def moved(folder, by):
    """The shipped machine's motion, elsewhere."""
    motion = shipped_motion("upper_body", samples=21)
    for key in ("start", "end"):
        motion[key]["xyz"] = (np.array(motion[key]["xyz"]) + by).tolist()
    return write_motion(folder, **motion)


def test_arms_of_one_machine_are_moved_together(tmp_path, capsys):
    """The move that is proposed lets both arms follow; where it lets one alone, none is proposed."""
    motion = moved(tmp_path, [0.3, 0, 0])
    found = mrts.check(UPPER_BODY / "cell.yaml", motion)
    assert [arm.machine for arm in found.arms] == [("right",), ("left",)]
    assert "Move its base" not in str(found)
    cell = mrts.load_cell(UPPER_BODY / "cell.yaml")
    for arm in found.arms:
        assert arm.shift is not None
        bases = [RigidTransform(robot.T_world_base.R, robot.T_world_base.p + arm.shift) for robot in cell.robots]
        robots = [replace(robot, T_world_base=base) for robot, base in zip(cell.robots, bases, strict=True)]
        mrts.follow_object(replace(cell, robots=tuple(robots)), mrts.load_motion(motion))
    apart = mrts.check(UPPER_BODY / "cell.yaml", moved(tmp_path, [0, 0.45, 0]))
    lost = [arm for arm in apart.arms if not arm.follows]
    assert lost
    assert all(arm.machine for arm in lost)
    assert main(["check", str(UPPER_BODY / "cell.yaml"), str(motion), "-q", "--json", "-"]) == 1
    assert [arm["machine"] for arm in json.loads(capsys.readouterr().out)["arms"]] == [["right"], ["left"]]
