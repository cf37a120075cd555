# SPDX-License-Identifier: MIT
"""Joints that carry the object: inverse kinematics along a path, or given joints that hold the grasps.

May import base to motion. Start at `coordinate.py`.
"""
