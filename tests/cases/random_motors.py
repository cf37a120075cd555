"""Motors for the arms of a cell: the same for all, or drawn."""

from dataclasses import replace

import numpy as np

from mrts.cell.motors import JointMotors


def equipped(cell, **given):
    """The same cell with the same motors at every joint; a curve is one for all."""
    robots = []
    for robot in cell.robots:
        n = len(robot.joints)
        motors = replace(
            JointMotors.unknown(n),
            **{
                name: (np.array(value),) * n if name == "torque_speed" else np.full(n, float(value))
                for name, value in given.items()
            },
        )
        robots.append(replace(robot, motors=motors))
    return replace(cell, robots=tuple(robots))


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
