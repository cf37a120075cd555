# SPDX-License-Identifier: MIT
"""Exit codes of the command line; one that a signal ended has 128 and its number."""

FEASIBLE, INFEASIBLE, BAD_INPUT = 0, 1, 2

DEFECT = 70
"""Mrts itself failed: EX_SOFTWARE of sysexits.h."""

PIPE_CLOSED = 141
"""What a shell reports of a program whose reader went away."""

SIGNALLED = 128
"""What a shell adds to the number of the signal that ended a program."""
