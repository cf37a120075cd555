# SPDX-License-Identifier: MIT
"""A speed that varies along the path: the fastest r(t), bang-bang or smooth.

May import base to scaling. Start at `retime.py`.
"""
