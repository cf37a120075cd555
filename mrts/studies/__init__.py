# SPDX-License-Identifier: MIT
"""Questions about a cell beside one motion: its configurations, ranked; its motors, from recordings.

May import base to retiming. Start at `configurations.py`.
"""
