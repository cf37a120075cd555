"""Contacts along a motion: their rows turn with the object, and every path to an answer has the same."""

from dataclasses import replace

import numpy as np
import pytest
from cell_bank import random_planar_cell, random_spatial_cell

import mrts
from mrts.cell.hands import read_contacts, tip_components

SAME = 1e-8
"""Of c² by different programs, relative, and of torques, to their limits: each is right to 1e-9 of a limit."""


def with_contacts(cell, *of_robots):
    """The cell with other contacts and no other limits of wrenches, robot by robot."""
    free = cell.without_wrench_limits()
    robots = (replace(robot, contacts=own) for robot, own in zip(free.robots, of_robots, strict=True))
    return replace(free, robots=tuple(robots))


def random_contacts(rng, cell):
    """Contacts that leave room for the wrenches of a plan without them, of random kinds, and some that are tight."""
    contacts = []
    for robot in cell.robots:
        components = tip_components(cell.wrench_components, robot.T_object_tip.R)
        size = len(components)
        normal = np.zeros(3)
        normal[["xyz".index(component[1]) for component in components if component[0] == "f"]] = rng.normal(
            size=size // 3 + 1 if size == 6 else 2
        )
        widths = rng.uniform(0.02, 0.2, 2 if size == 6 else 1).tolist()
        grip = {"friction": rng.uniform(0.3, 1.0), "half_width": widths}
        strength = float(rng.uniform(10, 80))
        held = {"gripper": grip | {"force": strength, "axis": normal}}
        pressed = {"pad": grip | {"force": [0, 3 * strength], "normal": normal}}
        cup = {"suction": {"holding_force": strength, "radius": widths[0], "normal": normal, "friction": 0.6}}
        most = rng.uniform(5, 60, size).tolist()
        sides = {"lower": [-value for value in most], "upper": most}
        boxes = [{"box": sides | {"frame": frame}} for frame in ("tip", "object", "base")]
        kinds = [[held], [cup], [held, boxes[0]], [boxes[1], boxes[2]], [pressed], []]
        chosen = kinds[int(rng.choice(len(kinds), p=[0.25, 0.15, 0.2, 0.2, 0.1, 0.1]))]
        contacts.append(read_contacts("cell", "contact", chosen, cell.wrench_components, robot.T_object_tip.R))
    robots = (replace(robot, contacts=own) for robot, own in zip(cell.robots, contacts, strict=True))
    return replace(cell, robots=tuple(robots))


@pytest.mark.parametrize("draw", [random_planar_cell, random_spatial_cell])
def test_compiled_rows_are_those_of_numpy_on_random_cells(draw, tmp_path):
    """With contacts of every kind: ranges and torques by the kernel, and by CasADi's solvers on numpy's rows."""
    rng = np.random.default_rng(7)
    answered = contacts_bind = 0
    for number in range(8):
        case = draw(rng, tmp_path / str(number), 2 + number % 2)
        cell = random_contacts(rng, case.cell.without_velocity_limits())
        try:
            ours, theirs = (mrts.scale(cell, case.motion, solver=solver) for solver in ("kernel", "qpsol:qpoases"))
        except mrts.MotionError:
            continue
        assert ours.status is theirs.status
        for end in ("lower", "upper"):
            mine, other = getattr(ours.range, end), getattr(theirs.range, end)
            assert (mine is None) == (other is None)
            if mine is not None:
                assert mine.c2 == pytest.approx(other.c2, rel=SAME, abs=SAME)
                assert set(mine.rows) == set(other.rows)
                contacts_bind += any(row.name.kind == "contact" for row in mine.rows)
        if ours.trajectory is None:
            continue
        answered += 1
        limit = np.concatenate([robot.torque_upper for robot in cell.robots])
        assert np.max(np.abs(ours.trajectory.torque - theirs.trajectory.torque) / limit) < 1e-6
    assert answered > 2
    assert contacts_bind > 1


def test_one_box_in_the_axes_of_tip_object_and_base_is_one_limit(dual_ur5):
    """Along a motion that does not turn, in a cell whose left base does not, and its grasps by quarter turns only."""
    path = {"start": {"xyz": [0.0, 0.1, 0.35]}, "end": {"xyz": [0.03, 0.2, 0.5]}}
    motion = mrts.load_motion({"duration": 0.4, "samples": 41, "profile": "quintic", **path})
    lower, upper = np.array([-30.0, -20, 5, -4, -3, -6]), np.array([60.0, 25, 90, 4, 5, 7])
    left, _ = dual_ur5.robots
    R = left.T_object_tip.R.round()
    np.testing.assert_allclose(R, left.T_object_tip.R, atol=1e-12)
    turned = [np.concatenate([R.T @ part for part in np.split(side, 2)]) for side in (lower, upper)]
    sides = {"object": (lower, upper), "base": (lower, upper), "tip": (np.minimum(*turned), np.maximum(*turned))}
    found = {}
    for frame, (least, most) in sides.items():
        box = {"box": {"lower": least.tolist(), "upper": most.tolist(), "frame": frame}}
        own = read_contacts("cell", "contact", [box], dual_ur5.wrench_components, left.T_object_tip.R)
        found[frame] = mrts.scale(with_contacts(dual_ur5, own, ()).without_velocity_limits(), motion)
        F = found[frame].wrench["left"]
        assert np.all((lower - 1e-6 <= F) & (upper + 1e-6 >= F))
    for result in found.values():
        assert result.range.upper.c2 == pytest.approx(found["base"].range.upper.c2, rel=SAME)
        np.testing.assert_allclose(result.trajectory.torque, found["base"].trajectory.torque, atol=1e-6)
