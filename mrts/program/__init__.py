# SPDX-License-Identifier: MIT
"""Programs: one sample (rows, range of c², torques, conflicts), between samples, a whole path with limited rates.

May import base to limits. Start at `sample_problem.py`.
"""
