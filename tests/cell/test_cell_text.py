"""A cell as a cell file: what is read back is the same cell to the last bit, or it is refused."""

from dataclasses import replace

import numpy as np
import pytest
import yaml
from changed_robots import with_left
from conftest import DATA
from same_cells import same_cell

import mrts
from mrts.cell.hands import read_contacts
from mrts.cell.points import ArmPointLimit, CarriedThing, PointLimit

SHIPPED = {path.parent.name: path for path in sorted(DATA.parent.glob("*/cell.yaml"))}


def equipped(cell, rng):
    """The cell with everything that a cell file can say besides."""
    robots = []
    for robot in cell.robots:
        n, w = len(robot.joints), len(robot.wrench_lower)
        motors = mrts.JointMotors(
            armature=rng.uniform(0, 1, n),
            coulomb=rng.uniform(0, 0.1, n),
            viscous=rng.uniform(0, 1, n),
            torque_speed=(*[None] * (n - 1), np.array([[0, 400.0], [3.0, 380.0], [7.0, 1.0]])),
            torque_rate=rng.uniform(100, 1000, n),
            jerk=np.full(n, np.inf),
            rated=rng.uniform(1, 10, n),
            power=rng.uniform(1, 100, n),
        )
        box = {"box": {"lower": [-5.0, None, *([0.0] * (w - 2))], "upper": [30.0] * w, "frame": "base"}}
        rpy = rng.uniform(-3, 3, 3) * ([1, 0.5, 1] if cell.plane is None else [0, 0, 1])  # a plane is not left
        changes = {
            "motors": motors,
            "contacts": read_contacts("cell", "contact", [box, box], cell.wrench_components, robot.T_object_tip.R),
            "contact_rate": np.where(["f" in unit for unit in cell.wrench_components], 500.0, 40.0),
            "torque_lower": -robot.torque_upper * 1.5,
            "velocity_limit": rng.uniform(1, 5, n),
            "acceleration_lower": np.array([-np.inf, *[-3.0] * (n - 1)]),
            "acceleration_upper": rng.uniform(1, 5, n),
            "point_limits": (
                ArmPointLimit(
                    name="tip", link=robot.source.tip_link, speed=1.0, joints=n, at_zero=robot.T_base_tip.p.tolist()
                ),
            ),
            "T_world_base": mrts.RigidTransform.from_xyz_rpy(robot.T_world_base.p + 0.1 * rng.uniform(-1, 1, 3), rpy),
        }
        robots.append(replace(robot, **changes))
    of_object = {
        "object_velocity_limit": np.array([0.5, np.inf]),
        "object_acceleration_limit": np.array([np.inf, 4.0]),
        "object_points": (PointLimit(name="corner", point=[0.1, 0.2, 0.3], acceleration=2.0),),
        "carried": (CarriedThing(name="cup", friction=0.4, half_width=[0.03, 0.04], height=0.05),),
        "power_limit": 900.0,
    }
    cell = replace(cell, robots=tuple(robots), **of_object)
    return cell.with_variation(mass=(0.5, 2.0), ixx=(0.9, 1.1)).with_values({"gravity": rng.uniform(-10, 10, 3)})


@pytest.mark.parametrize("name", SHIPPED)
def test_a_shipped_cell_comes_back(name, tmp_path):
    cell = mrts.load_cell(SHIPPED[name])
    (tmp_path / "cell.yaml").write_text(cell.to_yaml())
    again = mrts.load_cell(tmp_path / "cell.yaml")
    assert same_cell(cell, again)
    assert again.to_yaml() == cell.to_yaml()


@pytest.mark.parametrize("name", ["dual_ur5", "planar_dual_arm"])
def test_everything_that_a_file_can_say_comes_back(name, tmp_path):
    cell = equipped(mrts.load_cell(SHIPPED[name]), np.random.default_rng([21, 0]))
    path = tmp_path / "changed.yaml"
    text = cell.to_yaml(path)
    assert path.read_text(encoding="utf-8") == text
    again = mrts.load_cell(path)
    assert same_cell(cell, again)
    assert same_cell(cell, mrts.Cell.from_description(yaml.safe_load(text)))


@pytest.mark.quick
def test_hands_made_in_python_are_written_as_they_were_made(tmp_path):
    cell = mrts.load_cell(SHIPPED["squeeze"])
    hands = (
        {"pad": {"friction": 0.4, "normal": np.array([0, 0, 2.0]), "half_width": (0.03, 0.02), "force": [5, 100]}},
        {"suction": {"holding_force": 80, "friction": 0.5, "radius": 0.03, "normal": [0, 0, 1]}},
        {"gripper": {"force": 60, "friction": 0.5, "half_width": [0.02, 0.03], "axis": [0, 1, 0]}},
        {"rows": {"A": np.vstack([np.eye(6), -np.eye(6)]), "upper": np.full(12, 50.0)}},
        {"box": {"lower": [None, -5, -5, -5, -5, -5], "frame": "object"}},
    )
    cell = cell.with_values({f"robots.{robot.name}.contact": hands for robot in cell.robots})
    text = cell.to_yaml(tmp_path / "cell.yaml")
    assert "&" not in text  # written out, not referred to
    kinds = [next(iter(entry)) for entry in yaml.safe_load(text)["robots"][0]["contact"]]
    assert kinds == ["pad", "suction", "gripper", "rows", "box"]
    assert same_cell(cell, mrts.load_cell(tmp_path / "cell.yaml"))


def renamed(cell):
    return with_left(cell, contacts=(replace(cell.robots[0].contacts[0], name="palm"),))


REFUSED = {
    "reserve": (lambda cell: cell.with_reserve(0.1), "reserve: a cell file holds no reserve"),
    "limits": (lambda cell: cell.with_limits(sorted), "limits: a cell file holds no functions"),
    "velocities": (lambda cell: cell.without_velocity_limits(), "enforces_velocity_limits: .* cannot leave"),
    "first moments": (
        lambda cell: cell.with_load(cell.load + 0.1 * np.eye(10)[2]),
        r"load\[2\] = 0.1: a cell file cannot hold this value",
    ),
    "no folder": (lambda cell: replace(cell, folder=None), "folder: it is not known where its URDFs are"),
    "a position limit": (
        lambda cell: with_left(cell, position_lower=np.full(6, -0.5)),
        r"position_lower\[0\] = -0.5: a cell file",
    ),
    "a contact renamed": (renamed, r"robots\[0\].contacts\[0\].name = 'palm': a cell file cannot hold this value"),
}


@pytest.mark.quick
@pytest.mark.parametrize("what", REFUSED)
def test_what_a_file_cannot_hold_is_refused(what, tmp_path):
    change, message = REFUSED[what]
    cell = change(mrts.load_cell(SHIPPED["squeeze"]))
    with pytest.raises(mrts.InputError, match=rf"^cell 'squeeze': .*{message}"):
        cell.to_yaml(tmp_path / "cell.yaml")
    assert not (tmp_path / "cell.yaml").exists()
