# SPDX-License-Identifier: MIT
"""Joints that carry the object: inverse kinematics along a path, given joints that hold the grasps; clearances of both.

May import base to cell. Start at `coordinate.py`.
"""
