"""What changes to a cell would do: against changed files and an independent implementation; order and outcomes."""

from dataclasses import replace

import numpy as np
import pytest
import yaml
from conftest import UR5
from gantries import along_x, gantries
from scipy.spatial.transform import Rotation
from shipped_cells import cell_file, shipped
from shown_results import with_changes

import mrts

PROGRAMS = 1e-8  # both answers are programs solved to 1e-9


def by_text(found):
    return {str(one.change): one for one in found.changes}


def turned(pose, axis, angle):
    """A pose of a cell file, turned about an axis of the frame that it is in."""
    R = Rotation.from_rotvec(angle * np.eye(3)["xyz".index(axis)]) * Rotation.from_euler(
        "xyz", pose.get("rpy", [0] * 3)
    )
    return pose | {"rpy": R.as_euler("xyz").tolist()}


def shifted(pose, axis, way):
    return pose | {"xyz": (np.array(pose["xyz"], dtype=float) + way * np.eye(3)["xyz".index(axis)]).tolist()}


FOUND = (
    "left/elbow +10 %",
    "right/wrist_2_turn -10 %",
    "left/nx -10 %",
    "right/fy +10 %",
    "object/linear velocity -10 %",
    "mass +10 %",
    "left base x +10 mm",
    "right base about y +1°",
    "right grasp y +10 mm",
    "left grasp about x -1°",
)

QUESTIONS = [{}, {"sharing": mrts.LoadSharing()}, {"reserve": 0.3}, {"load": "guaranteed"}]


@pytest.mark.parametrize("asked", QUESTIONS, ids=["free", "even", "reserve", "guaranteed"])
def test_each_change_is_what_scaling_a_changed_file_gives(asked, tmp_path):
    """Of two arms of the UR5 class with limits that bind elsewhere."""
    description = shipped("dual_ur5", torque=[150] * 3 + [28] * 3)
    description["object"] |= {"velocity": {"linear": 1.0}, "variation": {"mass": [0.8, 1.2], "izz": [0.5, 1.5]}}
    asked = {"load": "nominal", "between": None} | asked
    motion = mrts.load_motion(UR5 / "lift_and_turn.yaml")

    def scaled(text):
        return mrts.scale(mrts.load_cell(cell_file(tmp_path, text)), motion, **asked)

    result = scaled(description)
    found = by_text(result.what_if())
    assert found["mass +10 %"].before.c2 == pytest.approx(result.range.upper.c2, rel=PROGRAMS)
    for text in FOUND:
        again = scaled(file_with(description, found[text].change, result.cell))
        assert found[text].after.c2 == pytest.approx(again.range.upper.c2, rel=PROGRAMS), text
        assert found[text].after.duration == pytest.approx(again.trajectory.duration, rel=PROGRAMS), text


def file_with(description, change, cell):
    """The description of a cell with a change, from what the change says of itself."""
    changed = yaml.safe_load(yaml.safe_dump(description))
    if change.robot in {"", "object"}:
        owner, key = (changed["object"], "mass") if change.kind == "mass" else (changed["object"]["velocity"], "linear")
        owner[key] *= 1 + change.step
        return changed
    robot = next(entry for entry in changed["robots"] if entry["name"] == change.robot)
    if change.kind == "torque":
        joints = next(arm.joints for arm in cell.robots if arm.name == change.robot)
        robot["torque"][joints.index(change.element)] *= 1 + change.step
    elif change.kind == "wrench":
        for side in ("lower", "upper"):
            limit = robot["wrench"][side][cell.wrench_components.index(change.element)]
            robot["wrench"][side][cell.wrench_components.index(change.element)] = limit and limit * (1 + change.step)
    else:
        moved = turned if change.unit == "rad" else shifted
        pose = {"xyz": [0, 0, 0]} | robot.get(change.kind, {})
        robot[change.kind] = moved(pose, change.element[-1], change.step)
    return changed


@pytest.mark.quick
def test_a_limit_that_binds_alone_in_closed_form(tmp_path):
    """Two gantries push 11 kg along 2 m with 20 N each: c² is force by mass, and at most (velocity / 3 m/s)²."""
    cell = gantries(tmp_path, object_velocity={"linear": 4.0})
    result = mrts.scale(cell, along_x(), between=None)
    total, heaviest = 40.0, 3 + 2 * 4.0
    c2 = total / (heaviest * 12.0)
    assert result.range.upper.c2 == pytest.approx(c2)
    found = by_text(result.what_if())
    assert found["near/slide_x +10 %"].after.c2 == pytest.approx(c2 * (1 + 2.0 / total))
    assert found["far/slide_x -10 %"].after.c2 == pytest.approx(c2 * (1 - 2.0 / total))
    assert found["mass -10 %"].after.duration == pytest.approx(1 / np.sqrt(c2 * heaviest / (heaviest - 0.3)))
    assert str(found["far/slide_x +10 %"]).startswith("far/slide_x +10 %; time -2.41 %; 1.77")
    assert not found["object/linear velocity +10 %"].matters


@pytest.mark.quick
def test_what_gains_comes_first_and_what_does_nothing_is_said_in_one_sentence(lifted):
    found = lifted.what_if()
    durations = [one.after.duration for one in found.changes]
    assert durations == sorted(durations)
    assert found.without_effect == ("left/wrist", "right/wrist")
    question, _head, *table, last = str(found).splitlines()
    assert last.startswith("each of 2 others may be")
    assert len(table) == sum(one.matters for one in found.changes)
    assert question.endswith("now 0.2992 s at c² = 3.062")
    assert " ".join(table[0].split()) == "mass -10 % time -0.804 % 0.2968 s left/elbow, right/elbow, left/fx and 3 more"
    effects = [float(row.partition(" time ")[2].partition(" %")[0]) for row in table]
    assert effects == sorted(effects)


def test_what_cannot_be_played_says_why_and_comes_last(planar_cell, lift):
    found = by_text(with_changes(mrts.scale(planar_cell.with_mass(7.0), lift), SHARE=0.8, SHIFT=0.9).changes)
    lost = found["mass +80 %"]
    assert lost.after.status == "infeasible"
    told = "at 20 of 101 samples; at t = 0 s left/elbow ↑, right/elbow ↓, left/fx ↑ and 1 more conflict"
    assert str(lost) == f"mass +80 %; infeasible; cannot be played; {told}"
    far = found["left base y -900 mm"]
    assert far.after.status == "unreachable"
    assert "robot 'left'" in far.after.reason
    kept = list(found.values())
    played = [one.after.duration is not None for one in kept]
    assert played == sorted(played, reverse=True)
    assert not all(played)


def test_joints_that_arms_do_not_take_by_themselves_are_left_where_they_are(planar_cell, lift):
    """Joints given from elsewhere than the posture are followed again; others are not, and it says so."""
    motion = mrts.follow_object(planar_cell, lift)
    far = {robot.name: (robot.posture + 0.4).tolist() for robot in planar_cell.robots}
    found = mrts.scale(planar_cell.with_postures(far), motion, between=None).what_if()
    assert found.left_out == ""
    plain = by_text(mrts.scale(planar_cell, lift, between=None).what_if())
    assert all(one.after.c2 == pytest.approx(plain[text].after.c2, rel=1e-6) for text, one in by_text(found).items())
    slower = replace(motion, ddq=motion.ddq * (1 + 1e-4))
    given = mrts.scale(planar_cell, slower, between=None, closure=mrts.ClosureBound(0.01, 0.02)).what_if()
    assert not any(one.change.moves_arms for one in given.changes)
    assert given.left_out.startswith("bases and grasps were not moved")
