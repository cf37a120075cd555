# SPDX-License-Identifier: MIT
"""The fastest speed along a path whose torques and accelerations change at limited rates: one program over all of it.

May import base to reachability. Start at `program.py`.
"""
