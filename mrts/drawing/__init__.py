# SPDX-License-Identifier: MIT
"""What pictures share, without any plotting library: lanes, axes, words, shapes.

May import base to layout. Start at `lanes.py`.
"""
