# SPDX-License-Identifier: MIT
"""Exit codes of the verbs."""

FEASIBLE, INFEASIBLE, BAD_INPUT = 0, 1, 2
