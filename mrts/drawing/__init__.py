# SPDX-License-Identifier: MIT
"""What pictures share, without any plotting library: lanes, axes, words.

May import base to layout. Start at `lanes.py`.
"""
