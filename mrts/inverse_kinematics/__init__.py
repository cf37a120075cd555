# SPDX-License-Identifier: MIT
"""Joints from poses: Newton steps along a path, closed forms, redundant arms, joint limits.

May import base to motion. Start at `grasp_tracking.py`.
"""
