# SPDX-License-Identifier: MIT
"""Many questions about a cell at once: its configurations, ranked.

May import base to retiming. Start at `configurations.py`.
"""
