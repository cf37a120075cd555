"""What changes to a cell would do: against changed files, an independent implementation, and multipliers."""

from math import radians

import numpy as np
import pytest
import yaml
from cell_bank import drawn_until, random_planar_cell, random_spatial_cell
from conftest import DATA
from draws import seeds
from reference import ReferenceCell
from scipy.optimize import linprog
from scipy.spatial.transform import Rotation

import mrts

UR5 = DATA.parent / "dual_ur5"
PROGRAMS = 1e-8  # both answers are programs solved to 1e-9
FOUND_AGAIN = 1e-6  # joints by another Newton iteration, programs by HiGHS to 1e-10
FIRST_ORDER = 2e-3  # of an effect, by steps of 1e-4
SMALL_STEP = 1e-4
KINK = 1e-2  # up and down differ by more where another row takes over


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


def edit(robot, key, change):
    def edited(description):
        arm = next(entry for entry in description["robots"] if entry["name"] == robot)
        arm[key] = change(arm.get(key))

    return edited


def torques(joint, factor):
    return lambda _given: [
        limit * (factor if place == joint else 1) for place, limit in enumerate([150] * 3 + [28] * 3)
    ]


def wrench(component, factor):
    def changed(given):
        sides = {side: list(values) for side, values in given.items()}
        for values in sides.values():
            values[component] *= factor
        return sides

    return changed


def velocity(joint, factor, folder):
    """Another URDF, with one joint faster or slower."""

    def changed(given):
        joints = (folder / given).read_text().split("<joint ")
        place = next(place for place, text in enumerate(joints) if text.startswith(f'name="{joint}"'))
        joints[place] = joints[place].replace('velocity="3.141592653589793"', f'velocity="{np.pi * factor!r}"')
        (folder / "faster.urdf").write_text("<joint ".join(joints))
        return "faster.urdf"

    return changed


def of_object(key, change):
    return lambda description: description["object"].update({key: change(description["object"].get(key))})


FILES = {
    "left/elbow +10 %": lambda _: edit("left", "torque", torques(2, 1.1)),
    "right/wrist_2_turn -10 %": lambda _: edit("right", "torque", torques(4, 0.9)),
    "left/nx -10 %": lambda _: edit("left", "wrench", wrench(3, 0.9)),
    "right/fy +10 %": lambda _: edit("right", "wrench", wrench(1, 1.1)),
    "right/wrist_2_turn velocity +10 %": lambda at: edit("right", "urdf", velocity("wrist_2_turn", 1.1, at)),
    "right/wrist_2_turn velocity -10 %": lambda at: edit("right", "urdf", velocity("wrist_2_turn", 0.9, at)),
    "object/linear velocity -10 %": lambda _: of_object("velocity", lambda given: given | {"linear": 0.9}),
    "mass +10 %": lambda _: of_object("mass", lambda given: 1.1 * given),
    "left base x +10 mm": lambda _: edit("left", "base", lambda pose: shifted(pose, "x", 0.01)),
    "right base z -10 mm": lambda _: edit("right", "base", lambda pose: shifted(pose, "z", -0.01)),
    "right base about y +1°": lambda _: edit("right", "base", lambda pose: turned(pose, "y", radians(1))),
    "right grasp y +10 mm": lambda _: edit("right", "grasp", lambda pose: shifted(pose, "y", 0.01)),
    "left grasp about x -1°": lambda _: edit("left", "grasp", lambda pose: turned(pose, "x", -radians(1))),
    "right grasp about y +1°": lambda _: edit("right", "grasp", lambda pose: turned(pose, "y", radians(1))),
}
"""Changes of the two arms of the UR5 class, and what does the same to their files."""

QUESTIONS = [{}, {"sharing": mrts.LoadSharing()}, {"reserve": 0.3}, {"load": "guaranteed"}]


@pytest.fixture(scope="module")
def described(tmp_path_factory):
    """A folder with the cell as a description that moves other limits to where they bind."""
    folder = tmp_path_factory.mktemp("ur5")
    (folder / "ur5_class_arm.urdf").write_text((UR5 / "ur5_class_arm.urdf").read_text())
    description = yaml.safe_load((UR5 / "cell.yaml").read_text())
    description["object"] |= {"velocity": {"linear": 1.0}, "variation": {"mass": [0.8, 1.2], "izz": [0.5, 1.5]}}
    return folder, description


@pytest.mark.parametrize("asked", QUESTIONS, ids=["free", "even", "reserve", "guaranteed"])
def test_each_change_is_what_scaling_a_changed_file_gives(asked, described):
    folder, description = described
    asked = {"load": "nominal", "between": None} | asked
    motion = mrts.load_motion(UR5 / "lift_and_turn.yaml")
    (folder / "cell.yaml").write_text(yaml.safe_dump(description))
    result = mrts.scale(mrts.load_cell(folder / "cell.yaml"), motion, **asked)
    found = by_text(result.what_if())
    assert found["mass +10 %"].before.c2 == pytest.approx(result.range.upper.c2, rel=PROGRAMS)
    for text, change in FILES.items():
        changed = yaml.safe_load(yaml.safe_dump(description))
        change(folder)(changed)
        (folder / "changed.yaml").write_text(yaml.safe_dump(changed))
        again = mrts.scale(mrts.load_cell(folder / "changed.yaml"), motion, **asked)
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
        changed = file_with(described, one.change, case.cell.wrench_components)
        path = tmp_path / "changed.yaml"
        path.write_text(yaml.safe_dump(changed))
        least, most = reference_range(ReferenceCell(path), case.motion_file)
        assert one.after.c2 == pytest.approx(most, rel=FOUND_AGAIN), one.change
        assert least <= most, one.change


