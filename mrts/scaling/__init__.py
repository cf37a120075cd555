# SPDX-License-Identifier: MIT
"""One factor for the whole motion: the intersection (30), the choice of c², loads known within a box.

May import base to program. Start at `scale.py`.
"""
