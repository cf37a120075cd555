"""What changes to a cell would do: against changed files and an independent implementation."""

import numpy as np
import pytest
import yaml
from cell_bank import drawn_until, random_planar_cell, random_spatial_cell
from conftest import UR5
from draws import seeds
from reference import ReferenceCell
from scipy.spatial.transform import Rotation
from shipped_cells import cell_file, shipped

import mrts

PROGRAMS = 1e-8  # both answers are programs solved to 1e-9
FOUND_AGAIN = 1e-6  # joints by another Newton iteration, programs by HiGHS to 1e-10


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


@pytest.mark.parametrize("seed", seeds(2, 1))
def test_random_changes_of_random_cells_against_an_independent_implementation(seed, tmp_path):
    """Pinocchio, its own inverse kinematics, HiGHS: the changed cell is a changed file."""
    rng = np.random.default_rng([17, seed])
    make = random_planar_cell if seed % 3 else random_spatial_cell
    case, result = drawn_until(
        lambda case: found if (found := mrts.scale(case.cell, case.motion, between=None)).trajectory else None,
        lambda: make(rng, tmp_path, arms=2 + seed % 2, samples=11),
    )
    found = result.what_if()
    for one in found.changes:
        if one.change.kind in {"torque", "wrench", "velocity"} and one.faster is not None:
            assert (one.faster - 1) * one.change.step >= -PROGRAMS, one  # wider never slows, narrower never speeds
        assert (
            one.change.step < 0 or one.after.duration is not None or one.change.unit != "1" or one.change.kind == "mass"
        )
    described = yaml.safe_load(case.cell_file.read_text())
    kinds = ("torque", "wrench", "mass", "base", "grasp")
    checked = [one for one in found.changes if one.change.kind in kinds and one.after.duration is not None]
    for one in rng.choice(np.array(checked, dtype=object), 6, replace=False):
        changed = file_with(described, one.change, case.cell)
        path = tmp_path / "changed.yaml"
        path.write_text(yaml.safe_dump(changed))
        least, most = reference_range(ReferenceCell(path), case.motion_file)
        assert one.after.c2 == pytest.approx(most, rel=FOUND_AGAIN), one.change
        assert least <= most, one.change


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


def reference_range(cell, motion_file):
    _, samples = cell.object_motion(motion_file)
    joints = cell.joint_motion(samples)
    ends = []
    for place, sample in enumerate(samples):
        own = [history[place] for history in joints]
        ends.append(cell.range_at(cell.terms(sample, own), own, even=False)[1:])
    lower, upper = np.array(ends).T
    return np.max(lower), np.min(upper)
