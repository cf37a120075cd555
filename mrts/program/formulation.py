# SPDX-License-Identifier: MIT
"""What a program is built in, and what redundant torques are chosen by."""

from typing import Literal, get_args

FormulationName = Literal["wrench", "torque"]
"""Of the generated functions `wrench_form`, `torque_form`."""

DistributionName = Literal["least-torque", "reserve"]
"""What redundant torques are chosen by: least weighted squares, or first the least largest share of any limit."""

DISTRIBUTIONS: tuple[DistributionName, ...] = get_args(DistributionName)

FORMULATIONS: tuple[FormulationName, ...] = get_args(FormulationName)
