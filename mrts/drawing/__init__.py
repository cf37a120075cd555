# SPDX-License-Identifier: MIT
"""What scenes are drawn from, without any library: colours, shapes of arms and objects, where to look from.

May import base to layout. Start at `colours.py`.
"""
