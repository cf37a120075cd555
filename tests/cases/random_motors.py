"""Motors for the arms of a cell: the same for all, or drawn."""

from dataclasses import replace

import numpy as np
from changed_robots import with_robots

from mrts.cell.robot import JointMotors


def equipped(cell, **given):
    """The cell with the same motors in every arm: a number for all joints or one for each, a curve for all."""
    robots = []
    for robot in cell.robots:
        n = len(robot.joints)
        columns = {name: np.full(n, value, dtype=float) for name, value in given.items() if name != "torque_speed"}
        if "torque_speed" in given:
            columns["torque_speed"] = (np.array(given["torque_speed"]),) * n
        robots.append(replace(robot, motors=replace(robot.motors, **columns)))
    return replace(cell, robots=tuple(robots))


def with_all_rates(cell):
    """A cell whose contact wrenches and joints change at limited rates; torque rates are given with the question."""
    return with_robots(equipped(cell, jerk=2000.0), contact_rate=np.full(len(cell.wrench_components), 20.0))


def drawn_motors(rng, cell):
    """The same cell with friction, rotor inertia and, of half of the arms, curves, in proportion to its torques."""
    robots = []
    for robot in cell.robots:
        n, torque, fastest = len(robot.joints), robot.torque_upper, rng.uniform(0.3, 3)
        curve = None
        if rng.random() < 0.5:
            curve = [np.array([[0, t], [0.3 * fastest, t], [1.2 * fastest, 0.3 * t]]) for t in torque]
        motors = replace(
            JointMotors.unknown(n),
            viscous=rng.uniform(0.02, 0.5) * torque / fastest,
            coulomb=rng.uniform(0, 0.2) * torque,
            armature=np.full(n, rng.uniform(0, 0.3)),
            torque_speed=(None,) * n if curve is None else tuple(curve),
        )
        robots.append(replace(robot, motors=motors))
    return replace(cell, robots=tuple(robots))
