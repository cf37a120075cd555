# SPDX-License-Identifier: MIT
"""What plays a plan, and how the cell that it is played on differs from the plan's: numbers, each with a default."""

from collections.abc import Mapping
from dataclasses import dataclass, fields, replace
from typing import Any, Self

import numpy as np

from mrts.base.argument_types import check_type, is_number
from mrts.base.arrays import Array, EqualByNumbers
from mrts.base.errors import InputError, as_array

MOST_NOISE = 1.0
"""[rad and rad/s]; no encoder is so bad."""

BOUNDS: dict[str, tuple[float, float]] = {
    "rate": (1.0, 50_000.0),
    "delay": (0.0, 1.0),
    "lag": (0.0, 1.0),
    "bandwidth": (0.0, 1e4),
    "damping": (0.0, 100.0),
    "resolution": (0.0, 1.0),
    "position_noise": (0.0, MOST_NOISE),
    "velocity_noise": (0.0, MOST_NOISE),
    "mass": (-0.99, 10.0),
    "friction_error": (-1.0, 10.0),
    "damping_time": (1e-5, 1.0),
}
"""Of numbers, both ends included."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Controller(EqualByNumbers):
    """A joint controller: the plan's torques and a PD of every joint by itself; of a prismatic joint read m, N.

    It measures joints only, neither wrenches nor the object, and cuts its commands at the cell's torque limits.

    Attributes:
        rate: Of its commands, each held until the next [Hz].
        delay: From a measurement to its command at the motors [s].
        lag: Time constant of a motor's torque [s].
        bandwidth: Natural frequency ω of the PD [rad/s].
        damping: Its damping ratio ζ.
        position_gain: One for all joints, or Shape (m,) [N m/rad]; None is I ω², where I is the inertia of the joint at
            the start of the plan, armature included, with the others held and no object.
        velocity_gain: Likewise [N m s/rad]; None is 2 ζ ω I.
        friction: Whether the plan's torques against friction are fed forward too.
        resolution: Step of torque commands, as a share of the joint's torque limit; 0 is none.
        position_noise: Standard deviation of measured positions [rad].
        velocity_noise: Likewise of velocities [rad/s].

    Raises:
        InputError: If a number is out of its `BOUNDS`, or a gain is negative.
    """

    rate: float = 1000.0
    delay: float = 1e-3
    lag: float = 3e-3
    bandwidth: float = 20.0
    damping: float = 1.0
    position_gain: Array | float | None = None
    velocity_gain: Array | float | None = None
    friction: bool = True
    resolution: float = 0.0
    position_noise: float = 0.0
    velocity_noise: float = 0.0

    def __post_init__(self) -> None:
        _check_bounds(self, "controller")
        check_type("controller: friction", self.friction, bool)
        for name in ("position_gain", "velocity_gain"):
            gain = getattr(self, name)
            given = as_array(name, 0.0 if gain is None else gain)
            if given.ndim > 1 or not np.all((given >= 0) & np.isfinite(given)):
                raise InputError("controller", "must be numbers >= 0: one, or one a joint.", key=name, value=gain)

    def gains(self, inertia: Array) -> tuple[Array, Array]:
        """Of positions and of velocities, each Shape (m,).

        Args:
            inertia: Of each joint, Shape (m,) [kg m²].

        Raises:
            InputError: If gains were given for another number of joints.
        """
        found = []
        for name, rule in (("position_gain", self.bandwidth**2), ("velocity_gain", 2 * self.damping * self.bandwidth)):
            given = getattr(self, name)
            gain = rule * inertia if given is None else np.asarray(given, dtype=np.float64)
            if gain.size not in {1, inertia.size}:
                raise InputError("controller", f"must be one, or one for each of {inertia.size} joints.", key=name)
            found.append(np.broadcast_to(gain, inertia.shape))
        return found[0], found[1]

    def to_json(self) -> dict[str, Any]:
        """Every number by name."""
        return _to_json(self)


@dataclass(frozen=True, kw_only=True, eq=False)
class PlantErrors(EqualByNumbers):
    """How the cell differs from the plan's, and how far its grasps give way.

    Attributes:
        mass: Share by which the object is heavier, its inertia with it.
        com: By what its centre of mass is off, object axes, Shape (3,) [m].
        friction_error: Share by which all friction of the motors is larger, dry friction at reversal too.
        stiffness: Of every grasp, or of each, against a displacement and a turn, Shape (2,) or (n, 2) [N/m, N m/rad].
        damping_time: Damping of a grasp as a share of its stiffness [s].

    Raises:
        InputError: If a number is out of its `BOUNDS`, or a stiffness is not > 0.
    """

    mass: float = 0.03
    com: Array = (0.0, 0.0, 0.0)  # type: ignore[assignment]  # an array once it is checked
    friction_error: float = 0.2
    stiffness: Array = (1e7, 1e5)  # type: ignore[assignment]  # likewise
    damping_time: float = 1e-4

    def __post_init__(self) -> None:
        _check_bounds(self, "errors")
        for name, low, high, columns, most in (("com", -1.0, 1.0, 3, 1), ("stiffness", 1.0, 1e9, 2, 2)):
            given = as_array(name, getattr(self, name))
            inside = np.all((given >= low) & (given <= high))
            if given.shape[-1:] != (columns,) or given.ndim > most or not inside:
                rule = f"must be {columns} numbers from {low:g} to {high:g}."
                raise InputError("errors", rule, key=name, value=given.tolist())
            given.setflags(write=False)
            object.__setattr__(self, name, given)

    def drawn(self, rng: np.random.Generator) -> Self:
        """Others of the same size: mass, com and friction evenly between minus and plus what they are here.

        No mass or friction becomes negative: where that is below their `BOUNDS`, they are drawn from these on.
        """
        most = np.array([abs(self.mass), abs(self.friction_error), *np.abs(self.com)])
        least = np.maximum(-most, [BOUNDS["mass"][0], BOUNDS["friction_error"][0], *[-np.inf] * 3])
        mass, friction, *com = rng.uniform(least, most)
        return replace(self, mass=float(mass), friction_error=float(friction), com=np.array(com))

    def opposite(self) -> Self:
        """The same errors the other way round, as far as `BOUNDS` admit."""
        mass, friction = (max(-getattr(self, name), BOUNDS[name][0]) for name in ("mass", "friction_error"))
        return replace(self, mass=mass, friction_error=friction, com=-self.com)

    def to_json(self) -> dict[str, Any]:
        """Every number by name."""
        return _to_json(self)


def with_settings(
    controller: Controller, errors: PlantErrors, given: Mapping[str, Any]
) -> tuple[Controller, PlantErrors]:
    """Both with other values of some of their attributes.

    Raises:
        InputError: If neither has one of that name, or a value breaks a rule.
    """
    found: list[Any] = []
    left = dict(given)
    for of in (controller, errors):
        own = {entry.name: left.pop(entry.name) for entry in fields(of) if entry.name in left}
        found.append(replace(of, **own))
    if left:
        known = [entry.name for of in (controller, errors) for entry in fields(of)]
        raise InputError("given", f"there is no such number. There are {', '.join(known)}.", value=next(iter(left)))
    return found[0], found[1]


def _check_bounds(of: Controller | PlantErrors, where: str) -> None:
    for entry in fields(of):
        bounds, value = BOUNDS.get(entry.name), getattr(of, entry.name)
        if bounds is not None and not is_number(value, *bounds):
            rule = f"must be a number from {bounds[0]:g} to {bounds[1]:g}."
            raise InputError(where, rule, key=entry.name, value=value)


def _to_json(of: Controller | PlantErrors) -> dict[str, Any]:
    values = {entry.name: getattr(of, entry.name) for entry in fields(of)}
    return {name: value.tolist() if isinstance(value, np.ndarray) else value for name, value in values.items()}
