"""The figure of an identification shows its numbers."""

from pathlib import Path

import numpy as np
import pytest
from motor_recordings import exact_recording, random_motors, recording

import mrts
from mrts.figures import motor_figure


@pytest.fixture(scope="module")
def found(planar_cell):
    """A joint that stands still, and efforts with an offset."""
    joints, time, q, effort = exact_recording(planar_cell, random_motors(6), rate=200, still=(1,))
    return mrts.identify(planar_cell, recording(Path("recorded.csv"), joints, time, q, effort + 2.0))


@pytest.mark.quick
def test_friction_and_residual_are_those_of_the_result(found):
    arm = found.arm("left")
    figure = motor_figure(arm)
    assert len(figure.axes) == 9
    _, friction, residual = figure.axes[:3]
    dots, line = friction.get_lines()
    speed, torque = line.get_data()
    coulomb, viscous = arm.coulomb.value[0], arm.viscous.value[0]
    np.testing.assert_allclose(torque, np.array([-1, -1, 1, 1]) * coulomb + viscous * np.array(speed))
    x, y = dots.get_data()
    assert len(x) == np.count_nonzero(arm.used[:, 0])
    np.testing.assert_allclose(y, coulomb * np.sign(x) + viscous * x, atol=0.01)
    np.testing.assert_allclose(np.sqrt(np.mean(residual.get_lines()[0].get_ydata() ** 2)), arm.residual_rms[0])


def test_a_joint_that_stood_still_has_empty_axes(found):
    figure = motor_figure(found.arm("left"))
    figure.draw_without_rendering()
    assert all(len(line.get_xdata()) == 0 for line in figure.axes[5].get_lines())
