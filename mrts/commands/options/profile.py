# SPDX-License-Identifier: MIT
"""Options of `mrts scale` that say which r(t) is asked for, and which of them go together."""

import argparse
from collections.abc import Iterator
from contextlib import contextmanager
from math import isfinite
from typing import TYPE_CHECKING, Any

from mrts.base.errors import InputError
from mrts.commands.options.common import numbers_option

if TYPE_CHECKING:
    from mrts.base.arrays import Array
    from mrts.cell.cell import Cell
    from mrts.program.rate_limits import Rates

PROFILES = ("constant", "optimal", "smooth")

GOES_WITH = {
    "--fastest, --nominal, --c2": ("constant",),
    "--start-speed": ("optimal", "smooth"),
    "--end-speed": ("optimal", "smooth"),
    "--rates": ("constant", "smooth"),
    "--weigh": ("smooth",),
    "--least-energy-in": ("smooth",),
    "--start-torque": ("smooth",),
    "--end-torque": ("smooth",),
    "--solver": ("constant",),
    "--what-if": ("constant", "optimal"),
}
"""The profiles that an option goes with; those that are not here go with all."""


def add_profile(scale: argparse.ArgumentParser) -> None:
    """Add the options that say which r(t) is asked for."""
    choice = scale.add_mutually_exclusive_group()
    choice.add_argument("--fastest", action="store_const", const="fastest", dest="select",
                        help="play as fast as the limits allow (default)")  # fmt: skip
    choice.add_argument("--nominal", action="store_const", const="nominal", dest="select", help="play as given, c² = 1")
    choice.add_argument("--c2", type=float, dest="select", metavar="VALUE", help="play at this c²")
    scale.add_argument("--profile", choices=PROFILES, default="constant",
                       help="one factor of speed, the fastest timing r(t), or a smooth one, the fastest whose torques "
                       "and accelerations change at limited rates (default: %(default)s)")  # fmt: skip
    scale.add_argument("--start-speed", type=float, metavar="R",
                       help="of the optimal and the smooth profile, as a multiple of the given speed, where the motion "
                       "does not start from rest (default: 0)")  # fmt: skip
    scale.add_argument("--end-speed", type=float, metavar="R", help="likewise at the end")
    scale.add_argument("--rates", type=rate_share, nargs="?", const=True, default=False, metavar="SHARE",
                       help="keep limits of rates: torque_rate, contact_rate and jerk of the cell file; with a number, "
                       "such as 11.5, joints without a torque_rate get that multiple of their torque limit per second "
                       "(always on in the smooth profile)")  # fmt: skip
    scale.add_argument("--weigh", metavar="KEY=VALUE,…",
                       help="what the smooth profile makes least: time=1,energy=1 (default: time=1); the energy is "
                       "∫ τᵀWτ dt")  # fmt: skip
    scale.add_argument("--least-energy-in", type=float, metavar="SECONDS",
                       help="the smooth profile of least energy that takes at most so long")  # fmt: skip
    for end in ("start", "end"):
        scale.add_argument(f"--{end}-torque", action="append", metavar="ROBOT=T,T,…",
                           help=f"torques that hold still at the {end} of the smooth profile, once for every robot "
                           "(default: any within the limits)")  # fmt: skip


def rate_share(text: str) -> float:
    """The number of `--rates`.

    Raises:
        InputError: If it is none that can be kept.
    """
    from mrts.base.argument_types import is_number
    from mrts.base.input_file import LARGEST_NUMBER

    try:
        share = float(text)
    except ValueError:
        share = 0.0
    if not is_number(share, 0, LARGEST_NUMBER) or share == 0:
        rule = f"must be a number > 0 and at most {LARGEST_NUMBER:.0e}, a multiple of torque limits per second, or none"
        raise InputError("--rates", f"{rule} to keep the cell file's rates alone.", value=text)
    return share


