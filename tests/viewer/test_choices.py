"""Choices saved as a cell file and a motion file: what was edited and nothing else, or nothing at all."""

import os
import shutil

import numpy as np
import pytest
import yaml
from conftest import UR5
from shown_viewer import answered

import mrts
from mrts.base.rigid_transform import RigidTransform
from mrts.base.yaml_text import edited_yaml
from mrts.motion.motion_file import described_motion
from mrts.viewer.choices import Choices, Given, Place, motion_text, moved_by, save_choices
from mrts.viewer.workbench import Workbench

SAME = 1e-9
"""Of numbers that were found twice by the same programs from numbers that passed through a text."""


@pytest.fixture
def given(tmp_path):
    folder = shutil.copytree(UR5, tmp_path / "cell")
    cell, motion = folder / "cell.yaml", folder / "lift_and_turn.yaml"
    return Given(mrts.load_cell(cell), mrts.load_motion(motion), described_motion(motion), cell, motion)


def test_saved_files_hold_what_was_changed_and_keep_the_rest(given):
    base, end = Place("base", "left"), Place("end")
    choices = Choices(mass=9.5).with_pose(end, moved_by(end.given(given), np.array([0, 0, 0.05]), np.zeros(3)))
    choices = choices.with_pose(base, moved_by(base.given(given), np.array([0.02, 0, 0]), np.array([0, 0, 0.1])))
    choices = choices.with_limit(("torque", "left", "elbow"), 0.5)
    before = given.cell_path.read_text().splitlines()
    (cell, motion), remark = save_choices(given, choices, "other.yaml", "moved.yml", overwrite=False)
    assert remark == ""
    bench = Workbench(given)
    bench.edit(choices)
    saved = mrts.scale(mrts.load_cell(cell), mrts.load_motion(motion))
    assert saved.range.upper.c2 == pytest.approx(answered(bench).state.result.range.upper.c2, rel=SAME)
    lines = cell.read_text().splitlines()
    assert sum(line not in before for line in lines) == 3  # mass, base, and a key of torques
    assert "  mass: 9.5                              # kg" in lines
    assert sum("#" in line for line in lines) == sum("#" in line for line in before)


@pytest.mark.parametrize(
    "name",
    [
        "../out.yaml",
        "/out.yaml",
        "a/b.yaml",
        ".hidden.yaml",
        "out.txt",
        "",
        "x\n.yaml",
        "a\\b.yaml",
        "🦾" * 90 + ".yaml",
    ],
)
def test_nothing_is_saved_elsewhere(given, name):
    root = given.cell_path.parent.parent
    before = sorted(os.walk(root))
    with pytest.raises(mrts.InputError, match="must be a name"):
        save_choices(given, Choices(), name, "", overwrite=True)
    with pytest.raises(mrts.InputError, match=r"must be a name|cell file"):
        save_choices(given, Choices(), "fine.yaml", name or "fine.yaml", overwrite=True)
    assert sorted(os.walk(root)) == before


def test_files_are_replaced_only_when_asked_and_links_never(given):
    cell, text = given.cell_path, given.cell_path.read_text()
    with pytest.raises(mrts.InputError, match="exists already"):
        save_choices(given, Choices(mass=9.0), "new.yaml", "lift_and_turn.yaml", overwrite=False)
    assert not (cell.parent / "new.yaml").exists()
    save_choices(given, Choices(mass=9.0), "cell.yaml", "", overwrite=True)
    assert cell.read_text() == text.replace("mass: 8.0", "mass: 9")
    (cell.parent / "link.yaml").symlink_to(given.motion_path)
    with pytest.raises(mrts.InputError, match="is a link"):
        save_choices(given, Choices(), "link.yaml", "", overwrite=True)


@pytest.mark.quick
@pytest.mark.parametrize("which", ["start", "end"])
def test_an_end_that_the_file_repeats_moves_alone(which, tmp_path):
    """An alias is not where its value is written: such a file is written anew, and read here by `mrts`."""
    path = tmp_path / "motion.yaml"
    path.write_text("duration: 2\nprofile: sinusoid\nstart: &here {xyz: [1, 1, 0]}\nend: *here\n", encoding="utf-8")
    given = Given(None, None, described_motion(path), None, path)
    moved = RigidTransform(np.eye(3), np.array([1.0, 1.5, 0.0]))
    text, remark = motion_text(given, Choices().with_pose(Place(which), moved))
    assert "motion file was written anew" in remark
    path.write_text(text, encoding="utf-8")
    ends = mrts.load_motion(path).position[[0, -1]]
    np.testing.assert_allclose(ends, [[1, 1.5, 0], [1, 1, 0]] if which == "start" else [[1, 1, 0], [1, 1.5, 0]])


@pytest.mark.parametrize(
    ("text", "keys", "value"),
    [
        ("a: 1  # one\nb: [1, 2]\n", ("b",), [3.5, 4.0]),
        ("a: 1  # one\nb: [1, 2]\n", ("c", "d"), 1e-3),
        ("r:\n  - base:\n      xyz:\n        - 1\n        - 2  # two\n  - {a: y}\n", ("r", 0, "base", "xyz"), [5.0]),
        ("r:\n  - name: x\n  - {name: y}  # why\n", ("r", 1, "base", "xyz"), [1.0, 2.0]),
        ("r:\n  - name: x  # end", ("r", 0, "posture"), [0.1, None]),
    ],
)  # fmt: skip
def test_an_edit_changes_one_value_and_no_comment(text, keys, value):
    done = edited_yaml(text, {keys: value})
    wanted = yaml.safe_load(text)
    place = wanted
    for key in keys[:-1]:
        place = place.setdefault(key, {}) if isinstance(place, dict) else place[key]
    place[keys[-1]] = value
    assert yaml.safe_load(done) == wanted
    assert all(comment in done for comment in ("# one", "# why", "# end") if comment in text)
