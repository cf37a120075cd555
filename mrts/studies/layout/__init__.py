# SPDX-License-Identifier: MIT
"""The best layout: where arms stand and hold the object so that a motion may be played fastest.

May import base to sweeps. Start at `place.py`.
"""