def check_profile(options: argparse.Namespace) -> None:
    """That the options given go with the profile.

    Raises:
        InputError: If one does not.
    """
    given = {name: name.removeprefix("--").replace("-", "_") for name in GOES_WITH} | {
        "--fastest, --nominal, --c2": "select"
    }
    for name, profiles in GOES_WITH.items():
        value = getattr(options, given[name])
        if value is not None and value is not False and options.profile not in profiles:
            rule = f"goes with --profile {' or '.join(profiles)}, not with {options.profile}."
            raise InputError(name, rule)
    if options.weigh is not None and options.least_energy_in is not None:
        raise InputError("--weigh", "does not go with --least-energy-in, which weighs the energy alone.")
    rates = options.profile == "smooth" or options.rates is not False
    if rates and options.distribute != "least-torque":
        rule = "does not go with limits of rates, which couple all samples: there torques are the least ones."
        raise InputError("--distribute", rule, value=options.distribute)
    if (rates or options.profile != "constant") and options.formulation != "wrench":
        rule = f"the {options.profile} profile{' within rates' if rates else ''} is found in the wrench form."
        raise InputError("--formulation", rule, value=options.formulation)


@contextmanager
def told_of(option: str) -> Iterator[None]:
    """What is wrong with an argument of Python is told of the option that gave it."""
    try:
        yield
    except InputError as error:
        value = None if error.value is True else error.value  # which stands for an option without a value
        raise InputError(option, error.rule, key=error.key, value=value) from None


def rates_option(options: argparse.Namespace, cell: "Cell") -> "Rates":
    """The rates that `--rates` and the profile ask for.

    Args:
        options: Of the line.
        cell: The cell.

    Raises:
        InputError: If the cell gives none, or too little for what is asked.
    """
    from mrts.program.rate_limits import rate_limits

    rates: Rates = options.rates or options.profile == "smooth"
    if rates is not False:
        with told_of("--rates"):
            rate_limits(cell, rates)
    return rates


def smooth_arguments(options: argparse.Namespace, cell: "Cell") -> dict[str, Any]:
    """What `mrts.retime` is asked beside what the optimal profile is asked; nothing for the optimal profile.

    Args:
        options: Of the line.
        cell: The cell.

    Raises:
        InputError: If an option breaks a rule.
    """
    if options.profile != "smooth":
        return {}
    from mrts.timing.retime import smooth_goal

    weights = None if options.weigh is None else numbers_option("--weigh", options.weigh, "time=1,energy=1")
    with told_of("--least-energy-in" if weights is None else "--weigh"):
        smooth_goal(weights, options.least_energy_in)
    return {
        "rates": rates_option(options, cell),
        "weigh": weights,
        "least_energy_in": options.least_energy_in,
        "start_torque": torque_option("--start-torque", options.start_torque, cell),
        "end_torque": torque_option("--end-torque", options.end_torque, cell),
    }


def torque_option(option: str, given: list[str] | None, cell: "Cell") -> "Array | None":
    """The torques of `--start-torque` or `--end-torque`, Shape (m,) [N m]; None if the option is not given."""
    import numpy as np

    if given is None:
        return None
    torques: dict[str, list[float]] = {}
    for text in given:
        name, _, numbers = text.partition("=")
        if name in torques:
            raise InputError(option, f"gives the robot '{name}' twice.", value=text)
        try:
            torques[name] = [_finite(number) for number in numbers.split(",")]
        except ValueError:
            raise InputError(option, "must be ROBOT=NUMBER,NUMBER,…, one a joint [N m].", value=text) from None
    names = [robot.name for robot in cell.robots]
    for name in torques:
        if name not in names:
            raise InputError(option, f"there is no such robot; there are {', '.join(names)}.", value=name)
    for robot in cell.robots:
        if robot.name not in torques:
            raise InputError(option, f"is needed once for every robot; '{robot.name}' is missing.")
        if len(torques[robot.name]) != len(robot.joints):
            rule = f"must be {len(robot.joints)} numbers for the robot '{robot.name}', one a joint."
            raise InputError(option, rule, value=torques[robot.name])
    return np.concatenate([torques[name] for name in names])


def _finite(text: str) -> float:
    """A number of a text.

    Raises:
        ValueError: If it is none, or not finite.
    """
    number = float(text)
    if not isfinite(number):
        raise ValueError(text)
    return number