def file_with(description, change, components):
    """The description of a cell with a change, from what the change says of itself."""
    changed = yaml.safe_load(yaml.safe_dump(description))
    if change.kind == "mass":
        changed["object"]["mass"] *= 1 + change.step
        return changed
    robot = next(entry for entry in changed["robots"] if entry["name"] == change.robot)
    if change.kind == "torque":
        place = place_of_joint(change, robot)
        robot["torque"][place] *= 1 + change.step
    elif change.kind == "wrench":
        for side in ("lower", "upper"):
            limit = robot["wrench"][side][components.index(change.element)]
            robot["wrench"][side][components.index(change.element)] = limit and limit * (1 + change.step)
    else:
        moved = turned if change.unit == "rad" else shifted
        pose = {"xyz": [0, 0, 0]} | robot.get(change.kind, {})
        robot[change.kind] = moved(pose, change.element[-1], change.step)
    return changed


def place_of_joint(change, robot):
    """Joints of the bank are numbered along the chain."""
    return int("".join(filter(str.isdigit, change.element))) % len(robot["torque"])


def reference_range(cell, motion_file):
    _, samples = cell.object_motion(motion_file)
    joints = cell.joint_motion(samples)
    ends = []
    for place, sample in enumerate(samples):
        own = [history[place] for history in joints]
        ends.append(cell.range_at(cell.terms(sample, own), own, even=False)[1:])
    lower, upper = np.array(ends).T
    return np.max(lower), np.min(upper)


def multipliers(cell, motion_file):
    """What c²⁺ gains by each limit moved outward by its own size, by (robot, place of joint or component) and kind.

    From the multipliers of the reference's linear program at the sample that sets c²⁺; None where two samples do.
    """
    _, samples = cell.object_motion(motion_file)
    joints = cell.joint_motion(samples)
    programs = [
        cell.program(cell.terms(sample, [history[place] for history in joints]), even=False)
        for place, sample in enumerate(samples)
    ]
    answers = [solved(*program) for program in programs]
    order = np.argsort([answer.x[-1] for answer in answers])
    first, second = answers[order[0]].x[-1], answers[order[1]].x[-1]
    if first > second * (1 - KINK):
        return None
    _, _, upper, x_lower, x_upper = programs[order[0]]
    answer, gains, row = answers[order[0]], {}, 0
    rows, m = len(upper), len(cell.rows)
    down, up = answer.ineqlin.marginals[rows:], answer.ineqlin.marginals[:rows]
    for index, arm in enumerate(cell.arms):
        for j, (least, most) in enumerate(arm.torque.T):
            gains["torque", index, j] = -up[row] * abs(most) - down[row] * abs(least)
            row += 1
        for component in range(m):
            at = index * m + component
            sides = ((answer.lower.marginals[at], x_lower[at]), (-answer.upper.marginals[at], x_upper[at]))
            gains["wrench", index, component] = sum(rate * abs(limit) for rate, limit in sides if rate)
    return first, gains


def solved(A, lower, upper, x_lower, x_upper):
    cost = np.zeros(A.shape[1])
    cost[-1] = -1.0
    rows, sides = np.vstack([A, -A]), np.concatenate([upper, -lower])
    return linprog(cost, rows, sides, bounds=np.column_stack([x_lower, x_upper]), method="highs-ds")


def torque_or_wrench_alone(case):
    """What changes do where a single sample, and no velocity, sets the upper end; None of another case."""
    result = mrts.scale(case.cell, case.motion, between=None)
    if result.trajectory is None or any(row.name.kind == "velocity" for row in result.range.upper.rows):
        return None
    expected = multipliers(ReferenceCell(case.cell_file), case.motion_file)
    return None if expected is None else (result, *expected)


@pytest.mark.parametrize("seed", seeds(1, 1))
def test_small_changes_do_what_the_multipliers_of_the_programs_say(seed, tmp_path):
    rng = np.random.default_rng([18, seed])
    make = random_planar_cell if seed % 3 else random_spatial_cell
    case, (result, c2, gains) = drawn_until(torque_or_wrench_alone, lambda: make(rng, tmp_path, arms=2))
    assert result.range.upper.c2 == pytest.approx(c2, rel=FOUND_AGAIN)
    found, felt = by_text(result.what_if(share=SMALL_STEP)), 0
    names = [robot.name for robot in case.cell.robots]
    for (kind, arm, place), gain in gains.items():
        robot = case.cell.robots[arm]
        element = robot.joints[place] if kind == "torque" else case.cell.wrench_components[place]
        if f"{names[arm]}/{element} +0.01 %" not in found:
            assert gain == 0
            continue
        up, down = (found[f"{names[arm]}/{element} {sign}0.01 %"].after.c2 - c2 for sign in "+-")
        if abs(up + down) > KINK * max(abs(up), abs(down), SMALL_STEP**2 * c2):
            continue  # another row takes over within the step
        assert (up - down) / 2 == pytest.approx(SMALL_STEP * gain, rel=FIRST_ORDER, abs=1e-8 * c2), (kind, arm, place)
        felt += gain > 1e-3 * c2
    assert felt > 0
