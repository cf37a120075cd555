# SPDX-License-Identifier: MIT
"""The motors of a cell's arms, found from recordings: rotor inertia and friction.

May import base to timing. Start at `identify.py`.
"""
