# SPDX-License-Identifier: MIT
"""Joint torques over how fast they change, contact wrenches and accelerations likewise, with the limits of both."""

from matplotlib.axes import Axes

from mrts.figures.style import Draw, NotebookFigure, robot_figure
from mrts.figures.trajectory import draw_limited, draw_torques
from mrts.scaling.limit_use import limited_rate_kinds, limited_rates
from mrts.scaling.result import ScalingResult


def draw_torque_rates(axes: Axes, result: ScalingResult, robot: str) -> None:
    """How fast the joint torques of one robot change, from sample to sample, with their limits as thin lines.

    Args:
        axes: Where to draw.
        result: A result with a trajectory.
        robot: Name of the robot.

    Raises:
        ValueError: If there is no trajectory.
    """
    _draw_rates(axes, result, robot, "torque rate", "torque rate")


def draw_force_rates(axes: Axes, result: ScalingResult, robot: str) -> None:
    """How fast the force of one robot on the object changes; arguments as in `draw_torque_rates`."""
    _draw_rates(axes, result, robot, "wrench rate", "force rate", first="f")


def draw_moment_rates(axes: Axes, result: ScalingResult, robot: str) -> None:
    """How fast the moment of one robot on the object changes; arguments as in `draw_torque_rates`."""
    _draw_rates(axes, result, robot, "wrench rate", "moment rate", first="n")


def draw_jerks(axes: Axes, result: ScalingResult, robot: str) -> None:
    """The jerk of the joints of one robot, between samples; arguments as in `draw_torque_rates`."""
    _draw_rates(axes, result, robot, "jerk", "jerk")


OF_KIND: dict[str, tuple[Draw, ...]] = {
    "torque rate": (draw_torque_rates,),
    "wrench rate": (draw_force_rates, draw_moment_rates),
    "jerk": (draw_jerks,),
}
"""What draws each kind of rates."""


def rates_figure(result: ScalingResult, title: str) -> NotebookFigure:
    """Joint torques of every robot over their rates; below, whatever else changes at a limited rate.

    Args:
        result: A result with a trajectory.
        title: Title of the figure.

    Raises:
        ValueError: If there is no trajectory.
    """
    limited = limited_rate_kinds(result)
    kinds = [kind for kind in OF_KIND if kind in limited or kind == "torque rate"]
    return robot_figure(result, title, (draw_torques, *(draw for kind in kinds for draw in OF_KIND[kind])))


def _draw_rates(axes: Axes, result: ScalingResult, robot: str, kind: str, label: str, first: str = "") -> None:
    rates = limited_rates(result, kind, robot)
    draw_limited(axes, result, rates.only([name.startswith(first) for name in rates.names]), label, steps=True)
