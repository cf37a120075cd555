# SPDX-License-Identifier: MIT
"""One sample at a time: its rows, its range of c², its torques (the QP), and why it has none.

May import base to limits. Start at `sample_problem.py`.
"""

from typing import Literal, get_args

FormulationName = Literal["wrench", "torque"]
"""Of the generated functions `wrench_form`, `torque_form`."""

FORMULATIONS: tuple[FormulationName, ...] = get_args(FormulationName)
