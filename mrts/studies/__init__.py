# SPDX-License-Identifier: MIT
"""Many questions about a cell: its configurations, sweeps over its numbers.

May import base to identification. Start at `configurations.py`.
"""
