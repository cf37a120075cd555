"""Tables whose columns contradict each other: wrong units, signs, names, however few their digits and rows."""

import numpy as np
import pytest
from motion_tables import columns_of, object_columns, read, scaled, write_table

import mrts
from mrts.motion.velocity_profile import PROFILES


def swapped(columns, one, other):
    names = {one: other, other: one}
    return {names.get(name, name): values for name, values in columns.items()}


JOINT_MISTAKES = {
    "degrees a second": lambda columns: scaled(columns, "dq.", 180 / np.pi),
    "degrees": lambda columns: scaled(columns, "q.", 180 / np.pi),
    "sign of velocities": lambda columns: scaled(columns, "dq.left", -1),
    "sign of accelerations": lambda columns: scaled(columns, "ddq.right", -1),
    "accelerations too large by half": lambda columns: scaled(columns, "ddq.", 1.5),
    "milliseconds": lambda columns: scaled(columns, "t", 1000),
    "velocities swapped": lambda columns: swapped(columns, "dq.left/elbow", "dq.left/wrist_1_turn"),
    "no velocities": lambda columns: scaled(columns, "dq.", 0),
    "one arm late": lambda columns: {
        name: np.roll(values, 10) if "left" in name else values for name, values in columns.items()
    },
}


@pytest.mark.parametrize("mistake", JOINT_MISTAKES)
@pytest.mark.parametrize(("samples", "form"), [(101, ".12g"), (11, ".5g")])
def test_wrong_joint_tables_are_refused(tmp_path, dual_ur5, exact, mistake, samples, form):
    """At any number of digits and rows."""
    columns = JOINT_MISTAKES[mistake](columns_of(dual_ur5, exact["turn", samples][0]))
    with pytest.raises(mrts.MrtsError, match=r"do not lead|do not close|do not fit|position limit"):
        read(dual_ur5, write_table(tmp_path / "joints.csv", columns, form))


OBJECT_MISTAKES = {
    "millimetres a second": lambda columns: scaled(columns, "v", 1000),
    "degrees a second": lambda columns: scaled(columns, "w", 180 / np.pi),
    "axes swapped": lambda columns: swapped(columns, "vy", "vz"),
    "sign": lambda columns: scaled(columns, "vy", -1),
    "sign of accelerations": lambda columns: scaled(columns, "ay", -1),
    "milliseconds": lambda columns: scaled(columns, "t", 1000),
    "accelerations too large by half": lambda columns: scaled(columns, "a", 1.5),
}


@pytest.mark.parametrize("mistake", OBJECT_MISTAKES)
@pytest.mark.parametrize(("samples", "form"), [(101, ".12g"), (11, ".5g")])
def test_wrong_object_tables_are_refused(tmp_path, exact, mistake, samples, form):
    columns = OBJECT_MISTAKES[mistake](object_columns(exact["turn", samples][0].object, rates=True))
    with pytest.raises(mrts.InputError, match="do not lead"):
        mrts.load_motion(write_table(tmp_path / "object.csv", columns, form))


SMALL_MISTAKES = {
    "millimetres for metres": (1e-3, 1e-3),
    "sign": (-1, -1),
    "sign of accelerations": (1, -1),
    "accelerations twice": (1, 2),
}


@pytest.mark.parametrize("mistake", SMALL_MISTAKES)
@pytest.mark.parametrize(("length", "duration"), [(1e-4, 1.0), (1e-3, 60.0), (1e-5, 60.0)])
def test_wrong_tables_of_small_or_slow_motions_are_refused(length, duration, mistake):
    """What rounding may leave out is no more than a share of what moves."""
    u = np.linspace(0, 1, 101)
    s, ds, dds = PROFILES["cubic"](u)
    position, twist, acceleration = np.zeros((101, 3)), np.zeros((101, 6)), np.zeros((101, 6))
    position[:, 2], twist[:, 2], acceleration[:, 2] = length * s, length / duration * ds, length / duration**2 * dds
    eye = np.broadcast_to(np.eye(3), (101, 3, 3))
    assert mrts.ObjectMotion(u * duration, position, eye, twist, acceleration)
    rates, changes = SMALL_MISTAKES[mistake]
    with pytest.raises(mrts.InputError, match="do not lead"):
        mrts.ObjectMotion(u * duration, position, eye, rates * twist, changes * acceleration)
