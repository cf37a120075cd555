# SPDX-License-Identifier: MIT
"""Many questions about a cell: its configurations, what changes would do, sweeps over its numbers.

May import base to identification. Start at `configurations.py`.
"""
