# SPDX-License-Identifier: MIT
"""One sample at a time: its rows, its range of c², its torques, and why it has none."""
