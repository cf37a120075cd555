# SPDX-License-Identifier: MIT
"""Names of the formulations and of the ways to choose redundant torques; commands read them without NumPy."""

from typing import Literal, get_args

FormulationName = Literal["wrench", "torque"]
"""Which generated function states the program: `wrench_form` or `torque_form`."""

DistributionName = Literal["least-torque", "reserve"]
"""What redundant torques are chosen by: least weighted squares, or first the least largest share of any limit."""

DISTRIBUTIONS: tuple[DistributionName, ...] = get_args(DistributionName)

FORMULATIONS: tuple[FormulationName, ...] = get_args(FormulationName)
