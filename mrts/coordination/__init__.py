# SPDX-License-Identifier: MIT
"""Motion of the whole cell: every arm's joints along the object's motion, or given joints that hold it.

May import base to inverse_kinematics. Start at `coordinate.py`.
"""
