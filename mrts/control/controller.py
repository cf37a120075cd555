# SPDX-License-Identifier: MIT
"""What plays a plan, and how the cell that it is played on differs from the plan's: numbers, each with a default."""

from collections.abc import Mapping
from dataclasses import dataclass, fields, replace
from typing import Annotated, Any, Self

import numpy as np

from mrts.base.arrays import Array, EqualByNumbers
from mrts.base.errors import InputError
from mrts.base.formats.record import Rule, Shape, check_attributes

Share = Annotated[float, Rule(ge=0, le=1)]
"""Of a whole, or some number of which no more than 1 makes sense [s, rad, rad/s]."""

MOST_STIFFNESS = 1e9
"""[N/m, N m/rad]."""

LEAST = {"mass": -0.99, "friction_error": -1.0}
"""Of the errors that may be negative."""


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
        InputError: If a number is out of its bounds, or a gain is negative.
    """

    rate: Annotated[float, Rule(ge=1, le=50_000)] = 1000.0
    delay: Share = 1e-3
    lag: Share = 3e-3
    bandwidth: Annotated[float, Rule(ge=0, le=1e4)] = 20.0
    damping: Annotated[float, Rule(ge=0, le=100)] = 1.0
    position_gain: Array | float | None = None
    velocity_gain: Array | float | None = None
    friction: bool = True
    resolution: Share = 0.0
    position_noise: Share = 0.0
    velocity_noise: Share = 0.0

    def __post_init__(self) -> None:
        check_attributes(self, Controller, "controller")
        for name in ("position_gain", "velocity_gain"):
            gain = getattr(self, name)
            if gain is not None and (gain.ndim > 1 or not np.all((gain >= 0) & np.isfinite(gain))):
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
        InputError: If a number is out of its bounds, or a stiffness is not > 0.
    """

    mass: Annotated[float, Rule(ge=LEAST["mass"], le=10)] = 0.03
    com: Annotated[Array, Shape(3, finite=True, least=-1, most=1)] = (0.0, 0.0, 0.0)  # type: ignore[assignment]  # then an array
    friction_error: Annotated[float, Rule(ge=LEAST["friction_error"], le=10)] = 0.2
    stiffness: Array = (1e7, 1e5)  # type: ignore[assignment]  # likewise
    damping_time: Annotated[float, Rule(ge=1e-5, le=1)] = 1e-4

    def __post_init__(self) -> None:
        check_attributes(self, PlantErrors, "errors")
        given = self.stiffness
        inside = np.all((given >= 1.0) & (given <= MOST_STIFFNESS))
        if given.shape[-1:] != (2,) or given.ndim > 2 or not inside:  # noqa: PLR2004 (one, or one a grasp)
            rule = f"must be 2 numbers from 1 to {MOST_STIFFNESS:g}."
            raise InputError("errors", rule, key="stiffness", value=given.tolist())
        given.setflags(write=False)

    def drawn(self, rng: np.random.Generator) -> Self:
        """Others of the same size: mass, com and friction evenly between minus and plus what they are here.

        No mass or friction becomes negative: they are drawn from `LEAST` on.
        """
        most = np.array([abs(self.mass), abs(self.friction_error), *np.abs(self.com)])
        least = np.maximum(-most, [*LEAST.values(), *[-np.inf] * 3])
        mass, friction, *com = rng.uniform(least, most)
        return replace(self, mass=float(mass), friction_error=float(friction), com=np.array(com))

    def opposite(self) -> Self:
        """The same errors the other way round, as far as `LEAST` admits."""
        other = {name: max(-getattr(self, name), least) for name, least in LEAST.items()}
        return replace(self, **other, com=-self.com)


def with_settings(
    controller: Controller, errors: PlantErrors, given: Mapping[str, Any]
) -> tuple[Controller, PlantErrors]:
    """Both with other values of some of their attributes.

    Raises:
        InputError: If neither has one of that name, or a value breaks a rule.
    """
    known = [{entry.name for entry in fields(of)} for of in (controller, errors)]
    if unknown := given.keys() - set.union(*known):
        rule = f"there is no such number. There are {', '.join(sorted(set.union(*known)))}."
        raise InputError("given", rule, value=min(unknown))
    own, others = ({name: given[name] for name in given.keys() & names} for names in known)
    return replace(controller, **own), replace(errors, **others)
